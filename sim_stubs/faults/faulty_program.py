"""What befalls the program itself: it is killed, or its disk is full."""

from __future__ import annotations

import errno
import os
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager

from sim_stubs.faults.catalogue import FaultSchedule
from vizbot.core.observer import GoalReport, Observer, Step


class FaultyObserver:
    """An `Observer` that writes to a disk that may be full."""

    def __init__(self, observer: Observer, schedule: FaultSchedule) -> None:
        """Wrap an observer."""
        self._observer = observer
        self._schedule = schedule

    def on_step(self, step: Step) -> None:
        """As the observer.

        Raises:
            OSError: the disk is full.
        """
        self._require_space()
        self._observer.on_step(step)

    def on_goal(self, report: GoalReport) -> None:
        """As the observer.

        Raises:
            OSError: the disk is full.
        """
        self._require_space()
        self._observer.on_goal(report)

    def _require_space(self) -> None:
        if self._schedule.active("disk-full"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextmanager
def full_disk() -> Iterator[None]:
    """Have every write to a file fail: no file of this program may grow meanwhile."""
    limit = resource.RLIMIT_FSIZE
    soft, hard = resource.getrlimit(limit)
    resource.setrlimit(limit, (0, hard))
    try:
        yield
    finally:
        resource.setrlimit(limit, (soft, hard))


class Killer:
    """An observer that kills the program in which it is, when that is due."""

    def __init__(self, schedule: FaultSchedule) -> None:
        """The schedule says when."""
        self._schedule = schedule

    def on_step(self, step: Step) -> None:
        """Kill it, or not yet."""
        if self._schedule.began("process-killed") is not None:
            os.kill(os.getpid(), signal.SIGKILL)

    def on_goal(self, report: GoalReport) -> None:
        """Not now."""
