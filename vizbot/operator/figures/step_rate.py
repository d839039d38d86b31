"""How fast the steps of a run follow each other."""

from __future__ import annotations

from collections import deque

_WINDOW = 5.0
"""The rate is the mean of the last so many seconds [s]."""


class StepRate:
    """Steps per second over the last five seconds, or since the last step but one."""

    def __init__(self) -> None:
        self._stamps: deque[float] = deque()

    def add(self, stamp: float) -> None:
        """Count a step.

        Args:
            stamp: When it was; later than all before [s].
        """
        self._stamps.append(stamp)
        while stamp - self._stamps[0] > _WINDOW and len(self._stamps) > 2:
            self._stamps.popleft()

    def rate(self, now: float) -> float | None:
        """Steps per second until `now` [s]; None before the second step [1/s]."""
        if len(self._stamps) < 2 or now <= self._stamps[0]:
            return None
        return (len(self._stamps) - 1) / (now - self._stamps[0])
