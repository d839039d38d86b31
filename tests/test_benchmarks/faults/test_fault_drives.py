"""Drives in which something goes wrong, and what is made of them."""

from contextlib import suppress
from dataclasses import replace

import pytest

from benchmarks.faults import bench as faults
from benchmarks.faults import drives as fault_drives
from benchmarks.faults import run as fault_run
from benchmarks.faults import tables as fault_tables
from benchmarks.faults.bench import faults_page
from benchmarks.faults.drives import FaultDrive, FaultDriveResult, run_drive
from benchmarks.faults.missions import (
    PAIRS,
    FaultMission,
    FaultMissionResult,
    NearGoals,
    missions_in,
)
from benchmarks.faults.monitor import FARTHEST_ASTRAY, FaultMonitor, FaultStop
from benchmarks.faults.run import HungError, limit_wall_time
from benchmarks.faults.scores import FaultScore, FaultSeries, run_series, score_series
from benchmarks.faults.totals import DefaultResults, WallClockTiming
from benchmarks.faults.wall_clock import ReflexLatency
from benchmarks.harness.store import Store
from mapping import map_bundle
from sim_stubs.faults.catalogue import CATALOGUE
from sim_stubs.faults.faulty_program import full_disk
from tests.helpers.failing import raising
from vizbot.config import Config
from vizbot.core.errors import ConfigError, MapError

LATENCY = ReflexLatency(10, 10, 2.0, 8.0, 9.0, 200.0)
TIMING = WallClockTiming(LATENCY)


def result(after, rolling=True, name="bump", **changes):
    stop = FaultStop(name, rolling, after, 0.01, 0.1)
    drive, line = FaultDrive((name,), 0), "/dev/pts/7: it stopped"
    plain = FaultDriveResult(drive, (stop,), 0.2, line, True, True, 0.01, "", "", True)
    return replace(plain, **changes)


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


@pytest.mark.long
@pytest.mark.parametrize("name", CATALOGUE)
def test_whatever_happens_the_robot_stops_in_time_and_nothing_is_lost(name):
    for seed in (201, 202):
        became = run_drive(FaultDrive((name,), seed))
        assert became.crash == ""
        assert all(stop.in_time for stop in became.stops)
        assert became.map_kept is not False
        assert became.happened


@pytest.mark.parametrize(
    ("name", "farthest"),
    [("bumper-stays", 0.3), ("wall-stays", 0.3), ("overcurrent-stays", 0.3), ("dock-stays", 0.6)],
)
def test_what_stays_ends_the_drive_rightly_and_little_is_driven_backwards(
    name, farthest, monkeypatch
):
    way, advance = [], FaultMonitor.advance

    def add(monitor, seconds):
        way.append(max(0.0, -sum(monitor._body.asked) / 2) * seconds)
        advance(monitor, seconds)

    monkeypatch.setattr(FaultMonitor, "advance", add)
    series = FaultSeries((name,), (3,), by_default=True)
    score = run_series(series)
    assert (score.happened, score.drove_on, score.ended, score.noticed) == (1, 1, 1, 1)
    assert score.in_time == score.stops == (name != "dock-stays")
    assert 0.9 * farthest < sum(way) <= farthest + 0.01
    outcome = fault_tables.fault_result([], [], TIMING, by_default=DefaultResults([score]))
    assert DefaultResults([score]).of_drives(name) == "ended 1 of 1" and outcome.text


def test_who_backs_off_for_ever_has_not_ended_rightly():
    for reported in ("", "the base is in PASSIVE mode and does not drive"):
        drive = FaultDrive(("wall-stays",), 0, True)
        became = result(0.03, drive=drive, drove_on=False, reported=reported)
        assert score_series(FaultSeries(("wall-stays",), (0,), True), [became]).ended == 0


def test_a_killed_program_leaves_wheels_at_rest():
    became = run_drive(FaultDrive(("process-killed",), 1))
    [stop] = became.stops
    assert stop.rolling
    assert 0.29 < stop.after <= 0.315
    assert became.reported == "killed"
    assert became.map_kept is None


def test_a_driver_that_crashes_is_seen(monkeypatch):
    monkeypatch.setattr(fault_run, "_APART", 0.0)
    monkeypatch.setattr("drivers.roomba.oi_mode.why_passive", raising(IndexError("no such wheel")))
    became = run_drive(FaultDrive(("mode-passive",), 1))
    assert became.crash == "IndexError: no such wheel"
    assert not became.drove_on


