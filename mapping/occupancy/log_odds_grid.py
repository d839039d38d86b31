"""A grid of log odds that grows where it is painted."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from mapping.occupancy.config import ScanConfig
from mapping.occupancy.planar_scan import BEARINGS, OBSTACLE, PlanarScan
from vizbot.core.geometry import yaw_of
from vizbot.core.program.kernels import kernel
from vizbot.core.types import SE3, OccupancyGrid

_BLOCK = 64
"""The grid grows by whole blocks of this many cells."""


class LogOddsGrid:
    """Log odds that a cell is occupied: 0 unknown, above 0 occupied, within `bounds`."""

    def __init__(
        self, resolution: float, bounds: tuple[float, float], saved: OccupancyGrid | None = None
    ) -> None:
        """Start unknown, or with the cells of a saved grid of the same resolution."""
        self._resolution = resolution
        self._bounds = bounds
        self._log_odds = np.zeros((0, 0), np.float32)
        self._saved = self._log_odds.copy()
        self._corner = np.zeros(2, np.int64)
        if saved is not None:
            self._start_with(saved)

    def _start_with(self, saved: OccupancyGrid) -> None:
        low, high = (
            saved.origin,
            saved.origin + np.array(saved.occupancy.shape[::-1]) * saved.resolution,
        )
        self.include(0.5 * (low + high), 0.5 * float((high - low).max()))
        top, left = np.rint(saved.origin[::-1] / self._resolution).astype(np.int64) - self._corner
        rows, cols = saved.occupancy.shape
        occupancy = saved.occupancy.astype(np.float64)
        with np.errstate(divide="ignore"):
            odds = np.clip(np.log(occupancy) - np.log1p(-occupancy), *self._bounds)
        self._saved[top : top + rows, left : left + cols] = odds
        self._log_odds[:] = self._saved

    @contextmanager
    def repainting(
        self, centres: NDArray[np.float64], radius: float
    ) -> Iterator[Callable[[NDArray[np.float64], float], bool]]:
        """Clear the blocks within `radius` of `centres` (N, 2) [m].

        Only these blocks change within the context.

        Yields:
            A function of a centre and a radius: whether such a disc reaches a cleared block.
        """
        for centre in centres:
            self.include(centre, radius)
        cleared = np.zeros(np.array(self._log_odds.shape) // _BLOCK, np.bool_)
        for centre in centres:
            cleared[self._blocks(centre, radius)] = True
        kept = ~np.kron(cleared, np.ones((_BLOCK, _BLOCK), np.bool_))
        before = self._log_odds[kept]
        self._log_odds[:] = self._saved
        yield lambda centre, radius: bool(cleared[self._blocks(centre, radius)].any())
        self._log_odds[kept] = before

    def _blocks(self, centre: NDArray[np.float64], radius: float) -> tuple[slice, slice]:
        """Rows and columns of the blocks within `radius` of `centre` x, y [m]."""
        cells = np.floor(
            np.stack([centre[::-1] - radius, centre[::-1] + radius]) / self._resolution
        ).astype(np.int64)
        (top, left), (bottom, right) = (cells - self._corner) // _BLOCK
        return slice(max(top, 0), max(bottom + 1, 0)), slice(max(left, 0), max(right + 1, 0))

    def include(self, centre: NDArray[np.float64], radius: float) -> None:
        """Grow until the grid covers a square of half edge `radius` around `centre` x, y [m]."""
        low = np.floor((centre[::-1] - radius) / self._resolution).astype(np.int64) - 1
        high = np.floor((centre[::-1] + radius) / self._resolution).astype(np.int64) + 2
        if not self._log_odds.size:
            self._corner = low // _BLOCK * _BLOCK
        before = np.maximum(-((low - self._corner) // _BLOCK), 0) * _BLOCK
        after = np.maximum(-((self._corner + self._log_odds.shape - high) // _BLOCK), 0) * _BLOCK
        if before.any() or after.any():
            grown = np.stack([before, after], axis=1)
            self._log_odds = np.pad(self._log_odds, grown)
            self._saved = np.pad(self._saved, grown)
            self._corner = self._corner - before

    def paint_scan(
        self, scan: PlanarScan, T_map_level: SE3, odds: NDArray[np.float64], config: ScanConfig
    ) -> None:
        """Add a scan once, with `odds` (5,) for NOTHING to OBSTACLE; `config` is the scan's."""
        self.include(T_map_level[:2, 3], config.max_range)
        _paint(
            self._log_odds,
            T_map_level[:2, 3] / self._resolution - self._corner[::-1],
            yaw_of(T_map_level),
            scan.evidence(),
            scan.first_bearing,
            config.range_step,
            config.depth_noise,
            self._resolution,
            odds,
            *self._bounds,
        )

    def paint_free_disc(self, centre: NDArray[np.float64], radius: float) -> None:
        """Set cells whose centre is within `radius` of `centre` x, y [m] to the lower bound."""
        self.include(centre, radius)
        reach = int(radius / self._resolution) + 1
        position = centre[::-1] / self._resolution - self._corner
        row, col = np.floor(position).astype(np.int64)
        patch = np.s_[max(row - reach, 0) : row + reach + 1, max(col - reach, 0) : col + reach + 1]
        rows, cols = np.mgrid[patch] + 0.5
        inside = np.hypot(rows - position[0], cols - position[1]) * self._resolution < radius
        free = self._log_odds[patch]
        free[inside[: free.shape[0], : free.shape[1]]] = self._bounds[0]

    def occupancy(self) -> OccupancyGrid:
        """The present probabilities, as a copy; one block at least."""
        if not self._log_odds.size:
            self.include(np.zeros(2), 0.0)
        occupancy = (1 / (1 + np.exp(-self._log_odds))).astype(np.float32)
        origin = (self._corner[::-1] * self._resolution).astype(np.float64)
        return OccupancyGrid(occupancy, self._resolution, origin)


