"""Keep-out zones: floor that people forbid the robot to drive on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import OccupancyGrid

Zone: TypeAlias = NDArray[np.float32]
"""(K, 2) corners x, y of a polygon in `map` [m], at least three, in order."""


def close_zones(
    grid: OccupancyGrid, zones: Sequence[Zone], robot_xy: NDArray[np.float64]
) -> OccupancyGrid:
    """Forbid zones on an obstacle map.

    A zone that the robot's centre is in does not hold until it has left it: it must get out.

    Args:
        grid: The obstacle map; a zone counts as far as the map reaches.
        zones: Where the robot must not be.
        robot_xy: (2,) where it is, in `map` [m].
    """
    closed = np.zeros(grid.occupancy.shape, np.uint8)
    x, y = map(float, robot_xy)
    for zone in zones:
        if cv2.pointPolygonTest(zone.astype(np.float32), (x, y), measureDist=False) < 0:
            cells = grid.to_cells(zone.astype(np.float64))[:, ::-1]
            cv2.fillPoly(closed, [cells.astype(np.int32)], 1)
    return replace(grid, closed=closed.astype(bool)) if closed.any() else grid
