"""Costmap: the cost of a metre of path in each cell, and where the robot cannot be at all."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from nav.config import CostmapConfig
from vizbot.core.distance import distance_to_zero
from vizbot.core.program.kernels import kernel
from vizbot.core.types import OccupancyGrid


@dataclass(frozen=True, slots=True, eq=False)
class Costmap:
    """Costs of a grid, cell for cell.

    Attributes:
        grid: The obstacle map they were made from; converts between metres and cells.
        cost: (rows, cols) float32, cost of a metre, 1 or more; inf where the robot cannot be.
        clearance: (rows, cols) float32, from the cell's centre to the edge of the nearest occupied
            cell [m]; 0 in one. Where that has no effect on the cost it may be larger, up to inf.
        to_zone: (rows, cols) float32, as `clearance`, to the nearest keep-out zone; None without.
        least: The least cost; inf where all cells are closed.
    """

    grid: OccupancyGrid
    cost: NDArray[np.float32]
    clearance: NDArray[np.float32]
    to_zone: NDArray[np.float32] | None
    config: CostmapConfig
    least: float

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """(rows, cols) cells that hold an obstacle."""
        return np.asarray(self.clearance == 0)

    @property
    def closed(self) -> NDArray[np.bool_] | None:
        """(rows, cols) cells where the robot would be in a keep-out zone; None without one."""
        return None if self.to_zone is None else self.to_zone <= self.config.safe_radius

    def room(self, cell: NDArray[np.int64]) -> float:
        """From a cell (2,) in the map to the nearest obstacle or keep-out zone [m]."""
        row, col = cell
        clearance = float(self.clearance[row, col])
        return clearance if self.to_zone is None else min(clearance, float(self.to_zone[row, col]))


class LiveCostmap:
    """The costmap of a map as it changes, with a frame of unknown cells around the map.

    The frame is wide enough for the robot to drive around everything that is known. Each update
    recomputes only the cells that a change since the last one affects.
    """

    def __init__(self, config: CostmapConfig) -> None:
        self._config = config
        self._latest: Costmap | None = None

    def update(self, grid: OccupancyGrid) -> Costmap:
        """The costmap of `grid`, with the same costs as a new one."""
        width = int(np.ceil(2 * self._config.safe_radius / grid.resolution)) + 1
        framed = OccupancyGrid(
            np.pad(grid.occupancy, width, constant_values=np.float32(0.5)),
            grid.resolution,
            grid.origin - width * grid.resolution,
            grid.zones,
        )
        latest = self._latest
        if latest is None or not _same_cells(latest.grid, framed):
            self._latest = build_costmap(framed, self._config)
        else:
            self._latest = _updated(latest, framed)
        return self._latest


def build_costmap(grid: OccupancyGrid, config: CostmapConfig) -> Costmap:
    """Inflate the obstacles of a grid by the robot's radius; unknown cells cost more but pass."""
    free = grid.occupancy <= config.free_threshold
    cost = np.where(free, np.float32(1.0), np.float32(config.unknown_cost))
    clearance = np.full(cost.shape, np.inf, np.float32)
    occupied = grid.occupancy >= config.occupied_threshold
    if (box := _box(occupied)) is not None:
        reach = config.inflation_cells(grid.resolution)
        _inflate(cost, clearance, grid, config, _grown(box, reach, cost.shape))
    to_zone = None
    if grid.zones:
        to_zone = _distance_to(forbidden(grid), grid.resolution)
        cost[to_zone <= config.safe_radius] = np.inf
    return Costmap(grid, cost, clearance, to_zone, config, float(cost.min()))


def _updated(before: Costmap, grid: OccupancyGrid) -> Costmap:
    """The costmap of a grid with the same cells and zones as that of the one before."""
    config, old, new = before.config, before.grid.occupancy, grid.occupancy
    moved = (old >= config.occupied_threshold) != (new >= config.occupied_threshold)
    seen = (old <= config.free_threshold) != (new <= config.free_threshold)
    window = _box(moved)
    if window is not None:
        window = _grown(window, config.inflation_cells(grid.resolution), new.shape)
    window = _joined(window, _box(seen))
    if window is None:
        return replace(before, grid=grid)
    cost, clearance = before.cost.copy(), before.clearance.copy()
    _inflate(cost, clearance, grid, config, window)
    if before.to_zone is not None:
        cost[before.to_zone <= config.safe_radius] = np.inf
    return replace(before, grid=grid, cost=cost, clearance=clearance, least=float(cost.min()))


Window = tuple[slice, slice]
"""Rows and columns of a part of a grid."""


def _same_cells(before: OccupancyGrid, grid: OccupancyGrid) -> bool:
    """Whether two grids have the same cells and zones, whatever is in them."""
    return (
        before.occupancy.shape == grid.occupancy.shape
        and np.array_equal(before.origin, grid.origin)
        and before.resolution == grid.resolution
        and len(before.zones) == len(grid.zones)
        and all(map(np.array_equal, before.zones, grid.zones))
    )


