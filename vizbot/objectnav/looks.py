"""Where the robot has looked: at places from near, and all around."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.geometry import wrap_angle, yaw_of
from vizbot.core.types import SE3, Twist

APART = 0.8
"""Places nearer to each other than this count as one thing [m]."""


class Looks:
    """Places that a search has looked at from near without believing them."""

    def __init__(self) -> None:
        self._places_xy = np.zeros((0, 2))

    def add(self, place_xy: NDArray[np.float64]) -> None:
        """A place (2,) was looked at, in `map` [m]."""
        self._places_xy = np.vstack([self._places_xy, place_xy])

    def are_done(self, places_xy: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which (N,) places (N, 2) were looked at."""
        away = np.linalg.norm(places_xy[:, None] - self._places_xy, axis=2)
        return np.asarray((away <= APART).any(axis=1))


class Turns:
    """Spots on which the robot has turned around once, to see all that is there."""

    def __init__(self, rate: float) -> None:
        """Turn at `rate` [rad/s]."""
        self._rate = rate
        self._done_xy = np.zeros((0, 2))
        self._turn: LookAround | None = None
        self._begun_xy = np.zeros(2)

    def twist(self, T_map_base: SE3) -> Twist | None:
        """The twist to drive now; None where the turn is complete, or was done near here."""
        here = T_map_base[:2, 3]
        if (np.linalg.norm(self._done_xy - here, axis=1) <= APART).any():
            return None
        if self._turn is None or np.linalg.norm(self._begun_xy - here) > APART:
            self._turn, self._begun_xy = LookAround(self._rate), here.copy()
        twist = self._turn.twist(T_map_base)
        if twist is None:
            self._turn, self._done_xy = None, np.vstack([self._done_xy, here])
        return twist


class LookAround:
    """Turns once around, measured by the pose and not by time."""

    def __init__(self, rate: float) -> None:
        """Turn at `rate` [rad/s]."""
        self._rate = rate
        self._left = 2 * np.pi
        self._yaw: float | None = None

    def twist(self, T_map_base: SE3) -> Twist | None:
        """The twist to drive now; None once the turn is complete."""
        if self._left <= 0.0:
            return None
        yaw = yaw_of(T_map_base)
        if self._yaw is not None:
            self._left -= abs(wrap_angle(yaw - self._yaw))
        self._yaw = yaw
        return Twist(0.0, self._rate)
