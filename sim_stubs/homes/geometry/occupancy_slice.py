"""Occupancy of the plan by the true shapes of a world: triangles cut to a layer of height."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.distance import distance_to_zero

_FRACTION = 4
"""Bits of the fraction of a corner's row and column, as OpenCV draws it."""
_PER_CELL = 1 << _FRACTION


@dataclass(frozen=True, slots=True, eq=False)
class PlanGrid:
    """Cells of the plan.

    Attributes:
        origin: (2,) x, y of the outer corner of cell [0, 0] [m].
        resolution: Edge of a cell [m].
        shape: Rows (along y) and columns (along x).
    """

    origin: NDArray[np.float64]
    resolution: float
    shape: tuple[int, int]

    def to_pixels(self, xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Fractional column, row (..., 2) of points (..., 2) x, y, in OpenCV's order.

        The centre of a cell is a whole number. `OccupancyGrid.to_cells` gives row, column.
        """
        return (xy - self.origin) / self.resolution - 0.5

    def pixels_to_xy(self, pixels: NDArray[np.floating]) -> NDArray[np.float64]:
        """Points (..., 2) x, y [m] of column, row (..., 2)."""
        return np.asarray((pixels + 0.5) * self.resolution + self.origin)

    def cell_of(self, x: float, y: float) -> tuple[int, int] | None:
        """Row, column of a point; None outside."""
        column = floor((x - float(self.origin[0])) / self.resolution)
        row = floor((y - float(self.origin[1])) / self.resolution)
        inside = 0 <= row < self.shape[0] and 0 <= column < self.shape[1]
        return (row, column) if inside else None


def grid_around(
    triangles: NDArray[np.float64], resolution: float = 0.01, margin: float = 0.3
) -> PlanGrid:
    """A grid over the plan of `triangles` (N, 3, 3) with a `margin` [m] around it."""
    corners = triangles[..., :2].reshape(-1, 2)
    low = np.array([corners[:, 0].min(), corners[:, 1].min()]) - margin
    high = np.array([corners[:, 0].max(), corners[:, 1].max()]) + margin
    columns, rows = np.ceil((high - low) / resolution).astype(int)
    return PlanGrid(low, resolution, (int(rows), int(columns)))


def occupied(
    triangles: NDArray[np.float64], low: float, high: float, grid: PlanGrid
) -> NDArray[np.bool_]:
    """Cells (rows, cols) that a surface crosses between the heights `low` and `high`.

    Args:
        triangles: (N, 3, 3) corners in the world [m].
        low: Lower end of the layer [m].
        high: Upper end of the layer [m].
        grid: Cells of the result.

    Returns:
        True on surfaces alone: the inside of a solid that fills the layer stays False.
    """
    z0, z1, z2 = np.moveaxis(triangles[..., 2], 1, 0)  # along an axis of 3, `min` takes long
    lowest = np.minimum(np.minimum(z0, z1), z2)
    highest = np.maximum(np.maximum(z0, z1), z2)
    touching = (highest > low) & (lowest < high)
    whole = touching & (lowest >= low) & (highest <= high)
    image = np.zeros(grid.shape, np.uint8)
    # The outline is drawn too, and keeps upright faces, which have no area on the plan.
    corners = _fixed_point(triangles[whole, :, :2], grid)
    cells = (corners + _PER_CELL // 2) // _PER_CELL
    # A triangle in one cell is that cell, but OpenCV cuts off what leaves the grid.
    within = (cells > 0) & (cells < grid.shape[::-1])
    in_one = ((cells == cells[:, :1]) & within).all(axis=(1, 2))
    image[cells[in_one, 0, 1], cells[in_one, 0, 0]] = 1
    draw = cv2.fillConvexPoly  # of hundreds of thousands, so without names of arguments
    for polygon in corners[~in_one]:
        draw(image, polygon, 1, cv2.LINE_8, _FRACTION)
    for points in _fixed_point(_cut_to_layer(triangles[touching & ~whole], low, high), grid):
        draw(image, cv2.convexHull(points), 1, cv2.LINE_8, _FRACTION)
    return image.astype(np.bool_)


def clearance(occupied_cells: NDArray[np.bool_], grid: PlanGrid) -> NDArray[np.float32]:
    """Distance [m] from the centre of each cell to the nearest occupied cell's edge, about."""
    distance = distance_to_zero(~occupied_cells)
    return np.asarray((distance - 0.5).clip(0.0) * grid.resolution, np.float32)


def reachable(free: NDArray[np.bool_], start: tuple[int, int]) -> NDArray[np.bool_]:
    """Cells (rows, cols) connected to `start` (row, col) through free cells; none if it is not."""
    _, labels = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    if not free[start]:
        return np.zeros_like(free)
    return np.asarray(labels == labels[start])


def _fixed_point(xy: NDArray[np.float64], grid: PlanGrid) -> NDArray[np.int32]:
    """Column, row of plan points in sixteenths of a cell, as OpenCV draws them."""
    return np.round(grid.to_pixels(xy) * _PER_CELL).astype(np.int32)


def _cut_to_layer(triangles: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    """Plan points (N, 9, 2) whose convex hull is what a layer holds of each triangle (N, 3, 3).

    They are the corners in the layer, and where edges pass its two planes; every triangle has one
    at least, which also fills up the places of those that do not exist.
    """
    ends = np.roll(triangles, -1, axis=1)
    z = triangles[..., 2]
    points, exist = [triangles], [(z >= low) & (z <= high)]
    for height in (low, high):
        above, above_end = z - height, ends[..., 2] - height
        passes = np.sign(above) * np.sign(above_end) < 0  # their product may underflow
        share = above / np.where(passes, above - above_end, 1.0)
        points.append(triangles + (ends - triangles) * share[..., None])
        exist.append(passes)
    plan, there = np.concatenate(points, axis=1)[..., :2], np.concatenate(exist, axis=1)
    filler = plan[np.arange(len(plan)), there.argmax(axis=1)]
    return np.where(there[..., None], plan, filler[:, None])
