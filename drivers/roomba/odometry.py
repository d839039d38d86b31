"""Dead reckoning from the Roomba's encoder counts (Open Interface manual, pages 30 to 31)."""

from __future__ import annotations

import math

import numpy as np

from drivers.roomba.commands import METRES_PER_COUNT
from vizbot.core.diff_drive import rolled
from vizbot.core.types import SE3


def counts_between(old: int, new: int) -> int:
    """Signed step from one 16-bit count to the next, either way across the roll-over.

    Right whether the counts are read as signed or as unsigned, for steps up to 32767 (14.6 m).
    """
    return (new - old + 32768) % 65536 - 32768


def without_reversal(wanted: int, told: int, at_rest: bool) -> int:
    """Speed to tell a wheel that is wanted to turn at `wanted` and was `told` another one [mm/s].

    An encoder cannot feel which way its wheel turns: the base counts the way that the wheel is told
    to turn. One that still rolls is therefore told to turn the other way only once it is at rest,
    and the slowest speed of its old way until then. A stop is never held back.
    """
    if wanted * told < 0 and not at_rest:
        return 1 if told > 0 else -1
    return wanted


class WheelOdometry:
    """Pose of the base in `odom`, which is where it stood at the first count.

    Attributes:
        T_odom_base: After the last update.
        at_rest: Whether the left and the right encoder have not counted since the update before.
    """

    def __init__(self, wheel_base: float, wheel_scale: float) -> None:
        """Start at the identity.

        Args:
            wheel_base: Distance between the wheels [m].
            wheel_scale: Metres truly rolled for each metre that the encoders count.
        """
        self._wheel_base = wheel_base
        self._metres_per_count = METRES_PER_COUNT * wheel_scale
        self._counts: tuple[int, int] | None = None
        self.at_rest = (True, True)
        self.T_odom_base: SE3 = np.eye(4)

    def update(self, left: int, right: int, farthest: float = math.inf) -> bool:
        """Go on to where the encoders stand at `left` and `right`.

        Args:
            left: Count.
            right: Count.
            farthest: No wheel can have rolled farther since the update before [m].

        Returns:
            Whether they can be believed; counts that jumped are taken for a standstill.
        """
        old_left, old_right = self._counts or (left, right)
        self._counts = left, right
        rolled_left = counts_between(old_left, left) * self._metres_per_count
        rolled_right = counts_between(old_right, right) * self._metres_per_count
        if max(abs(rolled_left), abs(rolled_right)) > farthest:
            return False
        self.at_rest = left == old_left, right == old_right
        self.T_odom_base = self.T_odom_base @ rolled(rolled_left, rolled_right, self._wheel_base)
        return True

    def skip(self) -> None:
        """Nobody knows how the encoders have counted until the next update."""
        self._counts = None
