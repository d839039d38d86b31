"""Turns and ways that somebody names."""

from math import pi, radians

import numpy as np
import pytest

from nav.config import NavigatorConfig
from vizbot.behaviours.short_motion import ShortMotion
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome
from vizbot.core.types import OccupancyGrid
from vizbot.objectnav.tasks import ShortMove

PERIOD = 0.2


def floor(*obstacles, zones=()):
    """A floor of 8 m x 8 m around the origin, with obstacles at x, y [m]."""
    grid = OccupancyGrid(np.full((160, 160), 0.1, np.float32), 0.05, np.full(2, -4.0), zones)
    for xy in obstacles:
        grid.occupancy[tuple(grid.to_cells(np.array(xy)))] = 0.95
    return grid


def moved(move, grid, x=0.0, y=0.0, yaw=0.0, motion=None, most=400):
    """Where the robot is once the move is over, how far it turned, and how the move ended."""
    motion, turned = motion or ShortMotion(NavigatorConfig()), 0.0
    for _ in range(most):
        decision = motion.decide(move, planar(x, y, yaw), grid)
        if decision.ended is not None:
            return (x, y, turned), decision.ended
        yaw += PERIOD * decision.twist.angular
        turned += PERIOD * decision.twist.angular
        x += PERIOD * decision.twist.linear * np.cos(yaw)
        y += PERIOD * decision.twist.linear * np.sin(yaw)
    raise AssertionError("it never ends")


@pytest.mark.parametrize("degrees", [90.0, -90.0, 45.0, 180.0, -180.0, 270.0, 360.0, 10.0])
def test_it_turns_by_the_angle_that_was_named(degrees):
    (_, _, turned), (outcome, _) = moved(ShortMove(turn=radians(degrees)), floor(), yaw=2.5)
    assert outcome is Outcome.ARRIVED
    assert turned == pytest.approx(radians(degrees), abs=radians(4.0))


@pytest.mark.parametrize("yaw", [0.0, pi / 2, -2.0])
def test_it_drives_straight_ahead_as_far_as_was_named(yaw):
    (x, y, _), (outcome, _) = moved(ShortMove(forward=1.5), floor(), yaw=yaw)
    assert outcome is Outcome.ARRIVED
    assert (x, y) == pytest.approx((1.5 * np.cos(yaw), 1.5 * np.sin(yaw)), abs=0.05)


def test_it_stops_before_what_stands_in_the_way():
    (x, y, _), (outcome, reason) = moved(ShortMove(forward=3.0), floor((1.5, 0.0)))
    assert outcome is Outcome.GAVE_UP
    assert "something is in the way after" in reason
    assert 0.8 < x < 1.5 - 0.175 and y == pytest.approx(0.0, abs=0.01)


def test_it_enters_no_zone_and_leaves_no_map():
    zone = np.array([[1.0, -1.0], [2.0, -1.0], [2.0, 1.0], [1.0, 1.0]], np.float32)
    (x, _, _), (outcome, _) = moved(ShortMove(forward=3.0), floor(zones=(zone,)))
    assert outcome is Outcome.GAVE_UP and x < 1.0 - 0.15
    (x, _, _), (outcome, _) = moved(ShortMove(forward=5.0), floor(), x=2.0)
    assert outcome is Outcome.GAVE_UP and x < 4.0


def test_what_something_else_has_moved_goes_no_further():
    motion, move = ShortMotion(NavigatorConfig()), ShortMove(forward=1.0)
    assert motion.decide(move, planar(0.0, 0.0, 0.0), floor()).ended is None
    motion.interrupt()
    decision = motion.decide(move, planar(0.0, 2.0, 1.0), floor())
    assert decision.ended == (Outcome.GAVE_UP, "something else has moved the robot meanwhile")
    assert motion.decide(move, planar(0.0, 2.0, 1.0), floor()).ended is None


def test_a_move_is_told_in_plain_words():
    assert ShortMove(turn=pi / 2).text == "turn left 90°"
    assert ShortMove(turn=-pi / 4).text == "turn right 45°"
    assert ShortMove(forward=1.5).text == "go forward 1.5 m"