def test_a_program_that_hangs_is_ended_whatever_it_catches():
    caught = []
    with pytest.raises(HungError, match=r"not over after 0.05 s"), limit_wall_time(0.05):
        while True:
            try:
                for _ in iter(int, 1):
                    pass
            except Exception:
                caught.append("this must not happen")
    assert caught == []


def test_a_series_counts_what_was_late_crashed_or_lost():
    series = FaultSeries(("bump",), tuple(range(6)))
    became = [
        result(0.03),
        result(0.2, crash="ValueError: no"),
        result(None, drove_on=False),
        result(0.05, map_kept=False),
        result(0.0, rolling=False),
        result(0.03, happened=False),
    ]
    summed = score_series(series, became)
    assert (summed.in_time, summed.stops) == (3, 5)
    assert (summed.stopped_median, summed.stopped_max) == (0.04, 0.2)
    assert (summed.happened, summed.drove_on) == (5, 4)
    assert len(summed.crashes) == 1
    assert summed.maps_lost == 1
    assert summed.line == "it stopped"


def test_after_a_fault_that_ends_the_search_who_drives_on_or_says_nothing_does_wrong():
    series = FaultSeries(("battery-low",), (0, 1, 2, 3))
    became = [
        result(None, name="battery-low", drove_on=drove_on, reported=reported)
        for drove_on in (False, True)
        for reported in ("the battery is at 5 %", "")
    ]
    assert score_series(series, became).drove_on == 1


def test_a_wheel_that_turns_too_far_unasked_is_counted_and_the_farthest_told():
    far = score_series(
        FaultSeries(("bump",), (0, 1, 2, 3)),
        [result(0.03, astray=a) for a in (0, 0.1, FARTHEST_ASTRAY, 0.2)],
    )
    assert (far.astray_max, far.strayed) == (0.2, 1)
    outcome = fault_tables.fault_result([far], [], TIMING)
    assert outcome.summary["strayed"] == 1 and "smoke test" not in outcome.text
    brief = fault_tables.fault_result([far], [], TIMING, smoke_test=True)
    assert brief.text.startswith("A smoke test")
    assert " 0.200 |" in outcome.text


def test_a_fault_that_must_be_told_and_is_not_is_counted():
    silent = result(0.03, noticed_after=None, noticed="")
    outcome = fault_tables.fault_result(
        [score_series(FaultSeries(("bump",), (0, 1)), [silent, result(0.03)])], [], TIMING
    )
    assert outcome.summary["silent"] == 1
    assert "1 of 2" in outcome.text


def test_a_line_about_something_else_is_no_report(monkeypatch):
    monkeypatch.setitem(
        CATALOGUE, "bump", replace(CATALOGUE["bump"], report_pattern="a pane of glass")
    )
    became = run_drive(FaultDrive(("bump",), 1))
    assert became.noticed == ""
    assert became.noticed_after is None


def test_a_robot_that_ignores_its_battery_has_not_ended_its_search(monkeypatch):
    heeds = run_drive(FaultDrive(("battery-low",), 1))
    assert score_series(FaultSeries(("battery-low",), (1,)), [heeds]).drove_on == 1
    monkeypatch.setattr(
        fault_drives, "_config", lambda drive: Config.model_validate(
            {"objectnav": {"look_around": False}, "recovery": {"min_battery": 0.05},
             "sim_camera": {"rate": 10.0}}
        )
    )  # fmt: skip
    ignores = run_drive(FaultDrive(("battery-low",), 1))
    assert ignores.drove_on
    assert ignores.noticed == ""
    assert score_series(FaultSeries(("battery-low",), (1,)), [ignores]).drove_on == 0


def test_a_full_disk_costs_neither_the_map_before_nor_the_one_in_memory(monkeypatch, tmp_path):
    with full_disk(), pytest.raises(OSError, match="too large"):
        (tmp_path / "file").write_text("more than fits")
    (tmp_path / "file").write_text("room again")
    assert run_drive(FaultDrive(("disk-full",), 1)).map_kept

    def boasts(bundle, path, save=map_bundle.save):
        with suppress(MapError):
            save(bundle, path)

    monkeypatch.setattr("mapping.map_bundle.save", boasts)
    assert run_drive(FaultDrive(("disk-full",), 1)).map_kept is False


