"""A binary heap of cells by their keys, in arrays, for the searches compiled by numba."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def sift_up(
    keys: NDArray[np.float64], cells: NDArray[np.int32], at: int, key: float, cell: int
) -> None:
    """Put an entry at the free end `at` of the binary heap and let it rise to its place."""
    while at > 0:
        above = (at - 1) // 2
        if keys[above] <= key:
            break
        keys[at], cells[at] = keys[above], cells[above]
        at = above
    keys[at], cells[at] = key, cell


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def sift_down(
    keys: NDArray[np.float64], cells: NDArray[np.int32], size: int, key: float, cell: int
) -> None:
    """Put an entry at the free top of a binary heap of `size` and let it sink to its place."""
    # The hole sinks to the end of the heap, and rises to where the entry fits: fewer comparisons,
    # and the same place.
    at, below = 0, 1
    while below < size:
        if below + 1 < size:
            below += keys[below + 1] < keys[below]
        keys[at], cells[at] = keys[below], cells[below]
        at, below = below, 2 * below + 1
    while at > 0:
        above = (at - 1) // 2
        if keys[above] < key:
            break
        keys[at], cells[at] = keys[above], cells[above]
        at = above
    keys[at], cells[at] = key, cell
