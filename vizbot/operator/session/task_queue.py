"""What the robot is asked to do, in order, and what became of it."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from vizbot.core.errors import ConfigError
from vizbot.core.observer import GoalReport, Outcome
from vizbot.objectnav.tasks import Task, Waypoint

_KEPT = 100
"""So many tasks that are over are remembered."""
MOST_WAITING = 100
"""So many are taken in."""


TaskRequest: TypeAlias = str | Waypoint | Task
"""A goal in the user's words, a place, or what needs no words."""


@dataclass(frozen=True, slots=True)
class QueuedTask:
    """Something to be done.

    Attributes:
        number: From 1, in the order told.
        request: What.
        outcome: How it ended; None before.
        reason: Why, in one line; of one that is to end early, before it has.
        position: x, y, z in `map` of where it ended or was found [m]; None without such a place.
        called_off: It is to end although it has not come to its end.
    """

    number: int
    request: TaskRequest
    outcome: Outcome | None = None
    reason: str = ""
    position: tuple[float, float, float] | None = None
    called_off: bool = False

    @property
    def text(self) -> str:
        """What is to be done, as a person says it."""
        match self.request:
            case Waypoint(x, y):
                return f"go to {x:.1f} m, {y:.1f} m"
            case Task():
                return self.request.value
        return self.request


class TaskQueue:
    """Tasks one after another; safe to use from several threads."""

    def __init__(self) -> None:
        """Nothing is to be done."""
        self._lock = threading.Lock()
        self._told = 0
        self._waiting: list[QueuedTask] = []
        self._running: QueuedTask | None = None
        self._over: list[QueuedTask] = []

    def add(self, requests: Sequence[TaskRequest], *, at_once: bool = False) -> list[QueuedTask]:
        """Put tasks at the end, or before all others, where the one that is running gives way.

        Args:
            requests: In this order.
            at_once: What is running ends, what is waiting stays.

        Raises:
            ConfigError: too many are waiting.
        """
        with self._lock:
            if len(self._waiting) + len(requests) > MOST_WAITING:
                raise ConfigError(f"{MOST_WAITING} goals are waiting already; stop, or ask later")
            added = [
                QueuedTask(self._told + n, request) for n, request in enumerate(requests, start=1)
            ]
            self._told += len(added)
            if at_once:
                self._waiting[:0] = added
                self._call_off("another goal took over")
            else:
                self._waiting += added
            return added

    def call_all_off(self, reason: str) -> None:
        """End what is running and what is waiting."""
        with self._lock:
            self._call_off(reason)
            for task in self._waiting:
                self._keep(replace(task, outcome=Outcome.GAVE_UP, reason=reason))
            self._waiting = []

    def current(self) -> QueuedTask | None:
        """What is to be done now; it is asked again and again until `finish`."""
        with self._lock:
            if self._running is None and self._waiting:
                self._running = self._waiting.pop(0)
            return self._running

    def finish(
        self,
        outcome: Outcome,
        reason: str,
        position: tuple[float, float, float] | None = None,
    ) -> None:
        """What was running is over."""
        with self._lock:
            if self._running is not None:
                over = replace(self._running, outcome=outcome, reason=reason, position=position)
                self._keep(over)
                self._running = None

    def report(self, report: GoalReport) -> None:
        """What was running is over, as the robot says; what was not is nobody's task."""
        with self._lock:
            if self._running is None or self._running.request != report.text:
                return
        position = None
        if report.candidates and report.outcome in (Outcome.ARRIVED, Outcome.LOCATED):
            x, y, z = (round(float(value), 3) for value in report.candidates[0].position)
            position = x, y, z
        self.finish(report.outcome, report.reason, position)

    def forget_places(self) -> None:
        """Where things were found is on a map that is left."""
        with self._lock:
            self._over = [replace(task, position=None) for task in self._over]

    def tasks(self) -> list[QueuedTask]:
        """All of them, those that are over first, then the running one, then the waiting ones."""
        with self._lock:
            running = [] if self._running is None else [self._running]
            return [*self._over, *running, *self._waiting]

    def _call_off(self, reason: str) -> None:
        if self._running is not None:
            self._running = replace(self._running, called_off=True, reason=reason)

    def _keep(self, task: QueuedTask) -> None:
        self._over = [*self._over, task][-_KEPT:]
