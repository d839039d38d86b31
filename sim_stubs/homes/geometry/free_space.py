"""The true free space of a furnished house: where a robot can stand and drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import House, Instance, Room
from sim_stubs.homes.geometry.occupancy_slice import (
    PlanGrid,
    clearance,
    grid_around,
    occupied,
    reachable,
)
from sim_stubs.homes.geometry.solids import triangles

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
