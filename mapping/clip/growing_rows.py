"""An array that grows by rows, where a row more costs the same however long the array is."""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", bound=np.generic)


class GrowingRows(Generic[Number]):
    """Rows of numbers, with room for more."""

    def __init__(self, first: NDArray[Number]) -> None:
        """Begin with these rows (N, ...), which are never written to."""
        self._rows, self._size = first, len(first)

    def __len__(self) -> int:
        return self._size

    @property
    def rows(self) -> NDArray[Number]:
        """All rows (N, ...), as a view that later additions do not change."""
        return self._rows[: self._size]

    def add(self, fresh: NDArray[Number]) -> None:
        """Add rows (M, ...)."""
        start, end = self._size, self._size + len(fresh)
        if end > len(self._rows):
            room = max(end, 2 * len(self._rows), 256)
            grown = np.empty((room, *self._rows.shape[1:]), self._rows.dtype)
            grown[:start] = self._rows[:start]
            self._rows = grown
        self._rows[start:end] = fresh
        self._size = end
