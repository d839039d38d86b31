"""How long the robot searches for a goal, and how far it drives for it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Effort
from vizbot.core.types import SE3
from vizbot.objectnav.tasks import Goal


class Odometer:
    """Measures the search that is under way; what somebody drives by hand meanwhile counts."""

    def __init__(self) -> None:
        self._goal: Goal | None = None
        self._began = self._now = self._way = 0.0
        self._xy: NDArray[np.float64] | None = None

    def observe(self, goal: Goal | None, T_map_base: SE3, now: float) -> None:
        """Observe a step.

        Args:
            goal: What is searched for; another one begins anew, None goes on.
            T_map_base: Where the robot is.
            now: Time of the run's clock [s].
        """
        if goal is not None and goal is not self._goal:
            self._goal, self._began, self._way, self._xy = goal, now, 0.0, None
        xy = T_map_base[:2, 3].copy()
        if self._xy is not None:
            self._way += float(np.linalg.norm(xy - self._xy))
        self._xy, self._now = xy, now

    def effort(self, goal: Goal) -> Effort | None:
        """What the search for a goal took; None where it is not the last one that began."""
        if goal is not self._goal:
            return None
        return Effort(self._now - self._began, self._way)
