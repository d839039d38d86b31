"""Drives in which something goes wrong, and what is made of them."""

from types import SimpleNamespace

import pytest

from sim_stubs.body import Contacts
from sim_stubs.clock import SimulatedClock
from sim_stubs.faults import CATALOGUE, FaultSchedule, PlannedFault
from vizbot.bench import fault_run, fault_tables, faults
from vizbot.bench.camera_lock import CameraLock, LateTurns
from vizbot.bench.fault_drives import FaultDrive, FaultDriveResult, run_drive
from vizbot.bench.fault_missions import (
    PAIRS,
    FaultMission,
    FaultMissionResult,
    NearGoals,
    missions_in,
)
from vizbot.bench.fault_run import HungError, not_for_ever
from vizbot.bench.fault_scores import FaultScore, FaultSeries, score
from vizbot.bench.fault_watch import FaultStop, FaultWatch
from vizbot.bench.store import Store
from vizbot.bench.wall_clock_reflexes import ReflexLatency
from vizbot.core.errors import ConfigError

LATENCY = ReflexLatency(10, 10, 2.0, 8.0, 9.0, 200.0)
TURNS = LateTurns(0.1, 0.5, 4.0)
LOCK = CameraLock(TURNS, LateTurns(9.0, 11.0, 12.0), TURNS, 150, 0.2)


def result(after, crash="", drove_on=True, kept=True, rolling=True, happened=True):
    stop = FaultStop("bump", rolling, after, 0.01, 0.1)
    drive, line = FaultDrive(("bump",), 0), "/dev/pts/7: it stopped"
    return FaultDriveResult(drive, (stop,), 0.2, line, happened, drove_on, "", crash, kept)


@pytest.mark.parametrize(("name", "seed"), [("bump", 1), ("cliff", 1), ("port-vanishes", 2)])
def test_the_robot_stops_in_time_and_drives_on(name, seed):
    became = run_drive(FaultDrive((name,), seed))
    [stop] = became.stops
    assert stop.fault == name
    assert stop.rolling
    assert stop.in_time
    assert became.crash == ""
    assert became.happened
    assert became.drove_on
    assert became.map_kept
    assert became.noticed
    if name == "port-vanishes":
        assert stop.run_on > 0.1


def test_a_killed_program_leaves_wheels_at_rest():
    became = run_drive(FaultDrive(("process-killed",), 1))
    [stop] = became.stops
    assert stop.rolling
    assert 0.29 < stop.after <= 0.315
    assert became.reported == "killed"
    assert became.map_kept is None


def test_a_driver_that_crashes_is_seen(monkeypatch):
    def crash(*_):
        raise IndexError("no such wheel")

    monkeypatch.setattr(fault_run, "_APART", 0.0)
    monkeypatch.setattr("drivers.obedience.why_passive", crash)
    became = run_drive(FaultDrive(("mode-passive",), 1))
    assert became.crash == "IndexError: no such wheel"
    assert not became.drove_on


def test_a_program_that_hangs_is_ended_whatever_it_catches():
    caught = []
    with pytest.raises(HungError, match=r"not over after 0.05 s"), not_for_ever(0.05):
        while True:
            try:
                for _ in iter(int, 1):
                    pass
            except Exception:
                caught.append("this must not happen")
    assert caught == []


def watched(names, course, silent=0, before=(0.2, 0.2)):
    """Watch a course: what is told and felt in each period of 15 ms, from the time of 1 s.

    The base is silent in the first `silent` periods.
    """
    clock = SimulatedClock()
    body = SimpleNamespace(asked=(0.0, 0.0), contacts=Contacts(), stalls=False)
    base = SimpleNamespace(body=body, heard=True)
    planned = [PlannedFault(CATALOGUE[name], 1.0, 0.3) for name in names]
    watch = FaultWatch(base, FaultSchedule(planned, clock.now, 0), clock, 0.1)
    body.asked = before
    while clock.now() < 1.0:
        watch.publish()
        watch.advance(0.015)
        clock.sleep(0.015)
    for period, (asked, felt) in enumerate(course):
        base.heard = period >= silent
        body.contacts = Contacts(bump_left=felt)
        watch.publish()
        body.asked = asked
        watch.advance(0.015)
        clock.sleep(0.015)
    return watch


