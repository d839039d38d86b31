"""What a run leaves behind when its disk fills up or the program ends early."""

import json
import os
import threading
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import vizbot.recorder
from mapping import map_bundle
from mapping.map_saver import MapSaver
from tests.helpers.bundles import Snapshot, assert_same, bundle_of
from tests.helpers.failing import raising
from vizbot.config import Config
from vizbot.core.errors import ConfigError, MapError
from vizbot.core.observer import Effort, GoalReport, Outcome
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import STOP, Twist
from vizbot.recorder import Recorder


def step(stamp):
    return SimpleNamespace(
        frame=SimpleNamespace(stamp=stamp),
        estimate=SimpleNamespace(T_map_cam=np.eye(4)),
        T_map_base=np.eye(4),
        command=Twist(0.2, -0.5),
    )


@pytest.fixture
def recorder(tmp_path):
    return Recorder(tmp_path / "run", Config())


def test_the_map_is_kept_every_ten_seconds(recorder, caplog):
    asked = []

    def now():
        asked.append(1)
        return Snapshot(bundle_of())

    recorder.keep_map(now, SimulatedClock())
    kept = []
    for stamp in range(0, 36, 2):
        recorder.on_step(step(float(stamp)))
        kept.append((recorder.folder / "map").exists())
    del kept[5]  # at 10 s: the work goes on beside the run
    assert kept == 5 * [False] + 12 * [True]
    assert len(asked) == 3
    assert caplog.text == ""
    assert len(map_bundle.load(recorder.folder / "map").keyframes.ids)
    assert not (recorder.folder / "metrics.json").exists()


def test_the_map_is_joined_beside_the_run(recorder):
    joined_by = []

    class Watched(Snapshot):
        def bundle(self):
            joined_by.append(threading.current_thread())
            return super().bundle()

    recorder.keep_map(lambda: Watched(bundle_of()), SimulatedClock())
    for stamp in (0.0, 11.0):
        recorder.on_step(step(stamp))
    recorder.finish(None, {})
    assert len(joined_by) == 1 and joined_by[0] is not threading.current_thread()


@pytest.mark.parametrize(
    "error", [MapError("No space left on device"), OSError("No space left on device")]
)
def test_a_map_that_cannot_be_saved_costs_a_line_and_not_the_run(
    recorder, monkeypatch, caplog, error
):
    recorder.keep_map(lambda: Snapshot(bundle_of()), SimulatedClock())
    monkeypatch.setattr(MapSaver, "save", raising(error))
    for stamp in (0.0, 11.0, 12.0):
        recorder.on_step(step(stamp))
    assert caplog.text.count("No space left on device; the run goes on") == 1
    monkeypatch.undo()
    recorder.finish(bundle_of, {})
    assert len(map_bundle.load(recorder.folder / "map").keyframes.ids)


def test_a_map_that_could_not_be_loaded_never_takes_the_place_of_an_older_one(recorder, caplog):
    good = bundle_of()
    bad = replace(good, intrinsics=replace(good.intrinsics, fx=1e30))
    bundles = iter([good, bad])
    recorder.keep_map(lambda: Snapshot(next(bundles)), SimulatedClock())
    for stamp in (0.0, 61.0, 122.0, 123.0):
        recorder.on_step(step(stamp))
    metrics, lost = recorder.finish(lambda: bad, {"success": True})
    assert isinstance(lost, MapError) and "is not saved" in str(lost)
    assert metrics["map"] is None
    assert metrics["map_error"] == (
        f"{lost}; an earlier map of this run is in {recorder.folder / 'map'}"
    )
    assert json.loads((recorder.folder / "metrics.json").read_text()) == metrics
    assert caplog.text.count("the run goes on") == 1
    assert_same(map_bundle.load(recorder.folder / "map"), good)
    assert (recorder.folder / "trajectory.tum").exists()


