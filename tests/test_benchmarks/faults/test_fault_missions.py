"""Missions with faults in one room, and drives and missions with the product's settings."""

import numpy as np
import pytest

from benchmarks.episodes.calibration_error import CalibrationError
from benchmarks.faults import bench as faults
from benchmarks.faults import missions, tables, totals
from benchmarks.faults.drives import FaultDrive, run_drive
from benchmarks.faults.missions import FaultMission, FaultMissionResult, NearGoals
from benchmarks.faults.scores import (
    ENDS_BY_DEFAULT,
    FaultScore,
    FaultSeries,
    run_series,
    score_series,
)
from benchmarks.harness.scores import Rate
from benchmarks.harness.store import Store
from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.geometry.house import House
from tests.test_benchmarks.episodes.one_room import true_encoder
from tests.test_benchmarks.faults.test_fault_drives import LATENCY, TIMING
from tests.test_benchmarks.printed_table import cells
from vizbot.config import Config
from vizbot.core.observer import Outcome
from vizbot.rehearsal.config import RehearsalConfig

GREY = (0.6, 0.6, 0.6)
CONFIG = true_encoder(3).config


@pytest.fixture(autouse=True)
def kitchen(monkeypatch, mean_colours):
    """A robot that stands in the kitchen, which its encoder does not know."""
    room = RectangularRoom("kitchen", 0, 0, 5, 4, GREY, 1.0, GREY)
    lights = np.array([[2.5, 2.0, 2.3]])
    house = House((room.room,), build_structure((room,), ()), (), lights, (1.2, 2.0, 0.0))

    def opened(episode, config, error):
        assert error == CalibrationError.drawn(episode)
        return error.world(house, config, episode.home)

    monkeypatch.setattr(missions, "open_episode", opened)
    monkeypatch.setattr(missions, "encoder_of", lambda config: mean_colours)
    monkeypatch.setattr(missions, "UNATTENDED", CONFIG)


def test_a_robot_whose_steps_are_spent_has_not_reached_the_room_that_it_stands_in():
    became = missions.run_mission(FaultMission(1000, "kitchen", ()))
    assert not became.reached
    assert became.steps == 3
    assert became.crash == ""
    assert (became.happened, became.map_kept, became.stops) == (True, True, ())


@pytest.mark.parametrize(
    ("ended", "goal", "reached", "answer"),
    [
        ((Outcome.ARRIVED, "seen", ""), "kitchen", True, ""),
        ((Outcome.ARRIVED, "seen", ""), "bed", False, "no bed in this world"),
        ((Outcome.GAVE_UP, "not found", ""), "kitchen", False, "not found"),
        ((Outcome.EXPLORED, "nothing is left", ""), "kitchen", False, "nothing is left"),
        ((Outcome.GAVE_UP, "", "IndexError: no wheel"), "kitchen", False, ""),
    ],
)
def test_only_who_says_that_he_arrived_and_did_has_reached_the_goal(
    monkeypatch, ended, goal, reached, answer
):
    monkeypatch.setattr(missions, "run_to_end", lambda *_: ended)
    became = missions.run_mission(FaultMission(1000, goal, ()))
    assert (became.reached, became.answer, became.crash) == (reached, answer, ended[2])


def test_a_fault_that_does_not_happen_before_the_end_is_told():
    became = missions.run_mission(FaultMission(1000, "kitchen", ("bump",)))
    assert not became.happened
    assert became.stops == ()
    assert became.map_kept


def test_the_monitor_of_a_mission_knows_how_often_the_camera_gives_a_frame(monkeypatch):
    periods = []

    class Monitor(missions.FaultMonitor):
        def __init__(self, base, schedule, clock, camera_period):
            periods.append(camera_period)
            super().__init__(base, schedule, clock, camera_period)

    monkeypatch.setattr(missions, "FaultMonitor", Monitor)
    missions.run_mission(FaultMission(1000, "kitchen", ("bump",)))
    assert periods == [1.0 / RehearsalConfig.read(CONFIG).sim_camera.rate]


EDGE = "the base stopped at an edge; put it elsewhere, or set resume_safe"


@pytest.mark.parametrize(
    ("name", "drove_on", "ended", "reason"),
    [("cliff", 0, 1, EDGE), ("wheel-drop", 0, 1, "a wheel hangs"), ("mode-passive", 1, 0, "")],
)
def test_by_default_an_edge_or_a_lift_ends_the_search_with_its_reason(
    name, drove_on, ended, reason
):
    driven = run_drive(FaultDrive((name,), 1, by_default=True))
    assert driven.reported.startswith(reason) and bool(driven.reported) is bool(reason)
    assert all(stop.in_time for stop in driven.stops) and driven.crash == ""
    score = score_series(FaultSeries((name,), (1,), by_default=True), [driven])
    assert (score.happened, score.drove_on, score.ended) == (1, drove_on, ended)
    unattended = score_series(FaultSeries((name,), (1,)), [driven])
    assert unattended.ended == 0  # who resumes by itself has no excuse


def ended(faults, answer, by_default=True, happened=True, reached=False):
    mission = FaultMission(1100, "bed", faults, by_default)
    return FaultMissionResult(mission, happened, reached, answer, 50, (), "", True)


