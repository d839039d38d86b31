"""Short motions: turns on the spot, ways straight ahead where nothing stands, single steps.

A step moves the robot by 0.25 m or 30 degrees at most, as in the paper's simulator (section IV-C).
A robot that has not used that up by the next frame drives on along its path, from where it is then.
That frame is tracked and its obstacles are mapped, but it is not embedded.

The twists are not ramped here: the base's driver limits how fast the wheels speed up.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np

from nav.config import FollowerConfig, NavigatorConfig
from nav.costmap import Costmap, build_costmap
from nav.follower import follow_path, turn_rate
from vizbot.core.geometry import invert, wrap_angle, yaw_of
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, OccupancyGrid, Twist
from vizbot.objectnav.tasks import Decision, ShortMove

_TURNED = radians(3.0)
"""Error at which a turn is over [rad]."""
_THERE = 0.03
"""Distance left at which a drive is over [m]."""
_AHEAD = 0.25
"""Distance that has to be free for the next step [m]."""
_SLOWEST = 0.05
"""[m/s]"""
_PERIOD = 0.5
"""Longest time between two steps, in which a turn must not pass its end [s]."""


class ShortMotion:
    """Does one short move at a time: turns by the pose's heading, drives where nothing stands."""

    def __init__(self, config: NavigatorConfig) -> None:
        self._config = config
        self._move: ShortMove | None = None
        self._interrupted = False
        self._turned = self._yaw = 0.0
        self._start = np.zeros(2)
        self._heading = 0.0

    def decide(self, move: ShortMove, T_map_base: SE3, grid: OccupancyGrid) -> Decision:
        """What to do in this step of a move; another `move` object than before begins anew."""
        yaw = yaw_of(T_map_base)
        if move is not self._move:
            self._move, self._turned, self._yaw = move, 0.0, yaw
            self._start, self._heading = T_map_base[:2, 3].copy(), yaw
            self._interrupted = False
        if self._interrupted:
            return self._over(Outcome.GAVE_UP, "something else has moved the robot meanwhile")
        self._turned += wrap_angle(yaw - self._yaw)
        self._yaw = yaw
        if move.turn:
            return self._turn(move.turn - self._turned)
        ahead = np.array([np.cos(self._heading), np.sin(self._heading)])
        done = float((T_map_base[:2, 3] - self._start) @ ahead)
        return self._drive(move.forward - done, done, T_map_base, grid)

    def interrupt(self) -> None:
        """End the present move: something else moves the robot."""
        self._interrupted = True

    def _turn(self, left: float) -> Decision:
        if abs(left) <= _TURNED:
            return self._over(Outcome.ARRIVED, "turned as asked")
        rate = turn_rate(left, self._config.follower)
        rate = float(np.clip(rate, -abs(left) / _PERIOD, abs(left) / _PERIOD))
        return Decision(Twist(0.0, rate), "turning", way_left=abs(left))

    def _drive(self, left: float, done: float, T_map_base: SE3, grid: OccupancyGrid) -> Decision:
        if left <= _THERE:
            return self._over(Outcome.ARRIVED, f"{max(done, 0.0):.1f} m driven as asked")
        costmap = build_costmap(grid, self._config.costmap)
        if not _is_free(costmap, T_map_base, min(left, _AHEAD)):
            reason = f"something is in the way after {max(done, 0.0):.1f} m"
            return self._over(Outcome.GAVE_UP, reason)
        follower = self._config.follower
        twist = Twist(_speed(left, follower), self._straightened(follower))
        return Decision(twist, "driving ahead", way_left=left)

    def _straightened(self, config: FollowerConfig) -> float:
        """Turn rate that takes the robot back to its heading [rad/s]."""
        return turn_rate(wrap_angle(self._heading - self._yaw), config)

    def _over(self, outcome: Outcome, reason: str) -> Decision:
        self._move = None
        return Decision(STOP, "moved as asked", ended=(outcome, reason))


def _speed(left: float, config: FollowerConfig) -> float:
    """Speed from which the robot can stop in time [m/s]."""
    stopping = float(np.sqrt(2 * config.deceleration * left))
    slow = config.max_linear * config.slow_fraction
    return max(_SLOWEST, min(slow, stopping, left / _PERIOD))


def _is_free(costmap: Costmap, T_map_base: SE3, way: float) -> bool:
    """Whether the robot may be anywhere on the way straight ahead; off the map it may not."""
    grid, yaw = costmap.grid, yaw_of(T_map_base)
    ahead = np.array([np.cos(yaw), np.sin(yaw)])
    steps = np.arange(grid.resolution, way + grid.resolution, grid.resolution)
    for x, y in T_map_base[:2, 3] + steps[:, None] * ahead:
        cell = grid.to_cells(np.array([x, y]))
        if not grid.contains(cell) or not np.isfinite(costmap.cost[tuple(cell)]):
            return False
    return True


LENGTH = 0.25
"""Longest way of a step [m]."""
TURN = radians(30.0)
"""Largest turn of a step [rad]."""


class StepMotion:
    """The twists of one step, frame by frame."""

    def __init__(self, config: FollowerConfig) -> None:
        self._config = config
        self._begun: tuple[Decision, SE3] | None = None
        self._twist = STOP
        self._commanded_at = 0.0
        self._commanded = np.zeros(2)

    def begin(self, decision: Decision, T_map_base: SE3, stamp: float) -> Twist:
        """The twist of a new step, decided at a frame's `stamp` [s]."""
        self._begun = decision, T_map_base
        self._twist, self._commanded_at = decision.twist, stamp
        self._commanded = np.zeros(2)
        return decision.twist

    def next_twist(self, T_map_base: SE3, stamp: float) -> Twist | None:
        """The twist from `stamp` [s] to the next frame; None when the next step is due."""
        if self._begun is None:
            return None
        decision, T_map_begun = self._begun
        if decision.navigation is None or decision.twist.linear <= 0.0:
            return None
        period = stamp - self._commanded_at
        self._commanded += period * np.abs((self._twist.linear, self._twist.angular))
        T_begun_base = invert(T_map_begun) @ T_map_base
        moved = np.array((np.linalg.norm(T_begun_base[:2, 3]), abs(yaw_of(T_begun_base))))
        twist = follow_path(decision.navigation.path, T_map_base, self._config)
        # Beside obstacles the decision is slow.
        twist = replace(twist, linear=min(twist.linear, decision.twist.linear))
        # For a robot that something holds, the commanded motion uses up the step.
        used = np.maximum(moved, self._commanded)
        used += period * np.abs((twist.linear, twist.angular))
        if twist.linear <= 0.0 or used[0] > LENGTH or used[1] > TURN:
            return None
        self._twist, self._commanded_at = twist, stamp
        return twist