def _inflate(
    cost: NDArray[np.float32],
    clearance: NDArray[np.float32],
    grid: OccupancyGrid,
    config: CostmapConfig,
    window: Window,
) -> None:
    """Write costs and clearances of a part of a grid, by the obstacles in and around it."""
    reach = config.inflation_cells(grid.resolution)
    around = _grown(window, reach, cost.shape)
    occupied = grid.occupancy[around] >= config.occupied_threshold
    inner = tuple(
        slice(part.start - whole.start, part.stop - whole.start)
        for part, whole in zip(window, around, strict=True)
    )
    free = grid.occupancy[window] <= config.free_threshold
    if not occupied.any():
        clearance[window] = np.inf
        cost[window] = np.where(free, 1.0, config.unknown_cost)
        return
    cells = distance_to_zero(~occupied)[inner]
    clearance[window] = _clearance(cells, grid.resolution)
    # There are few distances between cells, so that a table saves an exponential in each cell.
    squares = np.arange(reach**2 + 1, dtype=np.float32)
    table = _costs(_clearance(np.sqrt(squares), grid.resolution), config)
    _look_up(cost[window], cells, free, table)


@kernel("void(f4[:,:], f4[:,:], b1[:,::1], f4[:,::1])")
def _look_up(
    cost: NDArray[np.float32],
    cells: NDArray[np.float32],
    free: NDArray[np.bool_],
    table: NDArray[np.float32],
) -> None:
    """Write the costs of cells by the square of their distance; beyond the table its last ones."""
    most = table.shape[1] - 1
    for row in range(cost.shape[0]):
        for col in range(cost.shape[1]):
            square = int(min(cells[row, col] * cells[row, col] + 0.5, most))
            cost[row, col] = table[0 if free[row, col] else 1, square]


def _costs(clearance: NDArray[np.float32], config: CostmapConfig) -> NDArray[np.float32]:
    """Costs (2, N) of free and of unknown cells with these clearances (N,) [m]."""
    cost = np.array([[1.0], [config.unknown_cost]])
    nearness = (clearance - config.safe_radius) / config.inflation_falloff
    cost = cost + config.inflation_cost * np.exp(-np.maximum(nearness, 0.0))
    tightness = (config.safe_radius - clearance) / config.margin
    cost = np.where(tightness > 0, config.squeeze_cost * (1 + tightness), cost)
    cost[:, clearance <= config.closed_radius] = np.inf
    return cost.astype(np.float32)


def _clearance(cells: NDArray[np.float32], resolution: float) -> NDArray[np.float32]:
    """From a cell's centre to the edge of an obstacle whose centre is `cells` away [m]."""
    return np.asarray(np.maximum(cells - 0.5, 0.0) * resolution, np.float32)


def _distance_to(cells: NDArray[np.bool_], resolution: float) -> NDArray[np.float32]:
    """From each cell's centre to the edge of the nearest of `cells` [m]; inf without any."""
    if not cells.any():
        return np.full(cells.shape, np.inf, np.float32)
    return _clearance(distance_to_zero(~cells), resolution)


def _box(mask: NDArray[np.bool_]) -> Window | None:
    """The smallest part of a grid with all cells of a mask; None without any."""
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return None
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(cols[0]), int(cols[-1]) + 1)


def _grown(window: Window, by: int, shape: tuple[int, ...]) -> Window:
    """A window with `by` cells more on each side, as far as the grid reaches."""
    rows, cols = (
        slice(max(part.start - by, 0), min(part.stop + by, size))
        for part, size in zip(window, shape, strict=True)
    )
    return rows, cols


def _joined(first: Window | None, second: Window | None) -> Window | None:
    """The smallest window with both."""
    if first is None or second is None:
        return first or second
    rows, cols = (
        slice(min(a.start, b.start), max(a.stop, b.stop))
        for a, b in zip(first, second, strict=True)
    )
    return rows, cols


def forbidden(grid: OccupancyGrid) -> NDArray[np.bool_]:
    """Mask (rows, cols) of the cells in the keep-out zones of a grid."""
    cells = np.zeros(grid.occupancy.shape, np.uint8)
    for zone in grid.zones:
        corners = grid.to_cells(zone.astype(np.float64))[:, ::-1]
        cv2.fillPoly(cells, [corners.astype(np.int32)], 1)
    return cells.astype(bool)


def way_out(
    closed: NDArray[np.bool_], start: tuple[int, int], resolution: float
) -> NDArray[np.bool_]:
    """Mask (rows, cols) of the closed cells that lie no deeper in zones than the start.

    A robot at the start may cross these cells to get out, and none that lies deeper.

    Args:
        closed: Cells where the robot's centre must not be, the start among them.
        start: Row and column.
        resolution: Edge of a cell [m].
    """
    depth = distance_to_zero(closed)
    return np.asarray(closed & (depth <= depth[start]))
