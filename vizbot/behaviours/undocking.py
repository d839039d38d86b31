"""Leaving the dock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nav.config import RecoveryConfig
from vizbot.core.types import SE3, BaseState, Twist
from vizbot.objectnav.tasks import Decision


class Undocking:
    """Backs away from the dock, which stands in front of the robot, until it can turn."""

    def __init__(self, config: RecoveryConfig) -> None:
        self._config = config
        self._docked_at: NDArray[np.float64] | None = None

    def decide(self, state: BaseState, T_map_base: SE3) -> Decision | None:
        """What to do on the dock and close to it; None away from it."""
        here = T_map_base[:2, 3]
        if state.docked and self._docked_at is None:
            self._docked_at = here.copy()
        if self._docked_at is None:
            return None
        if np.linalg.norm(here - self._docked_at) >= self._config.undocking:
            self._docked_at = None
            return None
        return Decision(Twist(-self._config.back_off_speed, 0.0), "leaving the dock")
