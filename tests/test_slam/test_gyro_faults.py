"""When the gyroscope is believed, and when wheels or images are."""

import numpy as np
import pytest

from tests.test_slam.dead_reckoning_drive import Drive
from vizbot.core.geometry import yaw_of


@pytest.mark.parametrize("off", [0.05, -0.015])
def test_standing_wheels_win_against_a_gyroscope_that_turns_evenly_for_long(off: float) -> None:
    drive = Drive.rested()
    before = drive.now
    drive.bias += off
    drive.go(20.0, 0.0, 0.0)
    assert abs(drive.error()[1]) < 0.005
    assert not drive.now.gyro_since(before)
    drive.bias -= off
    drive.go(8.0, 0.0, 0.0)
    after = drive.now
    drive.go(5.0, 0.3, 0.5)
    assert drive.now.gyro_since(after)
    assert abs(drive.error()[1]) < 0.02


def test_who_turns_the_robot_by_hand_for_long_is_no_bias() -> None:
    """Not evenly, or not slowly."""
    drive = Drive.rested()
    for rate in [0.03, 0.06, 0.045, 0.08, 0.05, 0.02] * 3:
        drive.go(1.0, 0.0, rate, wheels=False)
    drive.go(10.0, 0.0, 0.3, wheels=False)
    drive.go(1.0, 0.0, 0.0)
    assert abs(drive.error()[1]) < 0.02


@pytest.mark.parametrize(
    ("wheels", "gyro", "furthest", "most"),
    [
        ("fine", "fine", 0.02, 0.02),
        ("fine", "missing", 0.5, 0.2),
        ("fine", "lies", 0.5, 0.2),
        ("lie", "fine", 1.2, 0.02),
        ("lie", "missing", 1.2, 0.6),
        ("lie", "lies", 1.2, 0.6),
        ("count nothing", "fine", 5.0, 0.02),
    ],
)
def test_where_images_show_nothing_a_lie_costs_no_more_than_a_sensor_that_is_missing(
    wheels: str, gyro: str, furthest: float, most: float
) -> None:
    drive = Drive.rested()
    drive.slip = {"fine": 0.0, "lie": 0.2, "count nothing": -1.0}[wheels]
    drive.gyro = gyro != "missing"
    drive.bias += 0.15 * (gyro == "lies")
    for turn in (0.0, 0.3, 0.0):
        drive.go(6.0, 0.3, turn)
    distance, angle = drive.error()
    assert distance < furthest and abs(angle) < most


@pytest.mark.parametrize("slip", [0.2, 0.5])
def test_wheels_that_slip_in_turns_for_long_do_not_win_against_the_gyroscope(slip: float) -> None:
    drive = Drive.rested()
    drive.slip = slip
    before = drive.now
    drive.go(20.0, 0.3, 0.5)
    assert drive.now.gyro_since(before)
    assert abs(drive.error()[1]) < 0.01


def test_images_that_turn_like_the_gyroscope_clear_it_of_the_suspicion_that_it_lies() -> None:
    drive = Drive.rested()
    drive.slip = -0.5  # encoders that miss half of the ticks
    start = drive.now
    for _ in range(20):
        drive.look(1.0, 0.3, 0.5)
    assert drive.now.gyro_since(start)
    assert abs(drive.error()[1]) < 0.02


@pytest.mark.parametrize("turning", [0.0, 0.5, -1.0])
def test_images_and_wheels_outvote_a_gyroscope_that_lies_in_turns_too(turning: float) -> None:
    drive = Drive.rested()
    for _ in range(40):  # what wheels and gyroscope read too much is learned
        drive.look(0.4, 0.3, turning)
    start = drive.now
    drive.bias += 0.05
    for _ in range(6):
        drive.look(0.4, 0.3, turning)
    assert not drive.now.gyro_since(start)
    T_start, start = drive.T_true, drive.now
    drive.look(2.0, 0.3, turning)
    off = yaw_of(drive.now.since(start)) - yaw_of(np.linalg.inv(T_start) @ drive.T_true)
    assert abs(off) < 0.03, "0.1 by the gyroscope"


def test_images_alone_do_not_outvote_the_gyroscope() -> None:
    drive = Drive.rested()
    for _ in range(40):
        drive.look(0.4, 0.3, 0.5)
    start = drive.now
    for _ in range(40):
        drive.look(0.4, 0.3, 0.5, off=0.05)
    assert drive.now.gyro_since(start)