def test_a_stop_counts_from_the_frame_that_tells_to_the_end_of_the_period():
    watch = watched(["bump"], [((0.2, 0.2), False)] * 3 + [((0.2, 0.2), True)] * 2
                    + [((0.0, 0.0), True)])  # fmt: skip
    [stop] = watch.stops()
    assert (stop.rolling, stop.after, stop.within) == (True, 0.045, 0.1)
    assert stop.run_on == pytest.approx(0.006)
    assert not watch.drove_on


def test_who_does_not_stop_is_late_and_has_not_driven_on():
    watch = watched(["bump"], [((0.2, 0.2), True)] * 20)
    [stop] = watch.stops()
    assert stop.after is None
    assert not stop.in_time


def test_what_nobody_can_have_heard_of_does_not_show_and_a_frozen_camera_loosens_no_reflex():
    course = [((0.2, 0.2), True)] * 12 + [((0.0, 0.0), True)] * 20
    for silent, after in ((0, 0.195), (6, 0.105), (8, 0.075)):
        watch = watched(["bump", "camera-frozen"], course, silent)
        stops = {stop.fault: stop for stop in watch.stops()}
        assert (stops["bump"].after, stops["bump"].within) == (after, 0.1)
        assert stops["bump"].in_time == (after <= 0.1)
    unheard = watched(["bump", "stream-silent"], course, silent=32)
    assert [stop.fault for stop in unheard.stops()] == ["stream-silent"]
    assert not unheard.happened


def test_only_who_goes_ahead_after_it_has_driven_on():
    stopped = [((0.2, 0.2), True), ((0.0, 0.0), True)]
    assert not watched(["bump"], [*stopped, *[((-0.1, -0.1), False)] * 3]).drove_on
    passed = [((0.0, 0.0), False)] * 30
    assert watched(["stream-silent"], [*stopped, *passed, ((0.2, 0.2), False)]).drove_on
    assert not watched(["stream-silent"], [*stopped, ((0.2, 0.2), False)]).drove_on


def test_a_series_counts_what_was_late_crashed_or_lost():
    series = FaultSeries(("bump",), tuple(range(6)))
    became = [
        result(0.03),
        result(0.2, crash="ValueError: no"),
        result(None, drove_on=False),
        result(0.05, kept=False),
        result(0.0, rolling=False),
        result(0.03, happened=False),
    ]
    summed = score(series, became)
    assert (summed.in_time, summed.stops) == (3, 5)
    assert (summed.stopped_median, summed.stopped_max) == (0.04, 0.2)
    assert (summed.happened, summed.drove_on) == (5, 4)
    assert len(summed.crashes) == 1
    assert summed.maps_lost == 1
    assert summed.line == "it stopped"


def test_the_outcome_tells_runs_stops_and_goals_with_their_intervals():
    scores = [score(FaultSeries(("bump",), (0,)), [result(0.03)])]
    late = (FaultStop("bump", True, 0.3, 0.1, 0.1),)

    def mission(goal, faults, happened, reached, answer="", stops=()):
        asked = FaultMission(1000, goal, faults)
        return FaultMissionResult(asked, happened, reached, answer, 90, stops, "", True)

    missions = [
        mission("sofa", (), True, True),
        mission("sofa", ("bump",), True, True, stops=late),
        mission("sofa", ("imu-gap",), False, True),
        mission("bed", ("cliff",), True, False, "gone"),
        mission("bed", ("battery-low",), True, False),
    ]
    outcome = fault_tables.outcome(scores, missions, LATENCY, LOCK)
    assert outcome.summary["runs"] == 6
    assert outcome.summary["stopped_in_time"] == 0.5
    assert outcome.summary["goal_reached"] == 0.5
    assert outcome.summary["crashes"] == 0
    assert "gone" in outcome.text
    assert "median 2.0 ms" in outcome.text


