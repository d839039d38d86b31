"""Dead reckoning from the Roomba's encoder counts (Open Interface manual, pages 30 to 31)."""

from __future__ import annotations

import logging
import math

import numpy as np

from drivers.roomba.commands import METRES_PER_COUNT
from vizbot.core.diff_drive import rolled
from vizbot.core.types import SE3, BaseState

logger = logging.getLogger(__name__)

_STANDSTILL = 1.0
"""A warning is logged when the caster stands still this long while the wheels roll ahead [s]."""


def counts_between(old: int, new: int) -> int:
    """Signed step from one 16-bit count to the next, either way across the roll-over.

    Right whether the counts are read as signed or as unsigned, for steps up to 32767 (14.6 m).
    """
    return (new - old + 32768) % 65536 - 32768


def without_reversal(wanted: int, commanded: int, at_rest: bool) -> int:
    """Speed to command to a wheel so that it never reverses while it rolls [mm/s].

    An encoder cannot sense the direction of its wheel: the base counts in the commanded direction.
    A wheel that still rolls is therefore reversed only once it is at rest; until then the slowest
    speed of its old direction is commanded. A stop is never delayed.

    Args:
        wanted: Wanted speed [mm/s].
        commanded: Speed that was commanded last [mm/s].
        at_rest: Whether the wheel is at rest.
    """
    if wanted * commanded < 0 and not at_rest:
        return 1 if commanded > 0 else -1
    return wanted


class WheelOdometry:
    """Pose of the base in `odom`, which is where it stood at the first count.

    Attributes:
        counts: Left and right encoder at the last update; None where the next one is the first.
        T_odom_base: After the last update.
        at_rest: Whether the left and the right encoder have not counted since the update before.
    """

    def __init__(self, wheel_base: float, wheel_scale: float) -> None:
        """Start at the identity.

        `wheel_base` is between the wheels [m]; `wheel_scale` is metres truly rolled for each
        counted.
        """
        self._wheel_base = wheel_base
        self._metres_per_count = METRES_PER_COUNT * wheel_scale
        self.counts: tuple[int, int] | None = None
        self.at_rest = (True, True)
        self.T_odom_base: SE3 = np.eye(4)

    def update(self, left: int, right: int, farthest: float = math.inf) -> bool:
        """Add the motion up to new counts of the encoders; whether they are plausible.

        Counts by which a wheel would have rolled beyond `farthest` [m] are taken for a standstill.
        """
        old_left, old_right = self.counts or (left, right)
        self.counts = left, right
        rolled_left = counts_between(old_left, left) * self._metres_per_count
        rolled_right = counts_between(old_right, right) * self._metres_per_count
        if max(abs(rolled_left), abs(rolled_right)) > farthest:
            return False
        self.at_rest = left == old_left, right == old_right
        self.T_odom_base = self.T_odom_base @ rolled(rolled_left, rolled_right, self._wheel_base)
        return True

    def restore(self, T_odom_base: SE3, counts: tuple[int, int] | None) -> None:
        """Go on from a pose that was reached at these counts of the encoders."""
        self.T_odom_base, self.counts = T_odom_base, counts

    def skip(self) -> None:
        """Ignore what the encoders count until the next update."""
        self.counts = None


class CasterWheel:
    """Warns, once until it rolls again, when the caster stands still although the base drives."""

    def __init__(self, name: str) -> None:
        """`name` of the port, for the message."""
        self._name = name
        self._still_since: float | None = None
        self._warned = False

    def observe(self, state: BaseState, *, ahead: bool) -> None:
        """Update; `ahead`: the driven wheels are commanded to roll straight ahead, and do."""
        if state.rolls:
            self._warned = False
        if not ahead or state.blocked or state.rolls is not False:
            self._still_since = None
        elif self._still_since is None:
            self._still_since = state.stamp
        elif state.stamp - self._still_since > _STANDSTILL and not self._warned:
            self._warned = True
            logger.warning(
                "%s: the wheels roll ahead and the front wheel does not: they slip, or it is stuck "
                "or missing; look under the robot, clean the front wheel",
                self._name,
            )
