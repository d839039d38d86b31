import os
import subprocess
import threading
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.harness.fingerprint import ROOT
from benchmarks.loop import bench, rehearsal
from benchmarks.loop.bench import longest_over_p95
from benchmarks.loop.rehearsal import (
    PrintedStep,
    Tree,
    checked_out,
    mean_tick,
    processor_time,
    rehearse,
    rival,
)
from benchmarks.loop.ticks import StageTime, StageTimer, Ticks, blown_up, rest_of
from benchmarks.loop.waits import DIMENSION, SpanTimer, Waits, widened
from mapping.clip.places.likeliest_places import belief_of_map
from mapping.clip.scores import Query
from tests.helpers.bundles import bundle_of
from vizbot.core.errors import ConfigError, VizbotError


def worked(seconds):
    """Keep this thread busy for so long."""
    until = time.thread_time() + seconds
    while time.thread_time() < until:
        pass


def test_time_of_a_stage_inside_another_is_its_own_alone(monkeypatch):
    class Outer:
        def run(self):
            worked(0.02)
            Inner().run()

    class Inner:
        def run(self):
            worked(0.05)

    monkeypatch.setattr(
        "benchmarks.loop.ticks.STAGES", (("outer", Outer, ("run",)), ("inner", Inner, ("run",)))
    )
    timer, original = StageTimer(), Outer.run
    timer.times = {"outer": StageTime(), "inner": StageTime()}
    with timer.installed():
        Outer().run()
        assert timer.times["inner"].processor == 0.0  # it does not measure yet
        timer.measuring = True
        for _ in range(2):
            Outer().run()
    assert Outer.run is original
    assert 0.04 <= timer.times["outer"].processor < 0.1
    assert timer.times["inner"].processor >= 0.1
    assert timer.times["inner"].wall >= timer.times["inner"].processor - 0.01


def test_the_rest_of_ticks_has_the_processor_time_of_the_video_and_not_its_wall_time():
    stages = {"tracking": StageTime(2.0, 3.0), "video": StageTime(4.0, 5.0)}
    assert rest_of(stages, wall=10.0, processor=7.5) == StageTime(1.5, 7.0)
    assert rest_of(stages, wall=1.0, processor=1.0) == StageTime()


def test_a_mean_tick_leaves_out_what_came_before_the_first_printed_step():
    printed = [PrintedStep(0, 10.0, 7.0), PrintedStep(25, 12.0, 8.0), PrintedStep(75, 17.5, 10.0)]
    found = mean_tick(printed, "digest")
    assert found.steps == 75
    assert found.wall == pytest.approx(0.1)
    assert found.processor == pytest.approx(0.04)


def test_the_processor_time_of_a_process_is_read_as_the_kernel_counts_it():
    worked(0.1)
    used = processor_time(Path("/proc/self/stat"))
    assert used == pytest.approx(sum(os.times()[:2]), abs=0.05)


def test_the_longest_tick_counts_from_the_first_motion_on():
    wall = (9.0, 9.0, *(98 * [0.1]), 0.3)
    ticks = Ticks(wall, wall, (False, False, *(99 * [True])), 0, {})
    assert longest_over_p95(ticks) == pytest.approx(3.0)


def test_a_blown_up_map_has_more_of_the_same_elements_in_their_order():
    bundle = bundle_of()
    bundle = bundle if len(bundle.elements.frames) else pytest.fail("no elements")
    many = blown_up(bundle, 500).elements
    assert len(many.keyframes) == 500
    pairs = set(
        zip(bundle.elements.keyframes.tolist(), bundle.elements.frames.tolist(), strict=True)
    )
    assert set(zip(many.keyframes.tolist(), many.frames.tolist(), strict=True)) == pairs
    np.testing.assert_allclose(np.linalg.norm(many.embeddings, axis=1), 1.0, atol=1e-5)


def test_a_blown_up_map_has_as_many_more_views_of_places_and_they_can_be_believed():
    bundle = bundle_of()
    count = len(bundle.elements.frames)
    many = blown_up(bundle, 3 * count)
    rows, before = many.places, bundle.places
    assert len(rows) == 3 * len(before)
    source = np.sort(np.arange(3 * count) % count)
    for copy in range(3):  # of one row they lie side by side, so that frames stay in order
        np.testing.assert_array_equal(source[rows.elements[copy::3]], before.elements)
    assert (np.diff(rows.frames) >= 0).all()
    assert len(np.unique(rows.elements)) == 3 * len(np.unique(before.elements))
    assert len(many.statistics) == 3 * count
    question = Query(many.elements.embeddings[0], None)
    belief = belief_of_map(
        many.place_map(),
        many.keyframes.poses(),
        many.elements.embeddings,
        many.statistics,
        many.pictures,
        question,
    )
    assert belief.seen.any()


