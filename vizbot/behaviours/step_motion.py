"""The motion of one step of Algorithm 1, which may take several frames.

A step moves the robot by 0.25 m or 30 degrees at most, as in the paper's simulator (section IV-C).
A robot that has not used that up by the next frame drives on along its path, from where it is then.
That frame is tracked and its obstacles are mapped, but it is not embedded.

The twists are not ramped here: the base's driver limits how fast the wheels speed up.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np

from nav.config import FollowerConfig
from nav.follower import follow_path
from vizbot.core.geometry import invert, yaw_of
from vizbot.core.types import SE3, STOP, Twist
from vizbot.objectnav.tasks import Decision

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
        # A robot that something holds uses up its step by what it was commanded.
        used = np.maximum(moved, self._commanded)
        used += period * np.abs((twist.linear, twist.angular))
        if twist.linear <= 0.0 or used[0] > LENGTH or used[1] > TURN:
            return None
        self._twist, self._commanded_at = twist, stamp
        return twist
