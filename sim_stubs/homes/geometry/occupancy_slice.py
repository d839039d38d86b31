"""Occupancy of the plan by the true shapes of a world: triangles cut to a layer of height."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import floor

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import House, Instance, Room
from sim_stubs.homes.geometry.solids import triangles
from vizbot.core.distance import distance_to_zero

_FRACTION = 4
"""Bits of the fraction of a corner's row and column, as OpenCV draws it."""
_PER_CELL = 1 << _FRACTION
ROBOT_HEIGHT = 0.65
"""Height of the robot with its mast [m]."""
PASSAGE = 0.25
"""Half the width of every path that must stay free [m]; the robot's half is 0.175."""
DRIVEN_OVER = 0.02
"""Height up to which the robot drives over things [m]."""
FLOOR = (-0.03, 0.02)
"""Heights between which a surface counts as floor [m]."""
CELL = 0.02
"""Edge of a cell [m]."""


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


@dataclass(frozen=True, slots=True, eq=False)
class FreeSpace:
    """The true plan of a house.

    Attributes:
        grid: Cells of the arrays.
        structure: (rows, cols) cells of walls, which also hide what is behind them.
        blocked: (rows, cols) cells with walls, with furniture, or without floor.
        clear: (rows, cols) distance to the nearest blocked cell [m].
    """

    grid: PlanGrid
    structure: NDArray[np.bool_]
    blocked: NDArray[np.bool_]
    clear: NDArray[np.float32]

    @staticmethod
    def from_house(house: House) -> FreeSpace:
        """The free space of a house in a layer as high as the robot."""
        structure = triangles(house.structure)
        grid = grid_around(structure, CELL)
        walls = occupied(structure, DRIVEN_OVER, ROBOT_HEIGHT, grid)
        blocked = walls | ~occupied(structure, *FLOOR, grid)
        bare = FreeSpace(grid, walls, blocked, clearance(blocked, grid))
        return bare.with_pieces(house.instances)

    def with_pieces(self, instances: Sequence[Instance]) -> FreeSpace:
        """The free space with more pieces of furniture."""
        low = [it for it in instances if it.elevation < ROBOT_HEIGHT]
        furniture = triangles([part for it in low for part in it.parts()])
        blocked = self.blocked | occupied(furniture, DRIVEN_OVER, ROBOT_HEIGHT, self.grid)
        return replace(self, blocked=blocked, clear=clearance(blocked, self.grid))

    def reached(self, x: float, y: float) -> NDArray[np.bool_]:
        """Cells (rows, cols) that a path of width 2 PASSAGE connects to a point."""
        cell = self.grid.cell_of(x, y)
        if cell is None:
            return np.zeros(self.grid.shape, np.bool_)
        return reachable(self.clear > PASSAGE, cell)

    def clearance(self, x: float, y: float) -> float:
        """Distance to the nearest blocked cell [m]; 0 outside."""
        cell = self.grid.cell_of(x, y)
        return 0.0 if cell is None else float(self.clear[cell])

    def inside(self, room: Room) -> NDArray[np.bool_]:
        """Cells (rows, cols) whose middle lies in the room."""
        image = np.zeros(self.grid.shape, np.uint8)
        corners = np.round(self.grid.to_pixels(room.polygon) * 16).astype(np.int32)
        cv2.fillPoly(image, [corners], 1, shift=4)
        return image.astype(np.bool_)