def test_a_map_of_more_elements_is_cut_with_its_views_of_places():
    bundle = bundle_of()
    count = len(bundle.elements.frames) - 4
    few = blown_up(bundle, count)
    assert len(few.elements.frames) == count
    whole = (bundle.places.elements < count).all(axis=1)
    assert 0 < whole.sum() < len(whole)
    np.testing.assert_array_equal(few.places.elements, bundle.places.elements[whole])


def test_a_rival_keeps_a_core_busy_and_ends():
    with rival():
        children = subprocess.run(
            ["pgrep", "-P", str(os.getpid()), "-f", "getppid\\(\\) == parent: pass"],
            capture_output=True,
            text=True,
        ).stdout.split()
        assert len(children) == 1
        stat = Path(f"/proc/{children[0]}/stat")
        deadline = time.monotonic() + 10.0
        while processor_time(stat) < 0.1 and time.monotonic() < deadline:
            time.sleep(0.02)
        assert processor_time(stat) >= 0.1
    assert not stat.exists()


@pytest.fixture
def tree(tmp_path):
    """A tree whose `vizbot dry-run` prints steps and writes what a run does."""
    package = tmp_path / "vizbot"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "__main__.py").write_text(
        "import os, sys, pathlib, time\n"
        "out = pathlib.Path(sys.argv[sys.argv.index('--out') + 1]); out.mkdir()\n"
        "assert 'OMP_WAIT_POLICY' not in os.environ and 'OMP_NUM_THREADS' not in os.environ\n"
        "(out / 'trajectory.tum').write_text('poses'); (out / 'commands.csv').write_text('a')\n"
        "goal = sys.argv[2]\n"
        "for step in (0, 25, 50)[: 1 if goal == 'nothing' else 3]:\n"
        "    print(f'step {step:4d}  {goal}: exploring', file=sys.stderr, flush=True)\n"
        "    time.sleep(0.1)\n"
        "print('vizbot: it is broken', file=sys.stderr)\n"
    )
    return Tree(tmp_path)


def test_a_rehearsal_is_timed_by_the_steps_that_it_prints(tree, monkeypatch):
    monkeypatch.setenv("OMP_WAIT_POLICY", "passive")
    found = rehearse(tree, "1100", "sofa", 50)
    assert found.steps == 50
    assert 0.003 <= found.wall < 0.05  # the first line may be read late
    assert found.commands == rehearse(tree, "1100", "sofa", 50).commands


def test_a_rehearsal_that_ends_early_is_an_error_with_its_last_line(tree):
    with pytest.raises(VizbotError, match="ended early: vizbot: it is broken"):
        rehearse(tree, "1100", "nothing", 50)


def test_an_unknown_commit_is_one_line():
    if not (ROOT / ".git").exists():
        pytest.skip("no repository here")
    with (
        pytest.raises(ConfigError, match=r"--against nosuchcommit: .*nosuchcommit"),
        checked_out("nosuchcommit"),
    ):
        pass


def test_homes_are_compared_in_turns_and_told_with_their_spread(monkeypatch):
    walls = iter([0.1, 0.2, 0.1, 0.3, 0.1, 0.4])
    order = []

    def rehearse(tree, home, goal, steps):
        order.append(tree)
        return rehearsal.Rehearsal(next(walls), 0.05, steps, "same")

    monkeypatch.setattr(bench, "rehearse", rehearse)
    there = SimpleNamespace(path="there")
    [row] = bench._compare(bench.LoopBench("before", ("1100",), 3, 50), there)
    assert order == 3 * [bench.HERE, there]
    assert (row["speedup"], row["slowest"], row["fastest"]) == (3.0, 2.0, 4.0)
    assert row["same_commands"]
    assert (row["here_ms"], row["there_ms"]) == (100.0, 300.0)


def test_a_span_counts_the_time_of_its_thread_once_and_of_no_other():
    class Growing:
        def add(self):
            worked(0.02)
            self.reach()

        def reach(self):
            worked(0.02)

    timer, original = SpanTimer(), Growing.add
    with timer.installed(((Growing, "add"), (Growing, "reach"))):
        Growing().add()
        other = threading.Thread(target=Growing().add)
        spent = timer.spent
        other.start()
        other.join()
    assert spent >= 0.04 and timer.spent == spent
    assert Growing.add is original


def test_a_tick_waits_for_what_its_thread_does_and_for_what_others_hold():
    own = Waits((0.001, 0.03, 0.002), held_in_peace=0.02, held=0.04, answers=1, saves=1, elements=9)
    assert own.longest == 0.03
    assert replace(own, held=0.09).longest == pytest.approx(0.07)


def test_wider_embeddings_have_the_same_cosines():
    rows = np.random.default_rng(0).normal(size=(5, 7)).astype(np.float32)
    wide = widened(rows)
    assert wide.shape == (5, DIMENSION)
    np.testing.assert_allclose(wide @ wide.T, rows @ rows.T, rtol=1e-5)
