"""A robot is driven through a simulated home and recorded."""

import itertools
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.episodes.calibration_error import EXACT
from benchmarks.harness.store import Store
from benchmarks.slam import hours as slam_hours
from benchmarks.slam.lap_scores import consistent_nees
from benchmarks.slam.laps import LapConfig, record_laps
from benchmarks.slam.replays import replay, to_and_fro
from drivers.tum_sequence import RecordedSequence
from mapping.odometry.config import DeadReckoningConfig
from mapping.odometry.dead_reckoning import DeadReckoning
from mapping.slam.slam import Slam
from mapping.trajectory_error import normalised_errors
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import invert, yaw_of

LAPS = LapConfig(laps=1, rooms=1, rate=4.0, standing=0.6)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lap") / "home-0"
    record_laps(0, folder, Config(), LAPS, EXACT)
    return folder


def test_a_lap_leads_to_a_room_and_back(folder):
    run = list(replay(folder))
    way = np.array([moment.T_world_cam[:2, 3] for moment in run])
    assert np.linalg.norm(way - way[0], axis=1).max() > 1.0
    assert np.linalg.norm(way[-1] - way[0]) < 0.25


def test_wheels_and_gyroscope_tell_the_same_way_as_the_truth(folder):
    run = list(replay(folder))
    driven = [
        np.linalg.norm((invert(a.T_odom_base) @ b.T_odom_base)[:2, 3]) for a, b in pairwise(run)
    ]
    true = [np.linalg.norm(b.T_world_cam[:3, 3] - a.T_world_cam[:3, 3]) for a, b in pairwise(run)]
    assert sum(driven) == pytest.approx(sum(true), rel=0.15)
    turned = yaw_of(run[-1].T_odom_base) - yaw_of(run[0].T_odom_base)
    rates = np.concatenate([moment.frame.imu.gyro for moment in run])
    stamps = np.concatenate([moment.frame.imu.gyro_stamps for moment in run])
    assert (np.diff(stamps) > 0).all()
    # The camera looks ahead and a little down: its y axis is against the base's z axis.
    angle = -np.trapezoid(rates[:, 1], stamps)
    assert (angle - turned + np.pi) % (2 * np.pi) - np.pi == pytest.approx(0.0, abs=0.2)


def test_samples_belong_to_the_frame_after_them(folder):
    last = -np.inf
    for moment in replay(folder):
        imu = moment.frame.imu
        for stamps in (imu.gyro_stamps, imu.accel_stamps):
            assert len(stamps) == 0 or (stamps[0] > last and stamps[-1] <= moment.frame.stamp)
        last = moment.frame.stamp


def test_the_covariances_of_poses_in_their_keyframes_are_true(folder):
    config, slam, taken_at, measured = Config(), None, {}, []
    T_base_cam = config.mount.T_base_cam
    for moment in replay(folder):
        if slam is None:
            slam = Slam(moment.frame.intrinsics, T_base_cam, config.perception.slam)
        estimate = slam.track(moment.frame, moment.T_odom_base)
        if estimate.is_keyframe:
            taken_at[estimate.keyframe] = moment.T_world_cam
        elif estimate.covariance is not None:
            truly = invert(taken_at[estimate.keyframe]) @ moment.T_world_cam
            measured.append(
                (estimate.keyframe, estimate.T_keyframe_cam, estimate.covariance, truly)
            )
    keyframes, Ts_keyframe_cam, covariances, truly = map(np.array, zip(*measured, strict=True))
    nees = normalised_errors(Ts_keyframe_cam, covariances, truly).mean()
    low, high = consistent_nees(len(np.unique(keyframes)))
    assert low < nees < high


def test_a_recording_is_a_sequence_in_tum_layout_and_is_not_made_twice(folder):
    with RecordedSequence(folder) as camera:
        count, frame = len(camera), camera.read()
    assert count == len(list(replay(folder))) > 10
    assert frame is not None
    assert 0.3 < np.median(frame.depth[frame.depth > 0]) < 8.0
    written = (folder / "associations.txt").stat().st_mtime_ns
    record_laps(0, folder, Config(), LAPS)
    assert (folder / "associations.txt").stat().st_mtime_ns == written


def test_what_a_calibration_leaves_is_in_the_recording_and_the_robot_does_not_know(
    folder, tmp_path
):
    brief = LapConfig(laps=1, rooms=1, rate=1.0, standing=0.6)
    record_laps(0, tmp_path / "drawn", Config(), brief)
    record_laps(0, tmp_path / "exact", Config(), brief, EXACT)
    drawn, exact = (next(iter(replay(tmp_path / name))) for name in ("drawn", "exact"))
    assert drawn.frame.intrinsics == exact.frame.intrinsics
    off = np.linalg.norm(drawn.T_world_cam[:3, 3] - exact.T_world_cam[:3, 3])
    assert off == pytest.approx(0.005, abs=1e-4)


