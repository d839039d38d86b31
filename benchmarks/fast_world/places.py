"""Places of a home from which the fast world has pictures."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.occupancy_slice import PlanGrid, clearance, reachable
from sim_stubs.world.world import World
from vizbot.core.errors import ConfigError

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
