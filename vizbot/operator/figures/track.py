"""Where the base was, for a map to be drawn with it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class Track:
    """Positions in order: all of them up to a capacity, then older ones ever fewer."""

    def __init__(self, capacity: int = 20_000, spacing: float = 0.0) -> None:
        """Begin without a position.

        Args:
            capacity: How many positions are kept at most; even.
            spacing: A position that is nearer to the last one is left out [m].
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