def test_only_the_reason_of_its_own_fault_ends_a_mission_rightly():
    assert ended(("cliff",), EDGE).ended_by_default
    assert ended(("cliff", "stream-silent"), EDGE).ended_by_default
    assert ended(("kidnapped",), "a wheel hangs; put the robot on the floor").ended_by_default
    for wrong in (
        ended(("cliff",), "not found"),
        ended(("cliff",), EDGE, by_default=False),
        ended(("cliff",), EDGE, happened=False),
        ended(("cliff",), EDGE, reached=True),
        ended(("bump",), EDGE),
        ended((), EDGE),
    ):
        assert not wrong.ended_by_default


@pytest.mark.parametrize(
    ("name", "happened", "right"),
    [
        ("lifted-unheard", True, False),
        ("lifted-unheard", False, True),
        ("stream-silent", True, True),
    ],
)
def test_whoever_drives_on_by_himself_after_a_lift_that_nobody_heard_is_wrong(
    name, happened, right
):
    mission = ended((name,), "", happened=happened, reached=True)
    assert mission.right_by_default == right
    results = totals.DefaultResults((), [mission])
    assert (name in results.text()) != right
    assert results.right == Rate(int(right and happened), int(happened))


def test_a_mission_by_default_runs_with_the_product_s_settings(monkeypatch):
    used = []

    def to_end(pipeline, *_):
        used.append(pipeline.config)
        return Outcome.GAVE_UP, EDGE, ""

    monkeypatch.setattr(missions, "run_to_end", to_end)
    for by_default in (True, False):
        missions.run_mission(FaultMission(1000, "kitchen", ("cliff",), by_default))
    assert used == [Config(), CONFIG]


def test_what_the_product_s_settings_do_stands_in_columns_of_its_own():
    drive = run_drive(FaultDrive(("cliff",), 1))
    resumed = score_series(FaultSeries(("cliff",), (1,)), [drive])
    by_default = totals.DefaultResults(
        [score_series(FaultSeries(("cliff",), (1,), by_default=True),
                      [run_drive(FaultDrive(("cliff",), 1, by_default=True))])],
        [ended(("cliff",), EDGE), ended(("cliff",), "", reached=True), ended(("bump",), EDGE),
         ended((), "not found"), ended(("battery-low",), "the battery is at 5 %")],
    )  # fmt: skip
    unattended = [ended(("cliff",), "", by_default=False, reached=True)]
    outcome = tables.fault_result([resumed], unattended, TIMING, False, by_default)
    assert cells(outcome.text, "cliff")[-4:-1] == [
        "1 of 1", "drove on 0, ended 1 of 1", "1 of 2, 1 ended"
    ]  # fmt: skip
    assert "is counted as ended: 1 of 5 missions. Right are 2 of 3 (" in outcome.text
    assert cells(outcome.text, "bump") == ["1100", "bed", EDGE, "50"]
    assert cells(outcome.text, "nothing wrong")[2] == "not found"
    wanted = {"default_missions": 5, "default_reached": 1, "default_ended": 1}
    assert {key: outcome.summary[key] for key in wanted} == wanted
    assert outcome.summary["default_right"] == pytest.approx(2 / 3)
    assert outcome.summary["goal_reached"] == 1.0
    without = tables.fault_result([resumed], unattended, TIMING).text
    assert cells(without, "cliff")[-3:-1] == ["-", "-"] and "have done right" not in without


def test_rows_by_default_are_kept_in_files_of_their_own(monkeypatch, tmp_path):
    def inline(work, jobs, title, describe):
        for job in jobs:
            match title:
                case "homes":
                    yield job, NearGoals(job, ("bed", "sofa"))
                case "fault drives":
                    yield job, FaultScore(job, 0, 0, 0, None, None, None, 0.0, None, None, 0, "",
                                          0, (), 0)  # fmt: skip
                case _:
                    yield job, FaultMissionResult(job, True, True, "", 9, (), "", True)

    monkeypatch.setattr(faults, "in_parallel", inline)
    monkeypatch.setattr(faults, "measure_reflexes", lambda: LATENCY)
    summary = faults.run_faults(faults.FaultBench((1100, 1101), True, tmp_path)).summary

    def kept(name, kind):
        return Store(tmp_path / name, kind).results_with_key(faults._key())

    series = [score.series for score in kept("drives-by-default.jsonl", FaultScore)]
    assert series == [FaultSeries((name,), (0, 1, 2, 3), True) for name in ENDS_BY_DEFAULT]
    assert not any(s.series.by_default for s in kept("drives.jsonl", FaultScore))
    both = [
        [each.mission for each in kept(name, FaultMissionResult)]
        for name in ("missions.jsonl", "missions-by-default.jsonl")
    ]
    assert [(m.home, m.goal, m.faults) for m in both[0]] == [
        (m.home, m.goal, m.faults) for m in both[1]
    ]
    assert {m.by_default for m in both[0]} == {False} and {m.by_default for m in both[1]} == {True}
    assert summary["default_missions"] == len(both[1])


@pytest.mark.parametrize(
    "name",
    ["cliff", "wheel-drop", "kidnapped", "charger-plugged", "lifted-unheard", "hangs-docking"],
)
def test_the_reason_that_ends_a_search_by_default_counts_as_a_line_about_the_fault(name):
    score = run_series(FaultSeries((name,), (0,), by_default=True))
    assert score.happened == score.ended == score.noticed == 1
