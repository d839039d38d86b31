"""Which of very many elements are near a few places, in one pass over them."""

from __future__ import annotations

import numpy as np
from numba import b1, f8
from numpy.typing import NDArray

from vizbot.core.program.kernels import njit


def is_within(
    points: NDArray[np.float64], place_xy: NDArray[np.float64], radius: float
) -> NDArray[np.bool_]:
    """Which points (N, 3) are within `radius` [m] of a place (2,) on the plan."""
    return np.asarray(_is_within(points, float(place_xy[0]), float(place_xy[1]), radius))


def around_any(
    points: NDArray[np.float64], places_xy: NDArray[np.float64], radius: float
) -> NDArray[np.int64]:
    """Indices of points (N, 3) around places (M, 2) on the plan.

    All within `radius` [m] of a place are among them, and some others up to three times as far.
    """
    if len(places_xy) == 0:
        return np.zeros(0, np.int64)
    origin = places_xy.min(axis=0) - 1.5 * radius
    cells = np.floor((places_xy - origin) / radius).astype(np.int64)
    marked = np.zeros(cells.max(axis=0) + 2, bool)
    for row in (-1, 0, 1):
        for column in (-1, 0, 1):
            marked[cells[:, 0] + row, cells[:, 1] + column] = True
    return np.flatnonzero(_is_marked(points, origin, radius, marked))


@njit(b1[::1](f8[:, ::1], f8, f8, f8), cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _is_within(points: NDArray[np.float64], x: float, y: float, radius: float) -> NDArray[np.bool_]:
    result = np.empty(len(points), np.bool_)
    for i in range(len(points)):
        dx, dy = points[i, 0] - x, points[i, 1] - y
        result[i] = np.sqrt(dx * dx + dy * dy) <= radius
    return result


@njit(  # type: ignore[untyped-decorator]
    b1[::1](f8[:, ::1], f8[::1], f8, b1[:, ::1]), cache=True, nogil=True
)
def _is_marked(
    points: NDArray[np.float64],
    origin: NDArray[np.float64],
    size: float,
    marked: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Which points (N, 3) lie in a marked cell of edge `size`."""
    result = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        row = np.floor((points[i, 0] - origin[0]) / size)
        column = np.floor((points[i, 1] - origin[1]) / size)
        if 0 <= row < marked.shape[0] and 0 <= column < marked.shape[1]:
            result[i] = marked[int(row), int(column)]
    return result