@kernel(
    "void(f4[:,::1], f8[::1], f8, Array(u1, 2, 'C', readonly=True), i8, f8, f8, f8, f8[::1],f8,f8)"
)
def _paint(
    log_odds: NDArray[np.float32],
    camera: NDArray[np.float64],
    yaw: float,
    evidence: NDArray[np.uint8],
    first_bearing: int,
    range_step: float,
    depth_noise: float,
    resolution: float,
    odds: NDArray[np.float64],
    min_odds: float,
    max_odds: float,
) -> None:
    """Add a scan to the grid, once a cell, by the highest kind of evidence in it.

    `camera` is the scan's origin col, row in fractions of cells; `odds` by kind of evidence.
    """
    bearings, ranges = evidence.shape
    reach = int(ranges * range_step / resolution) + 1
    left, bottom = int(np.floor(camera[0])) - reach, int(np.floor(camera[1])) - reach
    window = np.zeros((2 * reach + 1, 2 * reach + 1), np.uint8)
    for b in range(bearings):
        angle = ((first_bearing + b + 0.5) / BEARINGS - 0.5) * 2 * np.pi + yaw
        c, s = np.cos(angle), np.sin(angle)
        for r in range(ranges):
            kind = evidence[b, r]
            if kind > 0:
                distance = (r + 0.5) * range_step / resolution
                col = int(np.floor(camera[0] + distance * c)) - left
                row = int(np.floor(camera[1] + distance * s)) - bottom
                window[row, col] = max(window[row, col], kind)
    for row in range(window.shape[0]):
        for col in range(window.shape[1]):
            kind = window[row, col]
            if kind == 0:
                continue
            change = odds[kind]
            if kind == OBSTACLE:
                away = ((row + bottom - camera[1]) ** 2 + (col + left - camera[0]) ** 2) ** 0.5
                # A wall whose depth is uncertain by a cell adds half as much to each cell.
                blur = depth_noise * (away * resolution) ** 2 / resolution
                change /= 1 + blur * blur
            value = log_odds[row + bottom, col + left] + change
            log_odds[row + bottom, col + left] = min(max(value, min_odds), max_odds)
