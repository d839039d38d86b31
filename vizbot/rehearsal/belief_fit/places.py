"""Places of a home from which there are pictures, and where its things and rooms truly are."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.footprint import PLACE
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.occupancy_slice import PlanGrid, clearance, occupied, reachable
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.start_pose import things_named
from sim_stubs.world.world import World
from vizbot.core.errors import ConfigError

_MARGIN = 4
"""Places around the house that are on the plan, too."""
_PARTS = 5
"""Cells along the edge of a place by which its share is measured."""
_LEAST_SHARE = 0.03
"""Share of a place that a thing covers at least, to be there."""
_EVERY_HEIGHT = (-100.0, 100.0)
SPACING = 0.5
"""Edge of a block of the plan; each part of it that walls leave connected has one place [m]."""
ROOMY = 0.2
"""A place need not be farther from obstacles than this [m]."""
_CLEARANCE_WORTH = 1.5
"""Distance from the middle of a block that one metre of clearance makes up for."""


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Places where the robot can stand, about `SPACING` apart.

    Attributes:
        xy: (N, 2) x, y in the world [m].
        of_cell: (rows, cols) int32, the place of each cell of the plan; -1 where nobody can stand.
        grid: Those cells.
    """

    xy: NDArray[np.float64]
    of_cell: NDArray[np.int32]
    grid: PlanGrid

    @staticmethod
    def in_world(world: World) -> Places:
        """The places that the robot can drive to from where it stands.

        Raises:
            ConfigError: it stands in an obstacle.
        """
        free, grid = world.free
        start = grid.cell_of(*world.T_world_base[:2, 3].tolist())
        reached = np.zeros_like(free) if start is None else reachable(free, start)
        if not reached.any():
            raise ConfigError("the robot of this world stands in an obstacle; give another --start")
        block = round(SPACING / grid.resolution)
        clear = np.minimum(clearance(~reached, grid), ROOMY) / grid.resolution
        of_cell = np.full(free.shape, -1, np.int32)
        cells: list[NDArray[np.intp]] = []
        for top in range(0, free.shape[0], block):
            for left in range(0, free.shape[1], block):
                inside = reached[top : top + block, left : left + block]
                count, parts = cv2.connectedComponents(inside.astype(np.uint8), connectivity=4)
                for part in range(1, count):
                    own = np.argwhere(parts == part)
                    away = np.hypot(*(own - (block - 1) / 2).T)
                    there = own + np.array([top, left])
                    worth = _CLEARANCE_WORTH * clear[there[:, 0], there[:, 1]]
                    of_cell[there[:, 0], there[:, 1]] = len(cells)
                    cells.append(there[np.argmin(away - worth)])
        xy = grid.pixels_to_xy(np.array(cells, np.float64)[:, ::-1])
        return Places(xy, of_cell, grid)

    def nearest(self, x: float, y: float) -> int:
        """The place of a point: that of its part of a block, else the nearest one."""
        cell = self.grid.cell_of(x, y)
        if cell is not None and self.of_cell[cell] >= 0:
            return int(self.of_cell[cell])
        return int(np.argmin(np.hypot(*(self.xy - (x, y)).T)))


def true_places(house: House, text: str) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Where a goal is on the plan.

    A thing is at the places that it covers a part of, and at those beside them, since measured
    points scatter. A room is where most of a place lies on its floor.

    Args:
        house: The house.
        text: The goal in words.

    Returns:
        (rows, cols) whether the goal is at each place, and the column and row (2,) of the first
        one, counted in places from the origin of the world.
    """
    corners = triangles(house.structure)[..., :2].reshape(-1, 2)
    low = np.floor(corners.min(axis=0) / PLACE).astype(np.int64) - _MARGIN
    columns, rows = (np.ceil(corners.max(axis=0) / PLACE).astype(np.int64) + _MARGIN - low).tolist()
    fine = PlanGrid(low * PLACE, PLACE / _PARTS, (rows * _PARTS, columns * _PARTS))
    things, rooms = things_named(house, text)
    covered = np.zeros(fine.shape, np.uint8)
    for room in rooms:
        outline = np.round(fine.to_pixels(room.polygon) * 16).astype(np.int32)
        cv2.fillPoly(covered, [outline], 1, shift=4)
    if not rooms:
        for thing in things:
            covered |= occupied(triangles(thing.parts()), *_EVERY_HEIGHT, fine).astype(np.uint8)
    shares = covered.reshape(rows, _PARTS, columns, _PARTS).mean(axis=(1, 3))
    if rooms:
        return shares > 0.5, low
    there = (shares > _LEAST_SHARE).astype(np.uint8)
    beside = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    return cv2.dilate(there, beside).astype(np.bool_), low


def are_true(
    places: NDArray[np.int64], there: NDArray[np.bool_], low: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Whether the goal is at places (N, 2) column, row; `there` and `low` as of `true_places`."""
    column, row = (places - low).T
    inside = (column >= 0) & (row >= 0) & (row < there.shape[0]) & (column < there.shape[1])
    return np.asarray(inside & there[np.where(inside, row, 0), np.where(inside, column, 0)])
