"""What the camera has looked at, cell by cell: the plan of what need not be looked at again.

The obstacle map says where floor was measured, which is not the same: depth has holes, and the
floor right before the robot lies below the image. What the camera has looked across, with measured
floor or an obstacle behind it, counts as looked at.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vizbot.core.geometry import yaw_of
from vizbot.core.types import SE3, OccupancyGrid

BLOCKING = 0.55
"""Occupancy that ends a look: one sight of an obstacle is enough."""
MEASURED = 0.35
"""Occupancy up to which a cell is measured floor."""


class ExploredArea:
    """Cells of the map that lay in view of the camera; it grows with the map."""

    def __init__(self) -> None:
        self._mask: NDArray[np.bool_] = np.zeros((0, 0), np.bool_)
        self._origin = np.zeros(2)

    def on(self, grid: OccupancyGrid) -> NDArray[np.bool_]:
        """The mask (rows, cols) on the cells of `grid`, which is written to by `look`."""
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

    def look(
        self,
        grid: OccupancyGrid,
        T_map_base: SE3,
        field_of_view: float,
        reach: float,
        blind: float,
        gap: float,
        footprint: float,
    ) -> None:
        """Mark what is in view from here, the camera looking ahead.

        A look ends at an obstacle, or at the last measured floor before a gap that is too long.

        Args:
            grid: The obstacle map.
            T_map_base: Where the robot is.
            field_of_view: Horizontal, of the camera [rad].
            reach: Range of the look [m].
            blind: Range within which the floor lies below the image [m].
            gap: Unmeasured floor that is looked across, farther away than that [m].
            footprint: Radius within which the robot knows the floor, since it stands there [m].
        """
        mask, at = self.on(grid), (T_map_base[:2, 3] - grid.origin)[::-1] / grid.resolution
        low = np.maximum((at - footprint / grid.resolution).astype(int), 0)
        high = (at + footprint / grid.resolution).astype(int) + 1
        rows, cols = np.ogrid[low[0] : high[0], low[1] : high[1]]
        under = np.hypot(rows + 0.5 - at[0], cols + 0.5 - at[1]) * grid.resolution < footprint
        stood = mask[low[0] : high[0], low[1] : high[1]]
        stood |= under[: stood.shape[0], : stood.shape[1]]
        _cast(
            mask,
            grid.occupancy,
            at,
            yaw_of(T_map_base),
            field_of_view,
            reach / grid.resolution,
            blind / grid.resolution,
            gap / grid.resolution,
        )


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _cast(
    mask: NDArray[np.bool_],
    occupancy: NDArray[np.float32],
    at: NDArray[np.float64],
    yaw: float,
    field_of_view: float,
    reach: float,
    blind: float,
    gap: float,
) -> None:
    """Walk rays by half cells from `at` (row, col); lengths in cells."""
    rays = int(2 * reach * field_of_view) + 1
    for ray in range(rays):
        angle = yaw + field_of_view * (ray / max(rays - 1, 1) - 0.5)
        c, s = np.cos(angle), np.sin(angle)
        end, unmeasured = -1, 0.0
        for i in range(int(2 * reach)):
            row, col = int(np.floor(at[0] + 0.5 * i * s)), int(np.floor(at[1] + 0.5 * i * c))
            if not (0 <= row < mask.shape[0] and 0 <= col < mask.shape[1]):
                break
            if occupancy[row, col] > BLOCKING:
                end = i
                break
            if occupancy[row, col] <= MEASURED:
                end, unmeasured = i, 0.0
            elif 0.5 * i > blind:
                unmeasured += 0.5
                if unmeasured > gap:
                    break
        for i in range(end + 1):
            mask[int(np.floor(at[0] + 0.5 * i * s)), int(np.floor(at[1] + 0.5 * i * c))] = True
