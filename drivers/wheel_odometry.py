"""Dead reckoning from the Roomba's encoder counts (Open Interface manual, pages 30 to 31)."""

from __future__ import annotations

import numpy as np

from drivers.roomba_oi import METRES_PER_COUNT
from vizbot.core.diff_drive import rolled
from vizbot.core.types import SE3


def counts_between(old: int, new: int) -> int:
    """Signed step from one 16-bit count to the next, either way across the roll-over.

    Right whether the counts are read as signed or as unsigned, for steps up to 32767 (14.6 m).
    """
    return (new - old + 32768) % 65536 - 32768


class WheelOdometry:
    """Pose of the base in `odom`, which is where it stood at the first count."""

    def __init__(self, wheel_base: float, wheel_scale: float) -> None:
        """Start at the identity.

        Args:
            wheel_base: Distance between the wheels [m].
            wheel_scale: Metres truly rolled for each metre that the encoders count.
        """
        self._wheel_base = wheel_base
        self._metres_per_count = METRES_PER_COUNT * wheel_scale
        self._counts: tuple[int, int] | None = None
        self._T_odom_base: SE3 = np.eye(4)

    def update(self, left: int, right: int) -> SE3:
        """T_odom_base once the encoders stand at `left` and `right`."""
        old_left, old_right = self._counts or (left, right)
        self._counts = left, right
        T_old_new = rolled(
            counts_between(old_left, left) * self._metres_per_count,
            counts_between(old_right, right) * self._metres_per_count,
            self._wheel_base,
        )
        self._T_odom_base = self._T_odom_base @ T_old_new
        return self._T_odom_base
