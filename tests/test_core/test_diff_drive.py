import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vizbot.core import diff_drive
from vizbot.core.geometry import planar, yaw_of
from vizbot.core.types import Twist

WHEEL_BASE = 0.235
speeds = st.floats(-0.5, 0.5)


@given(speeds, speeds)
def test_wheel_speeds_average_to_the_speed_and_differ_by_the_turn(linear, angular):
    left, right = diff_drive.wheel_speeds(Twist(linear, angular), WHEEL_BASE)
    np.testing.assert_allclose((left + right) / 2, linear, atol=1e-12)
    np.testing.assert_allclose((right - left) / WHEEL_BASE, angular, atol=1e-12)


@given(st.floats(-2.0, 2.0), st.floats(-10.0, 10.0))
def test_the_wheel_limit_holds_and_keeps_the_curvature(linear, angular):
    limited = diff_drive.within_wheel_limit(Twist(linear, angular), WHEEL_BASE, 0.5)
    assert max(map(abs, diff_drive.wheel_speeds(limited, WHEEL_BASE))) <= 0.5 + 1e-9
    assert abs(limited.linear * angular - limited.angular * linear) < 1e-9


def test_counter_clockwise_is_positive_and_needs_the_right_wheel_forward():
    left, right = diff_drive.wheel_speeds(Twist(0.0, 1.0), WHEEL_BASE)
    assert left < 0.0 < right


@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
def test_one_arc_equals_many_small_straight_steps(left, right):
    parts = 2000
    T = np.eye(4)
    for _ in range(parts):
        distance, angle = (left + right) / 2 / parts, (right - left) / WHEEL_BASE / parts
        T = T @ planar(distance * np.cos(angle / 2), distance * np.sin(angle / 2), angle)
    arc = diff_drive.rolled(left, right, WHEEL_BASE)
    np.testing.assert_allclose(arc, T, atol=1e-6)


def test_the_manuals_example_of_odometry_comes_out():
    # Fact sheet, section 11: left +1000, right +1100 counts are 466.79 mm ahead, +10.84 degrees.
    metres_per_count = np.pi * 0.072 / 508.8
    T = diff_drive.rolled(1000 * metres_per_count, 1100 * metres_per_count, WHEEL_BASE)
    assert abs(np.degrees(yaw_of(T)) - 10.84) < 0.005
    chord = np.hypot(*T[:2, 3])
    assert abs(chord - 0.46679 * np.sinc(np.radians(10.84) / 2 / np.pi)) < 1e-5
