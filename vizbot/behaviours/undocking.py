"""Leaving the dock."""

from __future__ import annotations

import numpy as np

from nav.config import RecoveryConfig
from vizbot.core.types import SE3, STOP, BaseState, Twist
from vizbot.objectnav.tasks import Decision

SURE = 5
"""Number of frames in a row in which the base reports its dock until it is believed."""


class Undocking:
    """Backs away from the dock, which stands in front of the robot, until it can turn.

    The wheels measure the way: the pose may stand still or jump while the camera looks at the dock.
    """

    def __init__(self, config: RecoveryConfig) -> None:
        self._config = config
        self._docked_frames = 0
        self._T_odom_dock: SE3 | None = None

    def decide(self, state: BaseState) -> Decision | None:
        """What to do on the dock and close to it; None away from it."""
        self._docked_frames = self._docked_frames + 1 if state.docked else 0
        if self._T_odom_dock is None:
            if not state.docked:
                return None
            if self._docked_frames < SURE:
                return Decision(STOP, "standing still, perhaps on the dock")
            self._T_odom_dock = state.T_odom_base
        way = np.linalg.norm((state.T_odom_base - self._T_odom_dock)[:2, 3])
        if way >= self._config.undocking and not state.docked:
            self._T_odom_dock = None
            return None
        back = Twist(-self._config.back_off_speed, 0.0)
        return Decision(back, "leaving the dock", leaves_dock=True)
