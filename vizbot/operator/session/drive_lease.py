"""Driving by hand over a link that may lag, reorder or break: who drives, and what still counts.

The two ends share no clock. The robot's end sends its own time to whoever drives, and every motion
command brings back the newest time that had arrived when it was given: what lies between that and
now is the age of the command, both ways of the link included.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable

from vizbot.core.types import STOP, Twist

OLDEST = 0.3
"""A command that is older has no effect, and one that gets older ends [s]."""


class DriveLease:
    """One person drives at a time; safe to use from several threads."""

    def __init__(self, now: Callable[[], float]) -> None:
        """Nobody drives.

        Args:
            now: Time [s] of the wall clock: it is the link that ages a command.
        """
        self._now = now
        self._lock = threading.Lock()
        self._holder: str | None = None
        self._link = 0
        self._sequence = -1
        self._heard = -math.inf
        self._twist = STOP

    @property
    def holder(self) -> str | None:
        """Who drives; None while the robot may."""
        return self._holder

    def time(self) -> float:
        """Ours, for whoever drives to bring back [s]."""
        return self._now()

    def take(self, who: str, *, over: bool = False) -> int | None:
        """Begin to drive, wheels at rest.

        Args:
            who: A name that others are shown.
            over: Even if somebody else is driving, who then is not any more.

        Returns:
            The link's number, to be given with every command; None if somebody else is driving.
        """
        with self._lock:
            if self._holder is not None and not over:
                return None
            self._holder = who
            self._link += 1
            self._sequence, self._heard, self._twist = -1, -math.inf, STOP
            return self._link

    def release(self, link: int) -> None:
        """End to drive; nothing happens where `link` does not drive any more."""
        with self._lock:
            if link == self._link:
                self._holder, self._twist = None, STOP

    def revoke(self) -> None:
        """Nobody drives any more."""
        with self._lock:
            self._link += 1
            self._holder, self._twist = None, STOP

    def holds(self, link: int) -> bool:
        """Whether `link` drives."""
        with self._lock:
            return self._holder is not None and link == self._link

    def accept(self, link: int, sequence: int, heard: float, twist: Twist) -> bool:
        """Take in a motion command.

        Args:
            link: As `take` gave it.
            sequence: Grows from command to command; one that does not grow came too late.
            heard: The newest time of ours that had arrived when it was given [s].
            twist: What to drive.

        Returns:
            Whether it counts.
        """
        with self._lock:
            fresh = 0.0 <= self._now() - heard <= OLDEST
            if self._holder is None or link != self._link or sequence <= self._sequence:
                return False
            if not fresh or not (math.isfinite(twist.linear) and math.isfinite(twist.angular)):
                return False
            self._sequence, self._heard, self._twist = sequence, heard, twist
            return True

    def twist(self) -> Twist | None:
        """What to drive now, rest if the last command is too old; None while nobody drives."""
        with self._lock:
            if self._holder is None:
                return None
            return self._twist if self._now() - self._heard <= OLDEST else STOP
