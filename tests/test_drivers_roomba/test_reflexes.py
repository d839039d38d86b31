"""The rules by which contacts limit the motion of the base."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.roomba.drive_command import GENTLY, allowed
from vizbot.core.types import STOP, BaseMode, BaseState, Twist

CLEAR = BaseState(0.0, np.eye(4), False, False, (False,) * 4, (False, False), 1.0, BaseMode.SAFE)
EDGES = [{"cliffs": tuple(n == sensor for n in range(4))} for sensor in range(4)]
STUCK = [{"overcurrents": (True, False)}, {"overcurrents": (False, True)}]
AHEAD, BACK, TURN = Twist(0.2, 0.0), Twist(-0.1, 0.0), Twist(0.0, 0.5)


@pytest.mark.parametrize("felt", EDGES + STUCK)
def test_at_a_cliff_or_with_a_stuck_wheel_the_base_backs_off_straight_and_does_nothing_else(felt):
    state = replace(CLEAR, **felt)
    assert allowed(BACK, state) == BACK
    for twist in (AHEAD, TURN, Twist(-0.1, 0.5), Twist(-0.1, -0.01), Twist(0.2, 0.5), STOP):
        assert allowed(twist, state) == STOP


@pytest.mark.parametrize(
    "felt", [{"bump_left": True}, {"bump_right": True}, {"virtual_wall": True}]
)
def test_at_an_obstacle_the_base_backs_off_and_turns_but_goes_no_further(felt):
    state = replace(CLEAR, **felt)
    for twist in (BACK, TURN, Twist(-0.1, 0.5)):
        assert allowed(twist, state) == twist
    for twist in (AHEAD, Twist(0.01, 0.5)):
        assert allowed(twist, state) == STOP


@pytest.mark.parametrize(
    "felt",
    [
        {"mode": BaseMode.PASSIVE},
        {"mode": BaseMode.OFF},
        {"wheel_drops": (True, False)},
        {"wheel_drops": (False, True)},
        {"plugged_in": True},
    ],
)
def test_a_base_that_is_lifted_plugged_in_or_does_not_obey_stands_still(felt):
    for twist in (AHEAD, BACK, TURN):
        assert allowed(twist, replace(CLEAR, **felt)) == STOP


@pytest.mark.parametrize("sensor", range(6))
def test_what_reflects_ahead_slows_the_base_on_the_same_arc_and_at_the_sides_it_does_not(sensor):
    state = replace(CLEAR, light_bumpers=tuple(n == sensor for n in range(6)))
    twist = allowed(Twist(2 * GENTLY, 0.5), state)
    assert twist == (Twist(2 * GENTLY, 0.5) if sensor in (0, 5) else Twist(GENTLY, 0.25))
    for slow in (Twist(GENTLY, 0.5), BACK, TURN):
        assert allowed(slow, state) == slow