def test_space_for_the_map_is_held_until_the_end(recorder, tmp_path):
    def held():
        return sum(
            opened.stat().st_size
            for opened in Path("/proc/self/fd").iterdir()
            if os.path.realpath(opened).startswith(str(tmp_path))
            and str(opened.readlink()).endswith("(deleted)")
        )

    assert held() == vizbot.recorder._RESERVE
    assert sorted(path.name for path in recorder.folder.iterdir()) == [
        "commands.csv", "config.toml", "trajectory.tum",
    ]  # fmt: skip
    recorder.finish(bundle_of, {"success": True})
    assert held() == 0
    assert len(map_bundle.load(recorder.folder / "map").keyframes.ids)


def test_a_disk_without_space_is_refused_at_the_start(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "posix_fallocate", raising(OSError(28, "No space left on device")))
    with pytest.raises(ConfigError, match=r"No space left on device \(a run needs 200 MB\)"):
        Recorder(tmp_path / "run", Config())
    monkeypatch.undo()
    Recorder(tmp_path / "run", Config())  # the next try is not refused


def test_a_run_that_ended_before_its_first_step_went_nowhere(recorder):
    assert recorder.path_length == 0.0
    recorder.on_step(step(0.25))
    assert recorder.path_length == 0.0


def test_what_the_base_was_told_is_kept(recorder):
    for stamp in (0.25, 0.5):
        recorder.on_step(step(stamp))
    recorder.finish(bundle_of, {})
    assert kept_commands(recorder) == [
        "stamp,linear,angular,by", "0.250,0.200,-0.500,robot", "0.500,0.200,-0.500,robot",
    ]  # fmt: skip


def test_where_people_may_drive_what_the_base_was_sent_is_kept_with_who_gave_it(recorder):
    clock = SimulatedClock(period=0.5)
    sent = recorder.keep_commands(clock)
    commands = ("robot", Twist(0.1, 0.0)), *[('ann, "me"', Twist(0.0, 0.5))] * 3, ("stop", STOP)
    for command in commands:
        sent(*command)
        recorder.on_step(step(100.0 + clock.now()))
        clock.sleep(0.5)
    recorder.finish(bundle_of, {})
    assert kept_commands(recorder) == [
        "stamp,linear,angular,by", "100.000,0.100,0.000,robot",
        '100.500,0.000,0.500,"ann, ""me"""', "102.000,0.000,0.000,stop",
    ]  # fmt: skip


def test_commands_sent_before_any_frame_came_are_kept_on_their_own_clock(recorder):
    recorder.keep_commands(SimulatedClock())("stop", STOP)
    recorder.finish(lambda: None, {})
    assert kept_commands(recorder)[1:] == ["0.000,0.000,0.000,stop"]


def kept_commands(recorder):
    return (recorder.folder / "commands.csv").read_text().splitlines()


def test_what_became_of_each_goal_is_kept_with_what_people_say_of_it(recorder):
    found = GoalReport("sofa", Outcome.ARRIVED, "92% sure", (), effort=Effort(50.04, 12.345))
    wrong = GoalReport("sofa", Outcome.ARRIVED, "80% sure", (), threshold=0.79333)
    for report in (found, wrong, GoalReport("bed", Outcome.NOT_FOUND, "nowhere", ())):
        recorder.on_goal(report)
    recorder.keep_verdict(wrong, True)
    recorder.keep_verdict(wrong, False)
    recorder.keep_verdict(found, True)
    assert [goal["confirmed"] for goal in recorder.goals] == [True, False, None]
    assert (recorder.goals[0]["seconds"], recorder.goals[0]["way"]) == (50.0, 12.35)
    assert [goal["threshold"] for goal in recorder.goals] == [None, 0.7933, None]
    assert json.loads(json.dumps(recorder.goals)) == recorder.goals


def test_what_people_say_on_the_way_is_kept_with_the_goal_that_was_looked_for(recorder):
    recorder.keep_verdict_on_way(np.array([1.23456, -2.0]), False)
    recorder.keep_verdict_on_way(np.array([3.0, 0.5]), True)
    for goal in ("sofa", "bed"):
        recorder.on_goal(GoalReport(goal, Outcome.ARRIVED, "92% sure", ()))
    sofa, bed = recorder.goals
    assert sofa["judged_on_the_way"] == [
        {"position": [1.235, -2.0], "confirmed": False},
        {"position": [3.0, 0.5], "confirmed": True},
    ]
    assert bed["judged_on_the_way"] == []
