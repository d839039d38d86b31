"""Laps of homes with faults: what is asked for, kept and printed."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.harness.store import Store
from benchmarks.slam import homes as slam_homes
from benchmarks.slam import lap_scores
from benchmarks.slam.homes import AS_RECORDED, FAULTS, TWINS, recording_folder
from benchmarks.slam.lap_scores import LapResult
from benchmarks.slam.laps import LapConfig
from benchmarks.slam.relocalisation import STARTS, StartResult, starts_table
from benchmarks.slam.replays import ReplayFrame
from tests.test_benchmarks.printed_table import rows_in
from tests.test_benchmarks.slam.driven_lap import LAP
from vizbot.config import Config
from vizbot.core.geometry import invert, planar
from vizbot.core.types import PoseEstimate, Tracking


def start(number, error=0.02, turn=0.5, frames=3):
    return StartResult(1000, number, error is not None, error, turn, frames, 90.0)


@pytest.fixture
def jobs(monkeypatch):
    """What is run; nothing is recorded."""
    asked = []

    def serially(work, jobs, title, describe):
        for job in jobs:
            asked.append((job.home, job.faults, job.laps.laps))
            laps = [replace(LAP, home=job.home, fault=fault) for fault in job.faults]
            starts = [start(i) for i in range(STARTS)] if job.starts else []
            starts = [replace(one, home=job.home) for one in starts]
            assert f"home {job.home}" in describe(job, (laps, starts))
            yield job, (laps, starts)

    made = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores")
    monkeypatch.setattr(Fingerprint, "taken", staticmethod(lambda clip: made))
    monkeypatch.setattr(slam_homes, "in_parallel", serially)
    return asked


def test_ten_homes_of_three_laps_with_every_fault_and_nothing_twice(jobs, tmp_path):
    slam_homes.run_slam_homes([1000], False, Config(), tmp_path)
    assert jobs == [(1000, tuple(FAULTS), 3)]
    outcome = slam_homes.run_slam_homes(None, False, Config(), tmp_path)
    assert [home for home, _, _ in jobs[1:]] == list(range(1001, 1010))
    assert [row["row"] for row in outcome.rows] == list(FAULTS)
    assert outcome.summary["homes"] == 10
    assert outcome.summary["starts_right"] == outcome.summary["starts"] == 100
    assert outcome.summary["starts_wrong"] == 0
    assert outcome.summary["end_error"] == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("settings", "recorded_again"),
    [
        ({"perception": {"slam": {"search_radius": 0.08}}}, False),
        ({"mount": {"height": 0.5}}, True),
    ],
)
def test_another_robot_shares_no_result_and_a_recording_only_where_it_would_be_the_same(
    jobs, tmp_path, settings, recorded_again
):
    one, other = Config(), Config.model_validate(settings)
    for _ in range(2):
        for config in (one, other):
            slam_homes.run_slam_homes([1000], True, config, tmp_path)
    assert jobs == [(1000, tuple(FAULTS), 1)] * 2
    made, laps = Fingerprint.taken("embedded"), LapConfig()
    folders = {recording_folder(made, laps, config) for config in (one, other)}
    assert len(folders) == 1 + recorded_again
    assert recording_folder(made, LapConfig(rate=10.0), one) not in folders


def test_a_quick_run_is_two_homes_of_one_lap_and_no_claim(jobs, tmp_path):
    outcome = slam_homes.run_slam_homes(None, True, Config(), tmp_path)
    assert [(home, laps) for home, _, laps in jobs] == [(1000, 1), (1001, 1)]
    assert "no claim" in outcome.text


def test_the_worst_home_is_told_beside_the_median(jobs, tmp_path, monkeypatch):
    results = [replace(LAP, home=1000 + i, end_error=0.01 * (i + 1)) for i in range(3)]
    results.append(replace(results[0], fault="no gyroscope", tracked=0.5))
    row, other = lap_scores.laps_result(tuple(FAULTS), results, [start(0)], quick=False).rows
    assert (row["end_error"], row["end_error_worst"]) == pytest.approx((0.02, 0.03))
    assert other["tracked"] == 0.5
    assert row["nees"] == pytest.approx(6.1)
    assert 5.5 < row["nees_low"] < 6.0 < row["nees_high"] < 6.5


def test_errors_at_the_end_of_the_fault_stand_beside_those_of_the_laps():
    kept = replace(LAP, fault="carried for 10 s")
    carried = [
        replace(kept, home=1000 + i, fault_error=0.1 * (i + 1), fault_turn=2.0 - i)
        for i in range(3)
    ]
    results = [LAP, *carried]
    outcome = lap_scores.laps_result(tuple(FAULTS), results, [start(0)], quick=False)
    cells = rows_in(outcome.text)
    assert cells[0][4:10] == ["at the end of the fault [m]", "worst", "worst [degrees]",
                              "at the end of the laps [m]", "worst", "worst [degrees]"]  # fmt: skip
    assert cells[2][4:10] == ["-", "-", "-", "0.020", "0.020", "0.40"]
    assert cells[3][4:10] == ["0.200", "0.300", "2.00", "0.020", "0.020", "0.40"]


def test_closures_of_a_recording_count_once_however_often_it_is_replayed():
    recorded = [replace(LAP, home=1000 + i, closures=7 + i) for i in range(2)]
    dark = [replace(one, fault="dark for 30 s", closures=5) for one in recorded]
    dark[1] = replace(dark[1], wrong_closures=2)
    twin = [replace(dark[1], fault=TWINS, wrong_closures=1)]
    outcome = lap_scores.laps_result(tuple(FAULTS), [*twin, *dark, *recorded], [start(0)], False)
    assert [row["closures"] for row in outcome.rows] == [15, 10, 5]
    summary = outcome.summary
    assert (summary["recordings"], summary["closures"], summary["wrong_closures"]) == (2, 15, 2)
    assert "each of 2 recordings once: 15; wrong: 2." in outcome.text


def test_rows_that_were_kept_without_errors_at_the_end_of_a_fault_are_read(tmp_path):
    path = tmp_path / "homes.jsonl"
    Store(path, LapResult).add("key", "c0ffee", "2 cores", LAP)
    row = json.loads(path.read_text())
    del row["fault_error"], row["fault_turn"]
    path.write_text(json.dumps(row))
    assert Store(path, LapResult).results_with_key("key") == [LAP]


def test_the_bounds_of_true_covariances_close_in_on_six():
    errors = np.random.default_rng(0).chisquare(6, (2000, 50)).mean(axis=1)
    low, high = lap_scores.consistent_nees(50)
    assert np.mean((errors > low) & (errors < high)) == pytest.approx(0.95, abs=0.02)


def test_a_start_is_right_near_its_place_and_heading_and_wrong_beyond():
    starts = [start(0), start(1, error=0.5), start(2, turn=20.0), start(3, None, None, frames=63)]
    assert [one.right for one in starts] == [True, False, False, False]
    laps = lap_scores.laps_result((AS_RECORDED,), [LAP], starts, quick=False)
    assert (laps.summary["starts_right"], laps.summary["starts_wrong"]) == (1, 2)
    assert rows_in(starts_table(starts))[-1][:5] == ["4", "1", "2", "1", "3"]


def test_the_fault_ends_at_its_last_frame_and_is_scored_by_the_estimate_of_that_time():
    truth = np.array([planar(0.1 * i, 0.0, 0.0) for i in range(4)])
    off = [planar(0.0, 0.0, 0.0), planar(0.3, 0.4, 0.2), planar(0.0, 0.1, 0.1), np.eye(4)]
    estimates = [
        PoseEstimate(
            float(i), truth[i] @ off[i], 0, truth[i], i == 0, Tracking.TRACKING, 1e-4 * np.eye(6)
        )
        for i in range(4)
    ]
    slam = SimpleNamespace(closures=[], keyframe_poses=lambda: {0: truth[0]})
    for fault_end, scored in ((None, (None, None)), (1, (0.5, 11.459)), (2, (0.1, 5.73))):
        tracked = slam_homes._TrackedReplay(slam, None, estimates, truth, np.ones(4), fault_end)
        lap = slam_homes._scored(1000, "dark for 30 s", tracked)
        assert (lap.fault_error, lap.fault_turn) == scored
        assert (lap.end_error, lap.end_turn) == (0.0, 0.0)


def test_the_replay_knows_its_last_faulty_frame(monkeypatch):
    frame = SimpleNamespace(intrinsics=None, depth=None)
    estimate = PoseEstimate(0.0, np.eye(4), 0, np.eye(4), False, Tracking.LOST, None)
    slam = SimpleNamespace(track=lambda frame, T: estimate, keyframe_poses=dict)
    monkeypatch.setattr(slam_homes, "Slam", lambda *settings: slam)
    for flags, fault_end in (((False, True, True, False), 2), ((False, False), None)):
        run = [ReplayFrame(frame, np.eye(4), np.eye(4), faulty) for faulty in flags]
        assert slam_homes._track(run, Config()).fault_end == fault_end


def test_starts_are_drawn_in_the_map_of_the_recording_without_a_fault_alone(tmp_path, monkeypatch):
    tracked, drawn = SimpleNamespace(slam="map", grid=None, T_world_map=None), []
    monkeypatch.setattr(slam_homes, "record_laps", lambda *job: None)
    monkeypatch.setattr(slam_homes, "_replayed", lambda job, fault: fault)
    monkeypatch.setattr(slam_homes, "_track", lambda fault, config: drawn.append(fault) or tracked)
    monkeypatch.setattr(
        slam_homes, "_scored", lambda home, fault, tracked: replace(LAP, home=home, fault=fault)
    )
    monkeypatch.setattr(slam_homes, "random_starts", lambda home, slam, *rest: [start(0)])
    for missing, starts, followed in (
        (tuple(FAULTS), True, tuple(FAULTS)),
        (("no gyroscope",), False, ("no gyroscope",)),
        ((), True, (AS_RECORDED,)),
    ):
        drawn.clear()
        job = slam_homes._Job(1000, tmp_path, missing, starts, Config(), LapConfig())
        laps, found = slam_homes._work(job)
        assert (tuple(lap.fault for lap in laps), len(found)) == (missing, int(starts))
        assert tuple(drawn) == followed


def test_a_closure_of_places_over_two_metres_apart_is_wrong_and_counted():
    along = np.array([0.0, 0.5, 1.9, 2.1, 2.1])
    truth = np.tile(np.eye(4), (5, 1, 1))
    truth[:, 0, 3] = along
    tracking = [Tracking.TRACKING] * 3 + [Tracking.LOST, Tracking.WHEELS_ONLY]
    keyframes = {0: truth[0], 1: truth[2], 2: truth[3]}
    estimates = [
        PoseEstimate(
            float(i), truth[i] @ planar(0.0, 0.0, 0.0), keyframe, invert(keyframes[keyframe])
            @ truth[i], i in (0, 2, 3), tracking[i], 1e-4 * np.eye(6),
        )
        for i, keyframe in enumerate((0, 0, 1, 2, 2))
    ]  # fmt: skip
    estimates[-1] = replace(
        estimates[-1], T_map_cam=truth[4] @ planar(0.03, 0.04, 0.0), covariance=None
    )
    slam = SimpleNamespace(closures=[(0, 1), (0, 2), (2, 0)], keyframe_poses=lambda: keyframes)
    times = np.array([10.0, 20.0, 30.0, 40.0, 100.0])
    tracked = slam_homes._TrackedReplay(slam, None, estimates, truth, times)
    scored = slam_homes._scored(1000, AS_RECORDED, tracked)
    assert (scored.closures, scored.wrong_closures) == (3, 2)
    assert (scored.frames, scored.keyframes, scored.measured_in) == (5, 3, 1)
    assert (scored.path_length, scored.end_error, scored.end_turn) == (2.1, 0.05, 0.0)
    assert (scored.tracked, scored.lost, scored.nees) == (0.6, 0.2, 0.0)
    assert scored.ate > scored.ate_final == 0.0
    assert (scored.ms_mean, scored.ms_median) == (40.0, 30.0)
