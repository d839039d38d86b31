"""The direction of the walls of a home, in which its map is drawn upright."""

from __future__ import annotations

import math
import threading

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Step
from vizbot.core.types import OccupancyGrid

_LEAST_CELLS = 150
"""Number of obstacle cells that is too small to distinguish walls from furniture [cells]."""
_MOST_CELLS = 6000
"""Of more obstacles every second, third, ... counts [cells]."""
_COARSE, _FINE = np.radians(2.0), np.radians(0.25)
"""Steps of the search [rad]."""
_CLEAR = 1.2
"""How much better than others the best direction is at least."""
_QUARTER = math.pi / 2
_GROWTH = 1.5
"""The direction is looked for again when there are so many times as many obstacles."""
_TOLERATED = math.radians(1.5)
"""A map that is turned by this much from its walls is left as it is [rad]."""


def wall_direction(grid: OccupancyGrid) -> float | None:
    """The direction along which, and across which, most obstacles stand.

    Obstacles along a wall crowd into few lines that are one cell wide: the sum of the squares of
    how many are in each line is the largest in the direction of the walls.

    Returns:
        Counterclockwise from x of `map`, from -pi/4 to pi/4 [rad]; None where too few obstacles are
        known, or no direction stands out.
    """
    rows, cols = np.nonzero(_faces(grid))
    if len(rows) < _LEAST_CELLS:
        return None
    every = -(-len(rows) // _MOST_CELLS)
    cells = np.stack([cols, rows], axis=1)[::every].astype(np.float64)
    coarse = np.arange(-_QUARTER / 2, _QUARTER / 2, _COARSE)
    crowding = np.array([_crowding(cells, angle) for angle in coarse])
    if crowding.max() < _CLEAR * np.median(crowding):
        return None
    fine = coarse[crowding.argmax()] + np.arange(-_COARSE + _FINE, _COARSE, _FINE)
    best = fine[np.argmax([_crowding(cells, angle) for angle in fine])]
    return _nearest(float(best), 0.0)


def _faces(grid: OccupancyGrid) -> NDArray[np.bool_]:
    """Obstacles (rows, cols) beside free floor: what is behind them tells nothing of walls."""
    free = (grid.occupancy < 0.5).astype(np.uint8)
    beside = cv2.dilate(free, np.ones((3, 3), np.uint8)) > 0
    return np.asarray((grid.occupancy > 0.5) & beside)


def _crowding(cells: NDArray[np.float64], angle: float) -> float:
    """Sum of the squares of how many cells (N, 2) are in each line along and across a direction.

    A cell between two lines counts for both, so that a direction along the cells is not better for
    that alone.
    """
    along = np.array([math.cos(angle), math.sin(angle)])
    total = 0.0
    for direction in (along, np.array([-along[1], along[0]])):
        offsets = cells @ direction
        offsets -= offsets.min()
        lines = offsets.astype(np.int64)
        share = offsets - lines
        counts = np.bincount(lines, 1.0 - share, lines.max() + 2)
        counts += np.bincount(lines + 1, share, lines.max() + 2)
        total += float(counts @ counts)
    return total


def _nearest(direction: float, to: float) -> float:
    """Of a direction and those across it, the one nearest to another [rad]."""
    return direction + _QUARTER * round((to - direction) / _QUARTER)


class MapTurn:
    """By how much the map of a run is turned, so that its walls stand upright.

    It changes seldom while the map grows, and never by little: a map that turns while somebody
    looks at it is worse than one that leans. It may be asked by several threads.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._map = -1
        self._grid: OccupancyGrid | None = None
        self._cells, self._turn, self._decided = 0, 0.0, False

    def turn_at(self, step: Step) -> float:
        """Direction of the picture's rows in `map`, counterclockwise from x [rad]."""
        with self._lock:
            if step.map_number > self._map:
                self._map, self._grid = step.map_number, None
                self._cells, self._turn, self._decided = 0, 0.0, False
            if step.map_number < self._map:
                return 0.0
            if step.grid is not self._grid:
                self._grid = step.grid
                self._look(step.grid)
            return self._turn

    def _look(self, grid: OccupancyGrid) -> None:
        cells = int(np.count_nonzero(grid.occupancy > 0.5))
        if cells < max(_LEAST_CELLS, _GROWTH * self._cells):
            return
        self._cells = cells
        direction = wall_direction(grid)
        if direction is None:
            return
        direction = _nearest(direction, self._turn)
        if not self._decided or abs(direction - self._turn) > _TOLERATED:
            self._turn, self._decided = direction, True
