"""Where the robot has turned around before it says that it has arrived."""

from __future__ import annotations

import numpy as np

from nav.look_around import LookAround
from vizbot.core.types import SE3, Twist
from vizbot.objectnav.looks import APART


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
