"""A binary heap of cells by their keys, in arrays, for the searches compiled by numba.

Indices are unsigned, which spares the compiled code a test for those that count from the end.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.program.kernels import kernel


@kernel()
def sift_up(
    keys: NDArray[np.float64], cells: NDArray[np.int32], at: int, key: float, cell: np.int32
) -> None:
    """Put an entry at the free end `at` of the binary heap and let it rise to its place."""
    here = np.uintp(at)
    while here > np.uintp(0):
        above = (here - np.uintp(1)) >> np.uintp(1)
        if keys[above] <= key:
            break
        keys[here], cells[here] = keys[above], cells[above]
        here = above
    keys[here], cells[here] = key, cell


@kernel()
def sift_down(
    keys: NDArray[np.float64], cells: NDArray[np.int32], size: int, key: float, cell: np.int32
) -> None:
    """Put an entry at the free top of a binary heap of `size` and let it sink to its place."""
    # The hole sinks to the end of the heap, and rises to where the entry fits: fewer comparisons,
    # and the same place.
    one, end = np.uintp(1), np.uintp(size)
    at, below = np.uintp(0), one
    while below < end:
        if below + one < end:
            below += np.uintp(keys[below + one] < keys[below])
        keys[at], cells[at] = keys[below], cells[below]
        at, below = below, (below << one) + one
    while at > np.uintp(0):
        above = (at - one) >> one
        if keys[above] < key:
            break
        keys[at], cells[at] = keys[above], cells[above]
        at = above
    keys[at], cells[at] = key, cell
