"""The steps of a run: which are worth a picture, how fast they follow, where the base was."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.observer import Step

_MOVED, _TURNED = 0.02, 0.02
"""A robot at rest was moved if its pose differs by at least this [m, rad]."""
_WINDOW = 5.0
"""The rate is the mean of the last so many seconds [s]."""


class StepFilter:
    """Compares each step with the last one that was shown."""

    def __init__(self, period: float = math.inf) -> None:
        """While nothing changes, one step is shown in a period [s]."""
        self._period = period
        self._shown: Step | None = None

    def is_news(self, step: Step) -> bool:
        """Whether to show a step; it then counts as shown. Call once for each."""
        shown = self._shown
        news = (
            shown is None
            or step.command is not None
            or step.ended is not None
            or bool(step.goal)
            or step.frame.stamp - shown.frame.stamp >= self._period
            or _summary(step) != _summary(shown)
            or _has_moved(shown, step)
        )
        if news:
            self._shown = step
        return news


def _summary(step: Step) -> tuple[object, ...]:
    sizes = len(step.points), len(step.keyframe_poses), len(step.closures)
    return step.goal, step.activity, step.estimate.tracking, *sizes


def _has_moved(shown: Step, step: Step) -> bool:
    T_shown_base = invert(shown.T_map_base) @ step.T_map_base
    moved = float(np.linalg.norm(T_shown_base[:3, 3]))
    return moved >= _MOVED or rotation_angle(T_shown_base) >= _TURNED


class StepRate:
    """Steps per second over the last five seconds, or since the last step but one."""

    def __init__(self) -> None:
        self._stamps: deque[float] = deque()

    def add(self, stamp: float) -> None:
        """Count a step at a time that is later than all before [s]."""
        self._stamps.append(stamp)
        while stamp - self._stamps[0] > _WINDOW and len(self._stamps) > 2:
            self._stamps.popleft()

    def rate(self, now: float) -> float | None:
        """Steps per second until `now` [s]; None before the second step [1/s]."""
        if len(self._stamps) < 2 or now <= self._stamps[0]:
            return None
        return (len(self._stamps) - 1) / (now - self._stamps[0])


class Track:
    """Positions in order: all of them up to a capacity, then older ones ever fewer."""

    def __init__(self, capacity: int = 20_000, spacing: float = 0.0) -> None:
        """Begin without a position.

        At most `capacity` positions are kept, which is even, each farther than `spacing` from the
        last [m].
        """
        self._positions = np.zeros((capacity, 2))
        self._size = 0
        self._spacing = spacing

    def add(self, xy: NDArray[np.float64]) -> bool:
        """Go on to x, y (2,) in `map` [m]; whether it is far enough from the last to be kept."""
        if self._size and np.linalg.norm(xy - self._positions[self._size - 1]) < self._spacing:
            return False
        if self._size == len(self._positions):
            thinned = self._positions[::2].copy()
            self._size = len(thinned)
            self._positions[: self._size] = thinned
        self._positions[self._size] = xy
        self._size += 1
        return True

    @property
    def xy(self) -> NDArray[np.float64]:
        """(N, 2) x, y in `map` [m], oldest first; a view that the next `add` may change."""
        return self._positions[: self._size]
