"""What is worth a line in the log of a run, and how fast its steps follow each other."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from vizbot.core.observer import Step
from vizbot.core.types import Tracking

_RATE_OVER = 5.0
"""The rate of steps is that of the last so many seconds [s]."""


@dataclass(frozen=True, slots=True)
class Event:
    """One line.

    Attributes:
        text: In plain words.
        warns: Whether something is not as it should be.
    """

    text: str
    warns: bool = False


class Events:
    """Notices what changes from step to step: goal, activity, tracking."""

    def __init__(self) -> None:
        """Nothing has happened yet."""
        self._goal, self._activity = "", ""
        self._tracking: Tracking | None = None

    def of(self, step: Step) -> list[Event]:
        """What is new in a step."""
        events = []
        if step.goal and step.goal != self._goal:
            events.append(Event(f"goal: {step.goal}"))
        tracking = step.estimate.tracking
        if tracking is not self._tracking:
            events.append(Event(f"tracking: {tracking}", tracking is Tracking.LOST))
        if step.activity != self._activity:
            events.append(Event(step.activity))
        self._goal, self._activity, self._tracking = step.goal, step.activity, tracking
        return events


class StepRate:
    """Steps per second of the frames' time, over the last seconds."""

    def __init__(self) -> None:
        """No step yet."""
        self._stamps: deque[float] = deque()

    def after(self, stamp: float) -> float | None:
        """With a step at `stamp` [s]; None with the first one [1/s]."""
        self._stamps.append(stamp)
        while stamp - self._stamps[0] > _RATE_OVER and len(self._stamps) > 2:
            self._stamps.popleft()
        past = stamp - self._stamps[0]
        return (len(self._stamps) - 1) / past if past > 0.0 else None
