import numpy as np
import pytest

from nav.config import FollowerConfig
from nav.navigator import Navigation
from vizbot.behaviours.short_motion import LENGTH, TURN, StepMotion
from vizbot.core.geometry import planar, yaw_of
from vizbot.core.types import STOP, Twist
from vizbot.objectnav.tasks import Decision

PERIOD = 0.1
HERE = np.eye(4)


def along(path, twist):
    """The decision to drive so along a path."""
    path = np.array(path, float)
    return Decision(twist, "exploring", Navigation(twist, path, None, path[-1], 5.0, False))


AHEAD = along([[0.0, 0.0], [3.0, 0.0]], Twist(0.4, 0.0))


def frames_of_a_step(decision, moves):
    """How many frames follow before the next decision is due, and where the robot is then."""
    motion = StepMotion(FollowerConfig())
    motion.begin(decision, HERE, 0.0)
    T_map_base, twist = HERE, decision.twist
    for frames in range(100):
        if moves:
            T_map_base = T_map_base @ planar(twist.linear * PERIOD, 0.0, twist.angular * PERIOD)
        onward = motion.next_twist(T_map_base, PERIOD * (frames + 1))
        if onward is None:
            return frames, T_map_base
        twist = onward
    raise AssertionError("the step does not end")


@pytest.mark.parametrize(
    "path", [[[0.0, 0.0], [3.0, 0.0]], [[0.0, 0.0], [0.2, 0.02], [0.4, 0.3], [0.4, 3.0]]]
)
def test_a_step_takes_several_frames_and_moves_by_no_more_than_it_may(path):
    frames, T_map_base = frames_of_a_step(along(path, Twist(0.4, 0.0)), moves=True)
    assert frames > 1
    assert np.linalg.norm(T_map_base[:2, 3]) <= LENGTH
    assert abs(yaw_of(T_map_base)) <= TURN


def test_a_straight_step_is_a_quarter_of_a_metre_less_what_another_frame_would_add():
    _, T_map_base = frames_of_a_step(AHEAD, moves=True)
    assert 0.25 - AHEAD.twist.linear * PERIOD < T_map_base[0, 3] <= 0.25
    assert np.degrees(TURN) == pytest.approx(30.0)


def test_a_robot_that_is_held_decides_again_as_soon():
    frames, _ = frames_of_a_step(AHEAD, moves=False)
    assert frames <= LENGTH / (0.4 * PERIOD)


def test_between_two_decisions_the_robot_follows_its_path_from_where_it_is():
    motion = StepMotion(FollowerConfig())
    assert motion.begin(AHEAD, HERE, 0.0) == AHEAD.twist
    onward = motion.next_twist(planar(0.04, 0.05, 0.1), PERIOD)
    assert onward.angular < 0.0
    assert onward.linear <= AHEAD.twist.linear


@pytest.mark.parametrize(
    "decision",
    [
        Decision(STOP, "making sure"),
        Decision(Twist(0.0, 1.0), "looking around"),
        along([[0.0, 0.0], [-3.0, 0.0]], Twist(0.0, 1.0)),
        along([[0.0, 0.0], [0.0, 3.0]], Twist(0.4, 0.0)),
    ],
)
def test_who_stands_or_turns_on_the_spot_decides_at_every_frame(decision):
    motion = StepMotion(FollowerConfig())
    assert motion.next_twist(HERE, PERIOD) is None
    motion.begin(decision, HERE, PERIOD)
    assert motion.next_twist(HERE, 2 * PERIOD) is None
