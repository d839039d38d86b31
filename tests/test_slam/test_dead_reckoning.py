import numpy as np
import pytest

from mapping.odometry.rgbd_odometry import RelativePose
from tests.test_slam.dead_reckoning_drive import (
    BIAS,
    PERIOD,
    T_BASE_CAM,
    TRACK,
    Drive,
    gyro_sigma,
)
from vizbot.core.diff_drive import rolled
from vizbot.core.geometry import planar, wrap_angle, yaw_of
from vizbot.core.types import ImuSamples, RGBDFrame


def turned(angle: float) -> np.ndarray:
    return planar(0.0, 0.0, angle)


@pytest.mark.parametrize("yaw_rate", [0.5, -0.5])
def test_after_standing_the_gyroscope_says_how_far_wheels_that_slip_have_turned(
    yaw_rate: float,
) -> None:
    drive = Drive.rested()
    drive.go(20.0, 0.3, yaw_rate)
    distance, angle = drive.error()
    assert abs(angle) < 0.01 and distance < 0.01
    assert abs(yaw_of(np.linalg.inv(drive.T_true) @ drive.T_wheels)) > 0.5


@pytest.mark.slow
def test_the_error_of_turns_by_the_gyroscope_is_as_large_as_it_says() -> None:
    normalised = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        drive = Drive(bias=0.001 * seed - 0.02, scale=rng.normal(1.0, 0.01))
        drive.rng = rng
        drive.go(2.0, 0.0, 0.0)
        before, T_before = drive.now, drive.T_true
        drive.go(10.0, 0.3, 0.4)
        true = yaw_of(np.linalg.inv(T_before) @ drive.T_true)
        error = wrap_angle(yaw_of(drive.now.since(before)) - true)
        normalised.append(error / gyro_sigma(before, drive.now))
    # The sum of 40 squares: bounds of the central 99 % of the chi-square distribution.
    assert 20.7 < np.sum(np.square(normalised)) < 66.8


def test_turns_that_are_added_up_err_as_much_as_the_whole_one() -> None:
    drive = Drive()
    drive.go(1.0, 0.0, 0.0)
    start, before, variance = drive.now, drive.now, 0.0
    for _ in range(200):
        drive.go(0.5, 0.3, 0.0)
        variance += drive.now.chained_gyro_sigma_since(before) ** 2
        before = drive.now
    assert np.sqrt(variance) == pytest.approx(gyro_sigma(start, drive.now), rel=0.25)
    by_bias = drive.now.bias_sigma * (drive.now.stamp - start.stamp)
    assert np.sqrt(variance) > 0.75 * by_bias


def test_a_turn_from_where_images_found_the_robot_is_no_better_known_than_that() -> None:
    drive = Drive()
    drive.go(1.0, 0.0, 0.0)
    found = drive.now.displaced(turned(0.1), 0.004**2)
    drive.go(0.5, 0.3, 0.2)
    assert drive.now.chained_gyro_sigma_since(found) > 0.004
    assert yaw_of(drive.now.since(found)) == pytest.approx(0.5 * 0.2 - 0.1, abs=0.01)


@pytest.mark.parametrize("gyro", [True, False])
def test_what_turns_are_read_too_long_is_learned_from_images(gyro: bool) -> None:
    drive = Drive(scale=0.98, gyro=gyro)
    drive.go(2.0, 0.0, 0.0)
    for turn in [0.5, -0.5, 0.5] * 20:
        before, T_before = drive.now, drive.T_true
        drive.go(0.5, 0.3, turn)
        T_before_now = np.linalg.inv(T_before) @ drive.T_true
        seen = np.linalg.inv(T_BASE_CAM) @ T_before_now @ T_BASE_CAM
        drive.dead_reckoning.learn(before, RelativePose(seen, 1e-5 * np.eye(6), 99, 1.0))
    drive.T_true = drive.now.T_odom_base
    before = drive.now
    drive.go(10.0, 0.3, 0.5)
    assert abs(drive.error()[1]) < 0.005 * 5.0
    assert drive.now.gyro_since(before) == gyro


def test_the_way_is_an_arc() -> None:
    drive = Drive(bias=0.0)
    drive.go(1.0, 0.0, 0.0)
    drive.T_true = drive.now.T_odom_base
    drive.go(0.1, 3.0, 3.0)  # far in one frame, so that a wrong chord is seen
    assert drive.error()[0] < 0.002


@pytest.mark.parametrize(
    ("settings", "rest"), [({"gyro": False}, 1.0), ({"bias": BIAS}, 0.1), ({"bias": 0.3}, 2.0)]
)
def test_without_a_gyroscope_whose_bias_is_known_the_wheels_say_everything(settings, rest) -> None:
    drive = Drive(**settings)
    start = drive.now
    drive.go(rest, 0.0, 0.0)
    drive.go(5.0, 0.3, 0.5)
    np.testing.assert_allclose(drive.now.T_odom_base, drive.T_wheels, atol=1e-9)
    assert not drive.now.gyro_since(start)


