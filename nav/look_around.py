"""A turn on the spot, to see the surroundings before driving anywhere."""

from __future__ import annotations

import numpy as np

from vizbot.core.geometry import wrap_angle, yaw_of
from vizbot.core.types import SE3, Twist


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
