"""What is worth a line in the log of a run, and how fast its steps follow each other."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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

    def rate_at(self, now: float) -> float:
        """The rate at `now` [s], lower while no step comes; 0 before the first one [1/s]."""
        since = now - self._stamps[0] if self._stamps else 0.0
        return len(self._stamps) / max(since, 1.0)


_EMBEDDED = 2
"""Frames whose elements may arrive in one step: one that was under way, and the step's own."""
_COMPARED = 16
"""So many elements are enough to tell two pictures apart."""
_RIGID = 1e-5
"""Elements of one frame keep their distances, whatever the graph does [m]."""


class MapChange:
    """Tells from the steps alone whether another map has begun: ids and numbers start anew then."""

    def __init__(self) -> None:
        """No step yet."""
        self._before: Step | None = None

    def begins_with(self, step: Step) -> bool:
        """Whether a step is the first of another map than the step before it; call once for each.

        A map only grows: it keeps its keyframes and its elements, and counts its frames.
        """
        before, self._before = self._before, step
        return before is not None and not _goes_on(before, step)


def _goes_on(before: Step, step: Step) -> bool:
    known = len(before.frames)
    return (
        step.frame_number >= before.frame_number
        and before.keyframe_poses.keys() <= step.keyframe_poses.keys()
        and np.array_equal(step.frames[:known], before.frames)
        and np.array_equal(step.boxes[:known], before.boxes)
        and len(np.unique(step.frames[known:])) <= _EMBEDDED
        and np.allclose(_spread(before), _spread(step)[: len(_spread(before))], atol=_RIGID)
    )


def _spread(step: Step) -> NDArray[np.float64]:
    """Distances [m] from the first element to the next ones of its frame."""
    first = step.points[:_COMPARED][step.frames[:_COMPARED] == step.frames[:1]]
    return np.asarray(np.linalg.norm(first - first[:1], axis=1))
