"""Keep-out zones: floor that the robot must not drive on."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.distance import distance_to_zero
from vizbot.core.types import OccupancyGrid


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