def test_the_outcome_tells_runs_stops_and_goals_with_their_intervals():
    scores = [score_series(FaultSeries(("bump",), (0,)), [result(0.03)])]
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
    outcome = fault_tables.fault_result(scores, missions, TIMING)
    assert outcome.summary["runs"] == 6
    assert "Two at a time" not in outcome.text
    assert outcome.summary["stopped_in_time"] == 0.5
    assert outcome.summary["goal_reached"] == 0.5
    assert outcome.summary["crashes"] == 0
    assert "gone" in outcome.text
    assert "median 2.0 ms" in outcome.text


def test_pairs_are_summed_up_apart_from_single_faults():
    pair = score_series(FaultSeries(("bump", "cliff"), (0, 1)), [result(0.03), result(0.03)])
    single = score_series(FaultSeries(("bump",), (0,)), [result(0.03)])
    text = fault_tables.fault_result([single, pair], [], TIMING).text
    assert "Two at a time: 1 pairs, 2 drives, in 2 of which both happened" in text
    assert "the robot drove on in 2." in text


def test_the_page_says_with_what_its_results_were_made(tmp_path):
    whole = FaultSeries(("bump",), tuple(range(100)))
    scores = [
        score_series(series, [result(0.03)]) for series in (whole, FaultSeries(("bump",), (0,)))
    ]
    store = Store(tmp_path / "faults/drives.jsonl", FaultScore)
    store.add("an older key", "old", "a slow machine", scores[0])
    store.add("quick", "quick", "two cores", scores[1])
    store.add(faults._key(), "abc123", "two cores", scores[0])
    page = tmp_path / "faults.md"
    made = "Run: single faults at abc123 on two cores."
    assert made in faults_page(tmp_path / "faults", page)
    timings = Store(tmp_path / "faults/timings.jsonl", WallClockTiming)
    timings.add(faults._key(), "abc123", "two cores", TIMING)
    text = faults_page(tmp_path / "faults", page)
    assert "| bump " in text and LATENCY.summary() in text
    assert faults_page(tmp_path / "nowhere", page) == ""


def test_of_each_series_the_newest_result_is_shown_and_the_page_says_of_what_commits(tmp_path):
    store, page = Store(tmp_path / "faults/drives.jsonl", FaultScore), tmp_path / "faults.md"
    for name in ("bump", "cliff"):
        series = FaultSeries((name,), tuple(range(100)))
        store.add("old", "old", "a machine", score_series(series, [result(0.03)]))
    newer = FaultSeries(("cliff",), tuple(range(100)))
    store.add("new", "new", "a machine", score_series(newer, [result(0.06)]))
    text = faults_page(tmp_path / "faults", page)
    assert "single faults at old on a machine (1) and new on a machine (1)." in text
    rows = {line.split("|")[1].strip(): line for line in text.splitlines() if "| " in line}
    assert "0.03 (0.03)" in rows["bump"] and "0.06 (0.06)" in rows["cliff"]


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


def test_a_smoke_test_is_every_sixth_fault_and_every_eighth_pair_in_one_home():
    homes = [NearGoals(home, ("sofa", "bed")) for home in (1000, 1001)]
    missions = missions_in(homes, quick=True)
    assert {m.home for m in missions} == {1000}
    assert [m.faults for m in missions if len(m.faults) == 2] == list(PAIRS[::8])
    assert [m.faults[0] for m in missions if len(m.faults) == 1] == list(CATALOGUE)[::6]
    assert [m.goal for m in missions if len(m.faults) == 2] == ["sofa", "bed", "sofa"]


def test_the_monitor_of_a_drive_knows_how_often_the_camera_gives_a_frame(monkeypatch):
    class BuiltError(Exception):
        pass

    def monitor(base, schedule, clock, camera_period):
        raise BuiltError(camera_period)

    monkeypatch.setattr(fault_drives, "FaultMonitor", monitor)
    with pytest.raises(BuiltError) as built:
        run_drive(FaultDrive(("bump",), 1))
    assert built.value.args == (0.1,)


def test_homes_that_training_saw_are_refused():
    with pytest.raises(ConfigError, match="training home"):
        faults.require_homes([1000, 7])