def test_the_page_says_with_what_its_results_were_made(tmp_path):
    whole = FaultSeries(("bump",), tuple(range(100)))
    scores = [score(series, [result(0.03)]) for series in (whole, FaultSeries(("bump",), (0,)))]
    store = Store(tmp_path / "faults/drives.jsonl", FaultScore)
    store.add("an older key", "old", "a slow machine", *scores)
    store.add(faults._key(), "abc123", "two cores", scores[0])
    store.add(faults._key(), "quick", "two cores", scores[1])
    page = faults.write_page(tmp_path / "faults", fault_tables.outcome(scores, [], LATENCY, LOCK))
    assert page == tmp_path / "faults.md"
    assert "run at abc123 on two cores." in page.read_text()
    assert "| bump " in page.read_text()


def test_what_is_run_is_every_fault_and_every_pair():
    series = faults.series_of(quick=False)
    assert {s.faults[0] for s in series if len(s.faults) == 1} == set(CATALOGUE)
    count = len(CATALOGUE)
    assert sum(len(s.faults) == 2 for s in series) == count * (count - 1) // 2
    assert all(len(s.seeds) == (100 if len(s.faults) == 1 else 3) for s in series)


def test_missions_are_every_fault_in_each_home_and_twenty_pairs_in_the_first():
    homes = [NearGoals(home, ("sofa", "bed")) for home in (1000, 1001, 1002)]
    missions = missions_in(homes)
    for home in homes:
        alone = {m.faults[0] for m in missions if m.home == home.home and len(m.faults) == 1}
        assert alone == set(CATALOGUE)
    pairs = [m for m in missions if len(m.faults) == 2]
    assert len(pairs) == len(set(PAIRS)) == 20
    assert {m.home for m in pairs} == {1000}
    assert {name for pair in PAIRS for name in pair} <= set(CATALOGUE)
    plain = {(m.home, m.goal) for m in missions if not m.faults}
    assert plain == {(m.home, m.goal) for m in missions}


def test_homes_that_training_saw_are_refused():
    with pytest.raises(ConfigError, match="training home"):
        faults.require_homes([1000, 7])


@pytest.mark.parametrize(
    ("asked", "rests"),
    [
        ((0.0, 0.0), True),
        ((-0.1, -0.1), True),
        ((-0.12, 0.13), True),  # it turns on the spot, with speeds that are rounded
        ((0.03, 0.03), False),
        ((0.1, 0.2), False),
        ((-0.3, -0.1), False),  # it backs off in a curve, and does not see where
    ],
)
def test_without_depth_the_robot_must_not_go_ahead(asked, rests):
    [stop] = watched(["black-depth"], [(asked, False)] * 40).stops()
    assert (stop.after is not None) == rests


def test_without_depth_a_turn_is_no_stop_for_good():
    turn, ahead, rest = ((-0.1, 0.1), False), ((0.2, 0.2), False), ((0.0, 0.0), False)
    [straight] = watched(["black-depth"], [ahead] * 17 + [rest] * 40).stops()
    [turned] = watched(
        ["black-depth"], [ahead] * 9 + [turn] * 2 + [ahead] * 6 + [rest] * 40
    ).stops()
    assert turned.rolling and straight.rolling
    assert turned.after == straight.after > 0.1
    assert 0.0 < turned.run_on < straight.run_on


def test_a_robot_that_only_turns_has_nothing_to_stop():
    turn = ((-0.1, 0.1), False)
    [stop] = watched(["black-depth"], [turn] * 40, before=(-0.1, 0.1)).stops()
    assert not stop.rolling


def test_a_robot_that_bumped_must_rest_and_not_turn():
    [stop] = watched(["bump"], [((-0.12, 0.13), True)] * 40).stops()
    assert stop.after is None
