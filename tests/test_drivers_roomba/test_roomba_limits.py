"""Speeds, turn rates and ramps that the configuration allows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.roomba.config import RoombaConfig
from drivers.roomba.drive_command import harmless, within_limits
from drivers.roomba.packets import Packet
from tests.helpers.roomba_rig import PERIOD
from vizbot.core.diff_drive import wheel_speeds
from vizbot.core.types import STOP, Twist


def speeds_over(rig, twist, seconds):
    """Left and right speed (N, 2) after each period [m/s]."""
    speeds = []
    for _ in range(round(seconds / PERIOD)):
        rig.drive(twist, PERIOD)
        speeds.append(rig.floor.speeds)
    return np.array(speeds)


def test_wheels_speed_up_and_slow_down_along_ramps(open_rig):
    rig = open_rig(acceleration=1.0, deceleration=2.0)
    up = speeds_over(rig, Twist(0.25, 0.0), 0.4)
    down = speeds_over(rig, Twist(0.05, 0.0), 0.4)
    # Data bytes are kept out of opcodes by steps of up to 20 mm/s.
    assert np.diff(up[:, 0]).max() < 1.0 * PERIOD + 0.021
    assert -np.diff(down[:, 0]).min() < 2.0 * PERIOD + 0.021
    assert np.flatnonzero(up[:, 0] >= 0.25)[0] * PERIOD == pytest.approx(0.25, abs=2 * PERIOD)
    assert np.flatnonzero(down[:, 0] <= 0.05)[0] * PERIOD == pytest.approx(0.1, abs=2 * PERIOD)
    assert (up[:, 0] == up[:, 1]).all() and (down[:, 0] == down[:, 1]).all()


def test_a_ramp_keeps_the_curvature(open_rig):
    left, right = speeds_over(open_rig(acceleration=1.0), Twist(0.25, 1.0), 0.4).T
    moving = right > 0.1
    assert (right[moving] / left[moving]).mean() == pytest.approx(0.3675 / 0.1325, rel=0.1)


@pytest.mark.parametrize("stopped_by", ["a command", "a reflex"])
def test_a_stop_is_not_ramped(open_rig, stopped_by):
    rig = open_rig(acceleration=1.0, deceleration=0.2)
    rig.drive(Twist(0.25, 0.0), 1.0)
    if stopped_by == "a command":
        rig.drive(STOP, 2 * PERIOD)
    else:
        rig.clock.sleep(0.33)
    assert rig.floor.speeds == (0.0, 0.0)


def test_a_turn_that_is_too_fast_keeps_its_curvature(open_rig):
    rig = open_rig(max_turn_rate=1.0)
    rig.drive(Twist(0.3, 2.0), 2 * PERIOD)
    left, right = rig.floor.speeds
    assert (right - left) / 0.235 == pytest.approx(1.0, abs=0.05)
    assert (right + left) / 2 == pytest.approx(0.15, abs=0.005)


@pytest.mark.parametrize(("limit", "scale"), [(0.138, 1.0), (0.3, 1.0), (0.14, 1.02)])
def test_keeping_opcodes_out_of_a_speed_drives_no_wheel_faster_than_allowed(open_rig, limit, scale):
    rig = open_rig(max_wheel_speed=limit, wheel_scale=scale)
    for twist in (Twist(0.5, 0.0), Twist(-0.5, 0.0)):
        rig.drive(twist, 4 * PERIOD)
        speeds = scale * np.abs(rig.floor.speeds)
        assert speeds.max() <= limit
        assert speeds.min() > 0.8 * limit


@pytest.mark.parametrize(
    ("tolerance", "off", "drives"), [(0.0, 1, False), (0.01, 10, True), (0.01, 11, False)]
)
def test_firmware_may_round_commanded_speeds_if_allowed_to(
    open_rig, caplog, tolerance, off, drives
):
    rig = open_rig(echo_tolerance=tolerance)
    publish = rig.stub.publish

    def rounded():
        left, right = (round(1000 * speed) for speed in rig.floor.speeds)
        rig.stub.overrides = {
            Packet.REQUESTED_LEFT_VELOCITY: left + off * (left != 0),
            Packet.REQUESTED_RIGHT_VELOCITY: right + off * (right != 0),
        }
        publish()

    rig.stub.publish = rounded
    rig.drive(Twist(0.2, 0.0), 2.0)
    assert (min(rig.floor.wheel_travel) > 0.3) == drives
    assert ("raise echo_tolerance" in caplog.text) != drives


@given(
    linear=st.floats(-3.0, 3.0),
    angular=st.floats(-40.0, 40.0),
    wheel_base=st.floats(0.15, 0.35),
    wheel_scale=st.floats(0.8, 1.25),
    max_wheel_speed=st.floats(0.05, 0.5),
    max_turn_rate=st.floats(0.1, 4.3),
)
def test_the_limits_hold_for_what_the_wheels_do_whatever_the_calibration_says(
    linear, angular, wheel_base, wheel_scale, max_wheel_speed, max_turn_rate
):
    config = RoombaConfig(
        wheel_base=wheel_base, wheel_scale=wheel_scale,
        max_wheel_speed=max_wheel_speed, max_turn_rate=max_turn_rate,
    )  # fmt: skip
    left, right = wheel_speeds(Twist(linear, angular), wheel_base)
    sent = np.array(within_limits(right, left, config)) / 1000
    assert np.abs(sent).max() <= max_wheel_speed + 1e-9 and np.abs(sent).max() <= 0.5
    assert wheel_scale * np.abs(sent).max() <= max_wheel_speed + 1e-9
    turn = abs(sent[0] - sent[1]) / 0.235
    assert turn <= max_turn_rate + 1e-9 and wheel_scale * turn <= max_turn_rate + 1e-9


@pytest.mark.parametrize("wheel_base", [0.235, 0.35])
def test_a_wrong_distance_of_wheels_makes_no_turn_faster_than_allowed(open_rig, wheel_base):
    rig = open_rig(wheel_base=wheel_base)
    rig.drive(Twist(0.0, 2.0), 1.0)
    left, right = rig.floor.speeds
    assert 1.8 <= (right - left) / 0.235 <= 2.0


def test_a_twist_within_the_limits_is_sent_as_it_is():
    config = RoombaConfig()
    for linear, angular in ((0.43, 0.3), (0.0, 1.3), (-0.12, 0.0), (0.2, -1.0)):
        left, right = wheel_speeds(Twist(linear, angular), config.wheel_base)
        wanted = harmless(round(1000 * right)), harmless(round(1000 * left))
        assert within_limits(right, left, config) == wanted
