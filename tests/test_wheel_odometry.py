"""Encoder counts and dead reckoning: the steps and figures of the fact sheet."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.roomba_oi import (
    METRES_PER_COUNT,
)
from drivers.wheel_odometry import WheelOdometry, counts_between
from vizbot.core.geometry import yaw_of


@pytest.mark.parametrize(
    ("old", "new", "step"),
    [(32765, -32766, 5), (-32766, 32765, -5), (65530, 5, 11), (5, 65530, -11)],
)
def test_encoder_steps_cross_the_roll_over_both_ways(old, new, step):
    assert counts_between(old, new) == step


@given(st.integers(-32768, 32767), st.integers(-32767, 32767))
def test_any_encoder_step_is_recovered(old, step):
    assert counts_between(old, (old + step + 32768) % 65536 - 32768) == step


def test_counts_make_the_metres_and_degrees_of_the_manual():
    odometry = WheelOdometry(wheel_base=0.235, wheel_scale=1.0)
    odometry.update(0, 0)
    T_odom_base = odometry.update(1000, 1100)
    assert pytest.approx(0.444565e-3, abs=5e-10) == METRES_PER_COUNT
    assert pytest.approx(0.46679, abs=5e-6) == 1050 * METRES_PER_COUNT
    assert yaw_of(T_odom_base) == pytest.approx(10.84 * 3.14159265 / 180, abs=1e-4)
    # The chord of the arc is shorter than the 466.79 mm along it.
    assert float((T_odom_base[:2, 3] ** 2).sum() ** 0.5) == pytest.approx(0.46609, abs=5e-5)
