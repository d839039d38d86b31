"""Encoder counts and dead reckoning: the steps and figures of the fact sheet."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.roomba.commands import METRES_PER_COUNT
from drivers.roomba.odometry import WheelOdometry, counts_between, without_reversal
from drivers.roomba.serial_port import open_serial
from sim_stubs.roomba.base import SimulatedRoomba
from tests.helpers.roomba_rig import Floor, open_lockstep
from vizbot.core.geometry import invert, yaw_of
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import Twist


class SluggishFloor(Floor):
    """An empty floor for wheels that take their time to reach the speed they are told."""

    def __init__(self):
        super().__init__()
        self.target = self.speeds = np.zeros(2)

    def set_wheel_speeds(self, left, right):
        self.target = np.array([left, right])

    def advance(self, seconds):
        change = 2.0 * seconds
        self.speeds = self.speeds + np.clip(self.target - self.speeds, -change, change)
        self.free.set_wheel_speeds(*self.speeds)
        super().advance(seconds)


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
    odometry.update(1000, 1100)
    T_odom_base = odometry.T_odom_base
    assert pytest.approx(0.444565e-3, abs=5e-10) == METRES_PER_COUNT
    assert pytest.approx(0.46679, abs=5e-6) == 1050 * METRES_PER_COUNT
    assert yaw_of(T_odom_base) == pytest.approx(10.84 * 3.14159265 / 180, abs=1e-4)
    # The chord of the arc is shorter than the 466.79 mm along it.
    assert float((T_odom_base[:2, 3] ** 2).sum() ** 0.5) == pytest.approx(0.46609, abs=5e-5)


def test_a_wheel_that_rolls_turns_the_other_way_only_once_it_is_at_rest():
    assert without_reversal(-200, 300, at_rest=False) == 1
    assert without_reversal(200, -300, at_rest=False) == -1
    assert without_reversal(-200, 300, at_rest=True) == -200
    assert without_reversal(150, 300, at_rest=False) == 150
    assert without_reversal(0, -300, at_rest=False) == 0


def test_odometry_holds_though_the_base_turns_this_way_and_that_way():
    clock, floor = SimulatedClock(), SluggishFloor()
    stub = SimulatedRoomba(floor)
    clock.attach(stub)
    base = open_lockstep(lambda: stub.lockstep_port(open_serial(stub.path)), clock)
    try:
        for i in range(40):
            base.drive([Twist(0.3, 0.4), Twist(0.0, -1.2), Twist(0.0, 1.2)][i % 3])
            clock.sleep(0.27)
        base.drive(Twist(0.3, 0.0))
        clock.sleep(0.27)
        T_true_odometry = invert(floor.free.T_world_base) @ base.read().T_odom_base
    finally:
        base.close()
        stub.close()
    assert abs(yaw_of(T_true_odometry)) < np.radians(4.0)
    assert np.linalg.norm(T_true_odometry[:2, 3]) < 0.05