def test_a_torn_recording_is_refused_by_name(folder, tmp_path):
    for path in folder.iterdir():
        if path.name != "odometry.txt":
            (tmp_path / path.name).symlink_to(path)
    with pytest.raises(ConfigError, match=r"odometry\.txt"):
        list(replay(tmp_path))


def test_to_and_fro_the_robot_comes_back_without_a_jump(folder):
    count = len(list(replay(folder)))
    run = list(itertools.islice(to_and_fro(folder), 4 * count - 3))
    stamps = np.array([moment.frame.stamp for moment in run])
    assert (np.diff(stamps) > 0).all()
    places = [*range(count), *range(count - 2, -1, -1)]
    assert stamps[2 * count - 2] - stamps[0] == pytest.approx(2 * (stamps[count - 1] - stamps[0]))
    for i, place in enumerate(places):
        np.testing.assert_array_equal(run[i].T_world_cam, run[place].T_world_cam)
        np.testing.assert_array_equal(run[i].frame.depth, run[place].frame.depth)
    sampled = np.concatenate([moment.frame.imu.gyro_stamps for moment in run])
    assert (np.diff(sampled) > 0).all()
    dead = DeadReckoning(Config().mount.T_base_cam, DeadReckoningConfig(least_standing=0.2))
    turned = [dead.update(moment.frame, moment.T_odom_base) for moment in run]
    there_and_back = [turned[0], turned[2 * count - 2], turned[4 * count - 4]]
    assert turned[-1].gyro_since(turned[0])
    for one, other in pairwise(there_and_back):
        assert abs(yaw_of(other.since(one))) < 0.02


def test_every_hour_is_told_and_the_rest(folder, monkeypatch):
    monkeypatch.setattr(slam_hours, "_HOUR", 8.0)
    hours = list(slam_hours.track_hours(to_and_fro(folder), 2.5, Config()))
    assert [hour.frames for hour in hours] == pytest.approx([32, 32, 16], abs=1)
    assert all(0.0 < hour.way < 8.0 * 0.5 for hour in hours[:2])
    assert all(hour.error < 0.1 and hour.ms_mean > 0.0 for hour in hours)
    driven = slam_hours.DrivenHours(0, LAPS.laps, LAPS.rate, tuple(hours))
    outcome = slam_hours.hours_result(driven)
    assert outcome.summary["last_over_first"] == hours[-1].ms_mean / hours[0].ms_mean
    assert "driven to and fro" in outcome.text


def test_a_run_of_whole_hours_ends_with_the_last_of_them(monkeypatch):
    monkeypatch.setattr(slam_hours, "_HOUR", 8.0)
    monkeypatch.setattr(
        slam_hours,
        "_Log",
        lambda moment: SimpleNamespace(hour=lambda slam: "an hour", add=lambda *_: None),
    )
    slam = SimpleNamespace(track=lambda *_: SimpleNamespace(T_map_cam=np.eye(4)))
    monkeypatch.setattr(slam_hours, "Slam", lambda *_: slam)
    frames = (
        SimpleNamespace(
            frame=SimpleNamespace(stamp=4.0 * i, intrinsics=None), T_odom_base=None,
            T_world_cam=np.eye(4),
        )
        for i in range(20)
    )  # fmt: skip
    assert list(slam_hours.track_hours(frames, 2.0, Config())) == ["an hour"] * 2
    assert next(frames).frame.stamp == 20.0


def test_hours_are_kept_with_all_that_their_table_needs(folder, monkeypatch, tmp_path):
    monkeypatch.setattr(slam_hours, "_HOUR", 8.0)
    monkeypatch.setattr(slam_hours, "recording_folder", lambda *_: folder.parent)
    monkeypatch.setattr(slam_hours, "record_laps", lambda *_: None)
    outcome = slam_hours.run_slam_hours(0, 1.5, Config(), tmp_path)
    [kept] = Store(tmp_path / "hours.jsonl", slam_hours.DrivenHours).all()
    assert len(kept.result.hours) == 2
    assert slam_hours.hours_result(kept.result) == outcome
    assert outcome.summary["last_over_first"] == pytest.approx(
        kept.result.hours[1].ms_mean / kept.result.hours[0].ms_mean
    )
