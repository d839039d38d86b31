"""The motion of one step of Algorithm 1, which may take several frames.

A step moves the robot by 0.25 m or 30 degrees at most, as in the paper's simulator (section IV-C).
A robot that has not used that up by the next frame drives on along its path, by where it is then:
what the frame shows is tracked and kept off, and is not embedded.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np

from nav.follower import FollowerConfig, accelerate, follow_path
from vizbot.core.geometry import invert, yaw_of
from vizbot.core.interfaces import Base
from vizbot.core.types import SE3, STOP, Twist
from vizbot.objectnav.tasks import Decision

LENGTH = 0.25
"""Longest way of a step [m]."""
TURN = radians(30.0)
"""Largest turn of a step [rad]."""


class StepMotion:
    """What is left of a step."""

    def __init__(self, config: FollowerConfig) -> None:
        """No step has begun."""
        self._config = config
        self._begun: tuple[Decision, SE3] | None = None
        self._twist = STOP
        self._commanded = np.zeros(2)

    def begin(self, decision: Decision, T_map_base: SE3) -> None:
        """A decision was made where the robot was then."""
        self._begun = decision, T_map_base
        self._twist, self._commanded = decision.twist, np.zeros(2)

    def goes_on(self, T_map_base: SE3, period: float) -> Twist | None:
        """How to drive on until the next frame; None when the next step is due.

        Args:
            T_map_base: Where the robot is.
            period: Since the frame before and until the next [s].
        """
        if self._begun is None:
            return None
        decision, T_map_begun = self._begun
        if decision.navigation is None or decision.twist.linear <= 0.0:
            return None
        self._commanded += period * np.abs((self._twist.linear, self._twist.angular))
        T_begun_base = invert(T_map_begun) @ T_map_base
        moved = np.array((np.linalg.norm(T_begun_base[:2, 3]), abs(yaw_of(T_begun_base))))
        onward = follow_path(decision.navigation.path, T_map_base, self._config)
        # Beside obstacles the decision is slow.
        onward = replace(onward, linear=min(onward.linear, decision.twist.linear))
        # A robot that is held has had its step as well.
        spent = np.maximum(moved, self._commanded)
        spent += period * np.abs((onward.linear, onward.angular))
        if onward.linear <= 0.0 or spent[0] > LENGTH or spent[1] > TURN:
            return None
        self._twist = onward
        return onward


class TwistLimiter:
    """Remembers what was told last."""

    def __init__(self, config: FollowerConfig, longest: float) -> None:
        """The base is at rest.

        Args:
            config: Accelerations.
            longest: After so long without a command a base has stopped by itself [s].
        """
        self._config = config
        self._longest = longest
        self._twist = STOP
        self._at = 0.0

    def since(self, stamp: float) -> float:
        """Time from the last command to `stamp` [s]."""
        return stamp - self._at

    def drive(self, base: Base | None, twist: Twist, stamp: float) -> Twist:
        """Drive as much of a change of twist as the time since the last command allows.

        Without a base it is only computed.
        """
        period = min(max(self.since(stamp), 0.0), self._longest)
        self._twist, self._at = accelerate(twist, self._twist, period, self._config), stamp
        if base is not None:
            base.drive(self._twist)
        return self._twist

    def let_go(self) -> None:
        """Somebody else drives, or nobody does: when it is our turn again the base is at rest."""
        self._twist = STOP
