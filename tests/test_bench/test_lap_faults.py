"""Sensors that fail in the middle of a recording."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from vizbot.bench.slam import sensor_faults
from vizbot.bench.slam.replays import ReplayFrame
from vizbot.bench.slam.sensor_faults import Span
from vizbot.core.geometry import planar, yaw_of
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

CAMERA = Intrinsics(8, 6, 5.0, 5.0, 3.5, 2.5)
DURING = Span(1.0, 2.0)


def moments(count=15, rate=5.0):
    """A robot that goes ahead by 0.1 m and turns by 0.02 rad from frame to frame."""
    T = np.eye(4)
    for i in range(count):
        stamp = 100.0 + i / rate
        imu = ImuSamples(
            np.array([stamp]), np.full((1, 3), 0.5), np.array([stamp]), np.ones((1, 3))
        )
        rgb = np.full((6, 8, 3), 120, np.uint8)
        frame = RGBDFrame(stamp, rgb, np.full((6, 8), 2.0, np.float32), CAMERA, imu)
        yield ReplayFrame(frame, T, T)
        T = T @ planar(0.1, 0.0, 0.02)


def with_fault(fault):
    return list(fault(moments()))


def steps(run):
    """Way [m] and turn [rad] between moments by the wheels."""
    moved = [np.linalg.inv(a.T_odom_base) @ b.T_odom_base for a, b in pairwise(run)]
    return np.array([[T[0, 3], yaw_of(T)] for T in moved])


def test_in_the_dark_colour_is_noise_and_depth_is_there():
    run = with_fault(sensor_faults.dark(DURING))
    assert [moment.frame.rgb.mean() < 10 for moment in run] == [5 <= i < 10 for i in range(15)]
    assert all((moment.frame.depth == 2).all() for moment in run)


def test_a_white_wall_shows_neither_corners_nor_depth():
    run = with_fault(sensor_faults.white_wall(DURING))
    assert [moment.frame.rgb.mean() > 200 for moment in run] == [5 <= i < 10 for i in range(15)]
    assert [not moment.frame.depth.any() for moment in run] == [5 <= i < 10 for i in range(15)]


def test_slipping_wheels_count_more_than_the_robot_moves_and_stay_off():
    run = with_fault(sensor_faults.slipping(DURING, 0.2))
    slipped = np.array([4 <= i < 9 for i in range(14)])
    assert steps(run)[slipped] == pytest.approx(np.tile([0.12, 0.024], (5, 1)))
    assert steps(run)[~slipped] == pytest.approx(np.tile([0.1, 0.02], (9, 1)))
    truth = list(moments())
    assert all((a.T_world_cam == b.T_world_cam).all() for a, b in zip(run, truth, strict=True))


def test_stuck_wheels_say_that_the_robot_stands():
    run = with_fault(sensor_faults.wheels_stuck(DURING))
    assert steps(run)[4:9] == pytest.approx(np.zeros((5, 2)), abs=1e-12)


def test_a_gyroscope_falls_silent_or_lies_for_a_while():
    silent = with_fault(sensor_faults.gyro_off(DURING))
    assert [len(moment.frame.imu.gyro) for moment in silent] == [1] * 5 + [0] * 5 + [1] * 5
    lying = with_fault(sensor_faults.gyro_biased(DURING, 0.1))
    read = [moment.frame.imu.gyro[0, 2] for moment in lying]
    assert read == pytest.approx([0.5] * 5 + [0.6] * 5 + [0.5] * 5)


def test_a_kidnapped_robot_feels_nothing_of_it():
    run = list(sensor_faults.kidnapped(DURING)(moments()))
    assert len(run) == 10
    felt = steps(run)
    assert felt[4] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert np.delete(felt, 4, axis=0) == pytest.approx(np.tile([0.1, 0.02], (8, 1)))
    carried = run[5].T_world_cam[:2, 3] - run[4].T_world_cam[:2, 3]
    assert np.linalg.norm(carried) > 0.5


def test_through_the_corridor_the_gyroscope_reads_what_it_read_at_rest():
    standing = [replace(moment, T_odom_base=np.eye(4)) for moment in moments()]
    run = list(sensor_faults.twins(standing, moments(), 4.0, np.eye(4)))
    for moment in run[15:-15]:
        imu = moment.frame.imu
        assert imu.gyro == pytest.approx(standing[1].frame.imu.gyro)
        assert imu.gyro_stamps == pytest.approx([moment.frame.stamp])


def test_two_homes_that_look_the_same_lie_a_dark_corridor_apart():
    run = list(sensor_faults.twins(moments(), moments(), 4.0, np.eye(4)))
    stamps = np.array([moment.frame.stamp for moment in run])
    assert np.diff(stamps) == pytest.approx(np.full(len(run) - 1, 0.2))
    lit = [moment.frame.rgb.mean() > 100 for moment in run]
    assert lit == [True] * 15 + [False] * (len(run) - 30) + [True] * 15
    assert steps(run)[14:-15].sum(axis=0) == pytest.approx([4.0, 0.0])
    for first, again in zip(run[:15], run[-15:], strict=True):
        apart = again.T_world_cam[:2, 3] - first.T_world_cam[:2, 3]
        assert np.linalg.norm(apart) > 2.0
        imu = again.frame.imu
        assert np.abs(imu.gyro_stamps - again.frame.stamp).max() < 1e-6