def test_what_was_turned_since_standing_at_the_start_is_known() -> None:
    drive = Drive()
    start = drive.now
    drive.go(2.0, 0.0, 0.0)
    drive.go(1.0, 0.3, 0.5)
    assert drive.now.gyro_since(start)


@pytest.mark.parametrize("rate", [0.5, 0.05, 0.015])
def test_who_turns_the_robot_by_hand_does_not_teach_it_a_bias(rate: float) -> None:
    drive = Drive.rested()
    drive.go(3.0, 0.0, rate, wheels=False)
    assert drive.error()[1] == pytest.approx(0.0, abs=0.005)
    drive.go(10.0, 0.3, 0.2)
    assert abs(drive.error()[1]) < 0.01


def test_who_shakes_the_robot_at_the_start_does_not_teach_it_a_bias() -> None:
    drive = Drive()
    for _ in range(20):
        drive.stamp += PERIOD
        frame = drive.frame(0.0)
        frame.imu.gyro[:] += 0.1 * np.sin(np.arange(len(frame.imu.gyro)))[:, None]
        drive.now = drive.dead_reckoning.update(frame, drive.T_wheels)
    before = drive.now
    drive.go(0.5, 0.3, 0.5)
    assert not drive.now.gyro_since(before)


def test_a_bias_that_creeps_is_followed_while_the_robot_stands() -> None:
    drive = Drive.rested()
    drive.bias += 0.004
    drive.go(60.0, 0.0, 0.0)
    drive.T_true = drive.now.T_odom_base
    drive.go(20.0, 0.3, 0.2)
    assert abs(drive.error()[1]) < 0.02


def test_a_robot_that_brakes_has_turned_by_the_integral_of_the_rate() -> None:
    drive = Drive(bias=0.0)
    drive.go(2.0, 0.0, 0.0)
    before, frame = drive.now, drive.next_frame()
    rates = np.linspace(1.0, 0.0, len(frame.imu.gyro))
    frame.imu.gyro[:] = rates[:, None] * T_BASE_CAM[2, :3]
    # Some are late, some early: they lie where their stamps say.
    frame.imu.gyro_stamps[-5:] = frame.imu.gyro_stamps[-5] + np.arange(5) * 1e-4
    drive.T_wheels = drive.T_wheels @ turned(0.06)
    now = drive.dead_reckoning.update(frame, drive.T_wheels)
    assert yaw_of(now.since(before)) == pytest.approx(0.05, abs=0.006)
    assert now.gyro_since(before)


@pytest.mark.parametrize("kept", [[], [0], [0, 1, 2, 3, 4], [0, 1, 2, 17, 18, 19]])
def test_a_frame_that_lacks_samples_is_carried_by_the_wheels(kept: list[int]) -> None:
    drive = Drive.rested()
    before, frame = drive.now, drive.next_frame()
    few = ImuSamples(frame.imu.gyro_stamps[kept], frame.imu.gyro[kept], *2 * (np.zeros(0),))
    torn = RGBDFrame(drive.stamp, frame.rgb, frame.depth, frame.intrinsics, few)
    now = drive.dead_reckoning.update(torn, drive.T_wheels @ rolled(0.02, 0.03, TRACK))
    assert not now.gyro_since(before)
    assert yaw_of(now.since(before)) == pytest.approx(0.01 / TRACK)


@pytest.mark.parametrize("broken", [np.nan, np.inf])
@pytest.mark.parametrize("standing", [True, False])
def test_a_sample_that_is_no_number_costs_its_frame_alone(broken: float, standing: bool) -> None:
    drive = Drive()
    drive.go(1.0, 0.0, 0.0)
    if not standing:
        drive.go(1.0, 0.3, 0.2)
    before, frame = drive.now, drive.next_frame()
    frame.imu.gyro[5, 1] = broken
    drive.T_wheels = drive.T_wheels @ rolled(0.0, 0.0 if standing else 0.01, TRACK)
    torn = drive.dead_reckoning.update(frame, drive.T_wheels)
    assert yaw_of(torn.since(before)) == pytest.approx(0.0 if standing else 0.01 / TRACK)
    assert not torn.gyro_since(before)
    drive.T_true = torn.T_odom_base
    drive.go(2.0, 0.3, 0.5)
    assert drive.now.gyro_since(torn)
    assert abs(drive.error()[1]) < 0.005


def test_a_clock_that_is_set_back_leaves_the_bias_known() -> None:
    drive = Drive.rested()
    drive.stamp -= 900.0
    drive.go(0.1, 0.3, 0.0)
    before = drive.now
    drive.go(2.0, 0.3, 0.5)
    assert 0.0 < drive.now.bias_sigma < 1e-3
    assert drive.now.gyro_since(before)
    assert gyro_sigma(before, drive.now) < 0.02
