"""The bench of waiting times: what counts as the first tick, and what is said of a failure."""

from dataclasses import replace

import pytest

from benchmarks.loop import startup
from benchmarks.loop.startup import Wait, is_first_tick_in, measure_startup, median_wait
from tests.helpers.served import step
from vizbot.commands.progress import Progress
from vizbot.core.errors import VizbotError


def test_the_first_tick_is_the_line_of_the_first_step_and_nothing_behind_it_is_read():
    lines = iter(
        [
            "world 1101: a home with held-out furniture\n",
            "step size 0 is not a tick\n",
            "step    1 of 1000  sofa: standing still  probability - (enough: 80%)  to go -\n",
            "step   25  sofa: looking around\n",
        ]
    )
    assert is_first_tick_in(lines)
    assert next(lines).startswith("step   25")


def test_what_a_run_prints_first_is_its_first_tick(capsys):
    Progress(1000).on_step(replace(step(0), goal="sofa"))
    assert is_first_tick_in(capsys.readouterr().err.splitlines(keepends=True))
    assert is_first_tick_in(["step    0  sofa: standing still  best similarity -  to go -\n"])


@pytest.mark.parametrize("said", [[], ["vizbot: no\n"], ["step   10  sofa\n"], ["  step 0\n"]])
def test_without_that_line_there_was_no_tick(said):
    assert not is_first_tick_in(said)


def test_wall_and_processor_have_medians_of_their_own():
    assert median_wait([Wait(3, 1), Wait(1, 9), Wait(2, 5)]) == Wait(2, 5)


def test_a_process_that_ends_otherwise_is_an_error_with_its_last_line(tmp_path):
    with pytest.raises(VizbotError, match=r"map query .*it said: vizbot: no map at"):
        measure_startup(tmp_path / "nowhere", runs=1)


def test_each_wait_is_the_median_without_the_first_process(monkeypatch, tmp_path):
    taken = iter(range(100))

    def waited(*_):
        return Wait(float(next(taken)), 0.5)

    monkeypatch.setattr(startup, "_until_end", waited)
    monkeypatch.setattr(startup, "_until_first_tick", waited)
    measured = measure_startup(tmp_path, runs=3)
    assert measured == {
        "query_s": Wait(10.0, 0.5), "refused_s": Wait(11.0, 0.5), "first_tick_s": Wait(12.0, 0.5),
        "stop_s": Wait(2.0, 0.5),
    }  # fmt: skip


@pytest.mark.parametrize(
    "wait",
    [
        lambda: startup._stops(1)[0],
        lambda: startup._until_end(("dry-run", "sofa", "--world", "nosuchworld"), 1),
    ],
    ids=["a stop", "a refusal"],
)
def test_a_stop_and_a_refusal_take_time_on_the_wall_and_on_a_processor(wait):
    waited = wait()
    assert waited.wall > 0.0 and waited.processor > 0.0
