"""Where the base was in a run, for a map to be drawn with it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_MOST = 20_000


class Track:
    """Places in order: all of them up to 20 000, then older ones ever fewer."""

    def __init__(self, spacing: float = 0.0) -> None:
        """Create it empty.

        Args:
            spacing: A place is left out unless it is farther from the last one [m].
        """
        self._spacing = spacing
        self._places = np.zeros((_MOST, 2))
        self._size = 0

    def add(self, xy: NDArray[np.float64]) -> None:
        """Go on to x, y (2,) in `map` [m]."""
        last = self._places[self._size - 1] if self._size else None
        if self._spacing and last is not None and np.linalg.norm(xy - last) <= self._spacing:
            return
        if self._size == _MOST:
            kept = self._places[::2].copy()
            self._size = len(kept)
            self._places[: self._size] = kept
        self._places[self._size] = xy
        self._size += 1

    @property
    def xy(self) -> NDArray[np.float64]:
        """(N, 2) x, y in `map` [m], oldest first; it is good until the next one is added."""
        return self._places[: self._size]
