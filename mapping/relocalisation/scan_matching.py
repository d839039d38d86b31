"""Correlative scan matching (Olson 2009): the pose of a local obstacle grid in a known map.

The local grid is laid over the map at every pose of a lattice. An obstacle counts for a pose where
the map has one and against it where the map is free; free floor counts against a pose where the map
has an obstacle. Cells that either does not know do not count.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.relocalisation.config import ScanMatchConfig
from vizbot.core.geometry import planar, transform
from vizbot.core.types import SE3, OccupancyGrid

_OBSTACLE, _FREE = 0, 1
"""Channels of the weights of a cell."""


@dataclass(frozen=True, slots=True, eq=False)
class ScanMatch:
    """The best pose, and the best different one.

    Attributes:
        T_map_around: Pose of the local grid in the map; on the floor.
        agreement: Share of its obstacles that lie on those of the map, less penalties.
        T_map_rival: The best different pose.
        rival: The agreement of that pose.
    """

    T_map_around: SE3
    agreement: float
    T_map_rival: SE3
    rival: float


def match_scan(
    around: OccupancyGrid, known: OccupancyGrid, config: ScanMatchConfig
) -> ScanMatch | None:
    """Find the pose of a local grid, with the robot at or near its origin, in a known map.

    Returns:
        None if the local grid has no obstacle.
    """
    obstacles, free = _obstacles_and_free(around)
    if len(obstacles) == 0:
        return None
    fine = _CellWeights.from_map(known, config)
    coarse = fine.shrunk(config.cell)
    angles = np.arange(0.0, 2 * np.pi, config.angle)
    agreements = coarse.agreements(obstacles, free, angles)
    best = _best(agreements)
    turned = np.abs(np.angle(np.exp(1j * (angles - angles[best[0]]))))
    rows, cols = np.mgrid[: agreements.shape[1], : agreements.shape[2]]
    distance = np.hypot(rows - best[1], cols - best[2]) * coarse.cell
    same = (turned < config.different_angle)[:, None, None] & (distance < config.different_distance)
    other = _best(np.where(same, -np.inf, agreements))
    first, second = (
        fine.refined(obstacles, free, planar(*coarse.xy(row, col), float(angles[turn])), config)
        for turn, row, col in (best, other)
    )
    return ScanMatch(*first, *second)


def _best(agreements: NDArray[np.float32]) -> tuple[int, int, int]:
    """Angle, row and column of the highest."""
    turn, row, col = np.unravel_index(agreements.argmax(), agreements.shape)
    return int(turn), int(row), int(col)


def agreement_at(
    T_map_around: SE3, around: OccupancyGrid, known: OccupancyGrid, config: ScanMatchConfig
) -> float | None:
    """Agreement of a local grid with the map at a pose, up to 1; None where too little is known."""
    obstacles, free = _obstacles_and_free(around)
    weights = _CellWeights.from_map(known, config)
    of_obstacles = weights.looked_up(obstacles, T_map_around, _OBSTACLE)
    known_cells = int(np.count_nonzero(of_obstacles))
    if known_cells < config.min_cells:
        return None
    of_free = weights.looked_up(free, T_map_around, _FREE)
    return float(of_obstacles.sum() + of_free.sum()) / known_cells


def _obstacles_and_free(grid: OccupancyGrid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """x, y (N, 2) of obstacles and (M, 2) of free cells [m]."""
    obstacles, free = _sure_cells(grid)
    return grid.to_xy(np.argwhere(obstacles)), grid.to_xy(np.argwhere(free))


def _sure_cells(grid: OccupancyGrid) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks (rows, cols) of cells that are surely obstacles, and surely free."""
    return grid.occupancy > 0.6, grid.occupancy < 0.4


