"""The tasks that a robot was asked for, in order, and how they ended."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from vizbot.core.errors import ConfigError
from vizbot.core.observer import Effort, GoalReport, Outcome, headline
from vizbot.objectnav.tasks import ShortMove, Task, Waypoint

_MOST_ENDED = 100
"""Most tasks that the queue remembers after their end."""
MOST_WAITING = 100
"""Most tasks that may wait."""


TaskRequest: TypeAlias = str | Waypoint | Task | ShortMove
"""A goal in the user's words, a place on the map, a task that needs no words, a turn or a way."""


@dataclass(frozen=True, slots=True)
class QueuedTask:
    """A task of the queue.

    Attributes:
        number: From 1, in the order in which tasks were asked for.
        request: What is to be done.
        outcome: How it ended; None before.
        reason: Why it ended so, or why it was called off, in one line.
        position: x, y, z in `map` of where it ended or was found [m]; None without such a place.
        called_off: Whether it has to end early.
        effort: What the search for a goal took; None before its end and for other tasks.
    """

    number: int
    request: TaskRequest
    outcome: Outcome | None = None
    reason: str = ""
    position: tuple[float, float, float] | None = None
    called_off: bool = False
    effort: Effort | None = None

    @property
    def text(self) -> str:
        """What is to be done, in plain words."""
        match self.request:
            case Waypoint(x, y):
                return f"go to {x:.1f} m, {y:.1f} m"
            case Task():
                return self.request.value
            case ShortMove():
                return self.request.text
        return self.request

    @property
    def headline(self) -> str | None:
        """How the search for a goal ended, in words; None before its end and for other tasks."""
        if self.outcome is None or not isinstance(self.request, str):
            return None
        return headline(self.request, self.outcome, self.effort)


class TaskQueue:
    """Tasks one after another; safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._added = 0
        self._waiting: list[QueuedTask] = []
        self._running: QueuedTask | None = None
        self._ended: list[QueuedTask] = []

    def add(self, requests: Sequence[TaskRequest], *, at_once: bool = False) -> list[QueuedTask]:
        """Append tasks, or put them before all others.

        Tasks `at_once` come first and end the running task; those that wait stay.

        Raises:
            ConfigError: too many are waiting.
        """
        with self._lock:
            if len(self._waiting) + len(requests) > MOST_WAITING:
                raise ConfigError(f"{MOST_WAITING} goals are waiting already; stop, or ask later")
            added = [
                QueuedTask(self._added + n, request) for n, request in enumerate(requests, start=1)
            ]
            self._added += len(added)
            if at_once:
                self._waiting[:0] = added
                self._call_off("another goal took over")
            else:
                self._waiting += added
            return added

    def call_all_off(self, reason: str) -> None:
        """Call off the running task and end those that wait."""
        with self._lock:
            self._call_off(reason)
            for task in self._waiting:
                self._remember(replace(task, outcome=Outcome.GAVE_UP, reason=reason))
            self._waiting = []

    def call_off(self, chosen: Callable[[QueuedTask], bool], reason: str) -> list[QueuedTask]:
        """Call off some tasks and return them: waiting ones are over, a running one is to end.

        The tasks that are `chosen` of those that run or wait are called off, for a `reason` in one
        line.
        """
        with self._lock:
            called_off = []
            if self._running is not None and chosen(self._running):
                self._call_off(reason)
                called_off.append(self._running)
            for task in [task for task in self._waiting if chosen(task)]:
                self._waiting.remove(task)
                called_off.append(replace(task, outcome=Outcome.GAVE_UP, reason=reason))
                self._remember(called_off[-1])
            return called_off

    def move_to_front(self, number: int) -> bool:
        """Let a task that waits be the next one; return whether it waits."""
        with self._lock:
            moved = [task for task in self._waiting if task.number == number]
            self._waiting = moved + [task for task in self._waiting if task.number != number]
            return bool(moved)

    def forget_ended(self) -> None:
        """Drop the tasks that are over."""
        with self._lock:
            self._ended = []

    def current(self) -> QueuedTask | None:
        """The running task, or the next one, which runs from then on; None with nothing to do."""
        with self._lock:
            if self._running is None and self._waiting:
                self._running = self._waiting.pop(0)
            return self._running

    def finish(
        self,
        outcome: Outcome,
        reason: str,
        position: tuple[float, float, float] | None = None,
        effort: Effort | None = None,
    ) -> QueuedTask | None:
        """End the running task and return it; None without one."""
        with self._lock:
            if self._running is None:
                return None
            ended = replace(
                self._running, outcome=outcome, reason=reason, position=position, effort=effort
            )
            self._remember(ended)
            self._running = None
            return ended

    def report(self, report: GoalReport) -> QueuedTask | None:
        """End the running task by the robot's report on its goal, and return it.

        Other reports are ignored.
        """
        with self._lock:
            if self._running is None or self._running.request != report.text:
                return None
        position = None
        if report.candidates and report.outcome in (Outcome.ARRIVED, Outcome.LOCATED):
            x, y, z = (round(float(value), 3) for value in report.candidates[0].position)
            position = x, y, z
        return self.finish(report.outcome, report.reason, position, report.effort)

    def forget_places(self) -> None:
        """Drop the places of tasks that are over: they were on a map that the robot has left."""
        with self._lock:
            self._ended = [
                replace(task, position=None)
                for task in self._ended
                if not isinstance(task.request, Waypoint)
            ]

    def tasks(self) -> list[QueuedTask]:
        """All tasks: those that have ended, then the running one, then those that wait."""
        with self._lock:
            running = [] if self._running is None else [self._running]
            return [*self._ended, *running, *self._waiting]

    def _call_off(self, reason: str) -> None:
        if self._running is not None:
            self._running = replace(self._running, called_off=True, reason=reason)

    def _remember(self, task: QueuedTask) -> None:
        self._ended = [*self._ended, task][-_MOST_ENDED:]
