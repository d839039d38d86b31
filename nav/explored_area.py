"""The explored area: the cells of the map that were in view of the camera.

It differs from the floor that was measured: depth has holes, and the floor right before the robot
lies below the image. Cells that the camera looked across, with measured floor or an obstacle behind
them, count as explored.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.geometry import yaw_of
from vizbot.core.program.kernels import kernel
from vizbot.core.types import SE3, OccupancyGrid

BLOCKING = 0.55
"""Occupancy that blocks the view: one sight of an obstacle is enough."""
MEASURED = 0.35
"""Occupancy up to which a cell is measured floor."""


class ExploredArea:
    """A mask of the explored cells, which grows with the obstacle map."""

    def __init__(self) -> None:
        self._mask: NDArray[np.bool_] = np.zeros((0, 0), np.bool_)
        self._origin = np.zeros(2)

    def mask_on(self, grid: OccupancyGrid) -> NDArray[np.bool_]:
        """The mask (rows, cols) on the cells of `grid`; `add_view` writes to it."""
        shape = grid.occupancy.shape
        if self._mask.shape != shape or not np.array_equal(self._origin, grid.origin):
            mask: NDArray[np.bool_] = np.zeros(shape, np.bool_)
            shift = np.round((self._origin - grid.origin) / grid.resolution).astype(int)[::-1]
            low = np.maximum(shift, 0)
            high = np.minimum(shift + self._mask.shape, shape)
            if (high > low).all():
                kept = self._mask[tuple(map(slice, low - shift, high - shift))]
                mask[tuple(map(slice, low, high))] = kept
            self._mask, self._origin = mask, grid.origin.copy()
        return self._mask

    def area(self, resolution: float) -> float:
        """How much was explored so far, with cells of `resolution` [m^2]."""
        return float(np.count_nonzero(self._mask) * resolution**2)

    def add_view(
        self,
        grid: OccupancyGrid,
        T_map_base: SE3,
        field_of_view: float,
        reach: float,
        blind_range: float,
        gap: float,
        footprint: float,
    ) -> None:
        """Mark the cells in view of a camera that looks ahead.

        A ray ends at an obstacle, or at the last measured floor before a gap that is too long.

        Args:
            grid: The obstacle map.
            T_map_base: Where the robot is.
            field_of_view: Horizontal, of the camera [rad].
            reach: Length of the rays [m].
            blind_range: Range within which the floor lies below the image [m].
            gap: Most unmeasured floor that a ray crosses beyond that range [m].
            footprint: Radius around the robot that is explored because it stands there [m].
        """
        mask = self.mask_on(grid)
        start = (T_map_base[:2, 3] - grid.origin)[::-1] / grid.resolution
        low = np.maximum((start - footprint / grid.resolution).astype(int), 0)
        high = np.maximum((start + footprint / grid.resolution).astype(int) + 1, 0)
        rows, cols = np.ogrid[low[0] : high[0], low[1] : high[1]]
        distance = np.hypot(rows + 0.5 - start[0], cols + 0.5 - start[1]) * grid.resolution
        under = distance < footprint
        around = mask[low[0] : high[0], low[1] : high[1]]
        around |= under[: around.shape[0], : around.shape[1]]
        _cast_rays(
            mask,
            grid.occupancy,
            start,
            yaw_of(T_map_base),
            field_of_view,
            reach / grid.resolution,
            blind_range / grid.resolution,
            gap / grid.resolution,
        )


@kernel("void(b1[:,::1], f4[:,::1], f8[::1], f8, f8, f8, f8, f8)")
def _cast_rays(
    mask: NDArray[np.bool_],
    occupancy: NDArray[np.float32],
    start: NDArray[np.float64],
    yaw: float,
    field_of_view: float,
    reach: float,
    blind_range: float,
    gap: float,
) -> None:
    """Walk rays by half cells from `start` (row, col); lengths are in cells."""
    rays = int(2 * reach * field_of_view) + 1
    for ray in range(rays):
        angle = yaw + field_of_view * (ray / max(rays - 1, 1) - 0.5)
        c, s = np.cos(angle), np.sin(angle)
        end, unmeasured = -1, 0.0
        for i in range(int(2 * reach)):
            row = int(np.floor(start[0] + 0.5 * i * s))
            col = int(np.floor(start[1] + 0.5 * i * c))
            if not (0 <= row < mask.shape[0] and 0 <= col < mask.shape[1]):
                break
            if occupancy[row, col] > BLOCKING:
                end = i
                break
            if occupancy[row, col] <= MEASURED:
                end, unmeasured = i, 0.0
            elif 0.5 * i > blind_range:
                unmeasured += 0.5
                if unmeasured > gap:
                    break
        for i in range(end + 1):
            row = int(np.floor(start[0] + 0.5 * i * s))
            col = int(np.floor(start[1] + 0.5 * i * c))
            mask[row, col] = True