@dataclass(frozen=True, slots=True, eq=False)
class _CellWeights:
    """The weight of an obstacle and of free floor in each cell of the map.

    Attributes:
        image: (rows, cols, 2) float32 for obstacles and for free floor.
        cell: Edge of a cell [m].
        origin: (2,) x, y of the outer corner of cell [0, 0] [m].
    """

    image: NDArray[np.float32]
    cell: float
    origin: NDArray[np.float64]

    @classmethod
    def from_map(cls, known: OccupancyGrid, config: ScanMatchConfig) -> Self:
        obstacles, free = _sure_cells(known)
        off = cv2.distanceTransform((~obstacles).astype(np.uint8), cv2.DIST_L2, 5)
        off = np.minimum(off * known.resolution, 10 * config.sigma)  # huge without any obstacle
        near = np.exp(-0.5 * (off / config.sigma) ** 2)
        alien = (near < 0.1) & free
        near[near < 0.1] = 0.0
        image = np.stack(
            (
                np.where(alien, -config.free_space_penalty, near),
                np.where(obstacles, -config.missed_obstacle_penalty, 0.0),
            ),
            axis=-1,
        )
        return cls(image.astype(np.float32), known.resolution, known.origin)

    def shrunk(self, cell: float) -> Self:
        """The same in cells of about edge `cell` [m], if that is larger."""
        times = max(round(cell / self.cell), 1)
        rows, cols = (size // times for size in self.image.shape[:2])
        whole = self.image[: rows * times, : cols * times]
        image = cv2.resize(whole, (cols, rows), interpolation=cv2.INTER_AREA)
        return replace(self, image=image, cell=self.cell * times)

    def xy(self, row: int, col: int) -> tuple[float, float]:
        """Centre x, y of a cell [m]."""
        x, y = self.origin + np.array([col + 0.5, row + 0.5]) * self.cell
        return float(x), float(y)

    def agreements(
        self,
        obstacles: NDArray[np.float64],
        free: NDArray[np.float64],
        angles: NDArray[np.float64],
    ) -> NDArray[np.float32]:
        """Agreement (angles, rows, cols) with the origin of the local grid in each cell."""
        reach = np.linalg.norm(np.concatenate((obstacles, free)), axis=1).max()
        half = int(reach / self.cell) + 1
        padded = cv2.copyMakeBorder(self.image, *(half,) * 4, cv2.BORDER_CONSTANT, value=0)
        size = 2 * half + 1

        def picture(xy: NDArray[np.float64], angle: float) -> NDArray[np.float32]:
            turned = transform(planar(0.0, 0.0, angle), np.pad(xy, ((0, 0), (0, 1))))
            cols, rows = np.rint(turned[:, :2] / self.cell).astype(np.intp).T + half
            counts = np.bincount(rows * size + cols, minlength=size * size)
            return (counts.reshape(size, size) / len(obstacles)).astype(np.float32)

        return np.stack(
            [
                cv2.matchTemplate(
                    padded,
                    np.dstack((picture(obstacles, angle), picture(free, angle))),
                    cv2.TM_CCORR,
                )
                for angle in angles
            ]
        )

    def looked_up(
        self, xy: NDArray[np.float64], T_map_around: SE3, channel: int
    ) -> NDArray[np.float32]:
        """Weights (N,) of points (N, 2) of the local grid at a pose; 0 off the map."""
        in_map = transform(T_map_around, np.pad(xy, ((0, 0), (0, 1))))[:, :2]
        cols, rows = np.floor((in_map - self.origin) / self.cell).astype(np.intp).T
        weights = np.zeros(len(xy), np.float32)
        inside = (rows >= 0) & (rows < self.image.shape[0])
        inside &= (cols >= 0) & (cols < self.image.shape[1])
        weights[inside] = self.image[rows[inside], cols[inside], channel]
        return weights

    def refined(
        self,
        obstacles: NDArray[np.float64],
        free: NDArray[np.float64],
        T_map_around: SE3,
        config: ScanMatchConfig,
    ) -> tuple[SE3, float]:
        """The best pose around one of the lattice, and its agreement."""
        steps = np.arange(-config.cell, config.cell + 1e-9, self.cell)
        turns = np.linspace(-config.angle, config.angle, 9)
        poses = [
            planar(dx, dy, 0.0) @ T_map_around @ planar(0.0, 0.0, turn)
            for turn, dx, dy in itertools.product(turns, steps, steps)
        ]
        sums = [
            float(
                self.looked_up(obstacles, T, _OBSTACLE).sum() + self.looked_up(free, T, _FREE).sum()
            )
            for T in poses
        ]
        best = int(np.argmax(sums))
        return poses[best], sums[best] / len(obstacles)
