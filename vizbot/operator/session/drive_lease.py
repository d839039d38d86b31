"""Driving by hand over a link that may lag, reorder or break: who drives, and what still counts.

The two ends share no clock. The robot sends its own time to the driver, and every motion command
brings back the newest time that had arrived when it was given. The time since then is the age of
the command, both ways of the link included.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable

from vizbot.core.types import STOP, Twist

OLDEST = 0.3
"""A command has no effect beyond this age [s]."""


class DriveLease:
    """Lets one person drive at a time; safe to use from several threads."""

    def __init__(self, now: Callable[[], float]) -> None:
        """By `now`, the wall clock [s]: it is the link that ages a command."""
        self._now = now
        self._lock = threading.Lock()
        self._holder: str | None = None
        self._link = 0
        self._sequence = -1
        self._heard = -math.inf
        self._twist = STOP

    @property
    def holder(self) -> str | None:
        """Who drives by hand; None while nobody does."""
        return self._holder

    def time(self) -> float:
        """The robot's time, which the driver's commands bring back [s]."""
        return self._now()

    def take(self, who: str, *, over: bool = False) -> int | None:
        """Give the lease to somebody, wheels at rest.

        Others are shown `who` drives; with `over` the lease is taken from whoever holds it.

        Returns:
            The number of the link, which every command needs; None if somebody else drives.
        """
        with self._lock:
            if self._holder is not None and not over:
                return None
            self._holder = who
            self._link += 1
            self._sequence, self._heard, self._twist = -1, -math.inf, STOP
            return self._link

    def release(self, link: int) -> None:
        """End the lease of `link`, if it still holds it."""
        with self._lock:
            if link == self._link:
                self._holder, self._twist = None, STOP

    def revoke(self) -> None:
        """End the lease, whoever holds it."""
        with self._lock:
            self._link += 1
            self._holder, self._twist = None, STOP

    def holds(self, link: int) -> bool:
        """Whether `link` holds the lease."""
        with self._lock:
            return self._holder is not None and link == self._link

    def accept(self, link: int, sequence: int, heard: float, twist: Twist) -> bool:
        """Take a motion command, unless it comes too late; whether it counts.

        It is too late where `sequence` is not above the last one. `heard` is the newest of the
        robot's times that had arrived when it was given [s]; `link` is what `take` returned.
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
        """What to drive now: rest if the last command is too old, None while nobody drives."""
        with self._lock:
            if self._holder is None:
                return None
            return self._twist if self._now() - self._heard <= OLDEST else STOP
