"""Drives in which something goes wrong, and what is made of them."""

import pytest

from sim_stubs.faults import CATALOGUE
from vizbot.bench import faults
from vizbot.bench.fault_drives import FaultDrive, FaultDriveResult, run_drive
from vizbot.bench.fault_missions import (
    PAIRS,
    FaultMission,
    FaultMissionResult,
    NearGoals,
    missions_in,
)
from vizbot.bench.fault_scores import FaultSeries, score
from vizbot.bench.fault_watch import FaultStop
from vizbot.bench.wall_clock_reflexes import ReflexLatency
from vizbot.core.errors import ConfigError

LATENCY = ReflexLatency(10, 10, 2.0, 8.0, 9.0, 200.0)


def result(name, after, crash="", moved=True, kept=True, seed=0, within=0.1):
    stop = FaultStop(name, True, after, 0.01, within)
    drive = FaultDrive((name,), seed)
    return FaultDriveResult(drive, (stop,), 0.2, "/dev/pts/7: it stopped", moved, "", crash, kept)


@pytest.mark.parametrize("name", ["bump", "camera-frozen", "port-vanishes"])
def test_the_robot_stops_in_time_and_drives_on(name):
    became = run_drive(FaultDrive((name,), 1))
    [stop] = became.stops
    assert stop.fault == name
    assert stop.rolling
    assert stop.in_time
    assert stop.after is not None
    assert became.crash == ""
    assert became.map_kept
    assert became.moved_again
    assert became.noticed
    if name == "port-vanishes":
        assert stop.within is None
        assert stop.run_on > 0.1


def test_a_killed_program_leaves_wheels_at_rest():
    became = run_drive(FaultDrive(("process-killed",), 1))
    [stop] = became.stops
    assert stop.rolling
    assert 0.29 < stop.after <= 0.315
    assert became.reported == "killed"


def test_a_silent_base_tells_of_no_bump_so_the_limit_of_the_silence_holds():
    became = run_drive(FaultDrive(("stream-silent", "wheel-drop"), 1))
    assert {stop.fault: stop.within for stop in became.stops}["wheel-drop"] == 0.3
    assert all(stop.in_time for stop in became.stops)


def test_a_series_counts_what_was_late_crashed_or_lost():
    series = FaultSeries(("bump",), (0, 1, 2, 3))
    became = [
        result("bump", 0.03),
        result("bump", 0.2, crash="ValueError: no"),
        result("bump", None, moved=False),
        result("bump", 0.05, kept=False),
    ]
    summed = score(series, became)
    assert (summed.in_time, summed.limits) == (2, 4)
    assert (summed.stopped_median, summed.stopped_max) == (0.05, 0.2)
    assert summed.drove_on == 3
    assert summed.crashes == ("ValueError: no",)
    assert summed.maps_lost == 1
    assert summed.line == "it stopped"


def test_the_outcome_tells_runs_stops_and_goals_with_their_intervals():
    scores = [score(FaultSeries(("bump",), (0,)), [result("bump", 0.03)])]
    missions = [
        FaultMissionResult(FaultMission(1000, "sofa", ()), True, "", 90, (), "", True),
        FaultMissionResult(FaultMission(1000, "sofa", ("bump",)), True, "", 99, (), "", True),
        FaultMissionResult(FaultMission(1000, "bed", ("cliff",)), False, "gone", 9, (), "", True),
        FaultMissionResult(FaultMission(1000, "bed", ("battery-low",)), False, "", 9, (), "", True),
    ]
    outcome = faults.outcome(scores, missions, LATENCY)
    assert outcome.summary["runs"] == 5
    assert outcome.summary["stopped_in_time"] == 1.0
    assert outcome.summary["goal_reached"] == 0.5
    assert outcome.summary["crashes"] == 0
    assert "gone" in outcome.text
    assert "median 2.0 ms" in outcome.text


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
