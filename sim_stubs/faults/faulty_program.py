"""Faults of the program: it is killed, or its disk is full."""

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
        """Report to the observer.

        Raises:
            OSError: the disk is full.
        """
        self._require_space()
        self._observer.on_step(step)

    def on_goal(self, report: GoalReport) -> None:
        """Report to the observer.

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
    """Let every write to a file fail in the `with` block."""
    limit = resource.RLIMIT_FSIZE
    soft, hard = resource.getrlimit(limit)
    resource.setrlimit(limit, (0, hard))
    try:
        yield
    finally:
        resource.setrlimit(limit, (soft, hard))


class Killer:
    """An observer that kills its own program when that fault is due."""

    def __init__(self, schedule: FaultSchedule) -> None:
        """Kill the program at the time of the schedule."""
        self._schedule = schedule

    def on_step(self, step: Step) -> None:
        """Kill the program if that is due."""
        if self._schedule.began("process-killed") is not None:
            os.kill(os.getpid(), signal.SIGKILL)

    def on_goal(self, report: GoalReport) -> None:
        """Do nothing."""
