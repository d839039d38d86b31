"""Grids that planners are compared on: drawn halls, rooms and mazes, and maps of recorded runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import minimum_spanning_tree

from nav.config import CostmapConfig
from nav.costmap import Costmap, build_costmap
from vizbot.core.types import OccupancyGrid

RESOLUTION = 0.05
"""Edge of a cell [m]."""
NEAR = 40
"""Distance of a near goal as the crow flies [cells]: 2 m."""
HOME_SIZE = 1000
"""Cells a side of the grid that a recorded map is put into."""
SIZES = (200, 1000, 2000, 4000)
"""Cells a side of the drawn grids."""
GOALS = (1, 100, 1000)
"""Numbers of goals."""
KINDS = ("open", "rooms", "maze")
"""What is drawn."""

_MAPS = Path(__file__).parent / "maps"
_ROOM, _DOOR, _CORRIDOR = 60, 18, 16


@dataclass(frozen=True, slots=True, eq=False)
class PlannerCase:
    """A planning problem.

    Attributes:
        kind: What the grid shows.
        size: Cells a side.
        distance: `near` or `far`.
        costmap: The grid's costs.
        start: (2,) row and column.
        goals: (N, 2) int64 rows and columns; each costs nothing beyond the way.
    """

    kind: str
    size: int
    distance: str
    costmap: Costmap
    start: NDArray[np.int64]
    goals: NDArray[np.int64]

    @property
    def name(self) -> str:
        """What is solved, in words."""
        goals = "1 goal" if len(self.goals) == 1 else f"{len(self.goals)} goals"
        return f"{self.kind}, {self.size} x {self.size}, {self.distance}, {goals}"


def planner_cases(sizes: tuple[int, ...] = SIZES) -> Iterator[PlannerCase]:
    """All cases, one after the other: drawn grids of these sizes, then recorded maps."""
    for size in sizes:
        for kind in KINDS:
            yield from _cases_on(kind, _DRAWN[kind](size, np.random.default_rng(size)))
    for path in recorded_maps():
        yield from _cases_on("home", recorded_map(path).occupancy)


def recorded_maps() -> list[Path]:
    """Obstacle maps of recorded runs, that with most known cells first."""
    return sorted(_MAPS.glob("*.png"), key=lambda path: -_known(_read(path)))


def recorded_map(path: Path) -> OccupancyGrid:
    """A recorded map in a grid of `HOME_SIZE`, unknown around it."""
    cells = _read(path)
    occupancy = np.full((HOME_SIZE, HOME_SIZE), 0.5, np.float32)
    top, left = (HOME_SIZE - np.array(cells.shape)) // 2
    occupancy[top : top + cells.shape[0], left : left + cells.shape[1]] = cells / np.float32(254.0)
    return OccupancyGrid(occupancy, RESOLUTION, np.zeros(2))


def known_floor(costmap: Costmap) -> NDArray[np.int64]:
    """Cells (N, 2) of the largest connected part of what is known and passable."""
    passable = np.isfinite(costmap.cost) & (costmap.grid.occupancy != 0.5)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        passable.astype(np.uint8), connectivity=4
    )
    assert count > 1
    return np.argwhere(labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))


def random_goals(
    cells: NDArray[np.int64], start: NDArray[np.int64], count: int, near: float, far: float
) -> NDArray[np.int64]:
    """`count` of these cells, between `near` and `far` [cells] from the start."""
    away = np.linalg.norm(cells - start, axis=1)
    cells = cells[(away >= near) & (away <= far)]
    return np.asarray(cells[np.random.default_rng(count).integers(0, len(cells), count)])


def _cases_on(kind: str, occupancy: NDArray[np.float32]) -> Iterator[PlannerCase]:
    size = len(occupancy)
    grid = OccupancyGrid(occupancy, RESOLUTION, np.zeros(2))
    costmap = build_costmap(grid, CostmapConfig())
    cells = known_floor(costmap)
    span = float(np.ptp(cells, axis=0).max())
    middle = cells[np.argmin(np.linalg.norm(cells - cells.mean(axis=0), axis=1))]
    corner = cells[np.argmin(cells.sum(axis=1))]
    for distance, start, near, far in (
        ("near", middle, NEAR - 2.0, NEAR + 2.0),
        ("far", corner, 0.6 * span, 2.0 * span),
    ):
        for count in GOALS:
            goals = random_goals(cells, start, count, near, far)
            yield PlannerCase(kind, size, distance, costmap, start, goals)


def _open(size: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """A hall without anything in it."""
    return np.zeros((size, size), np.float32)


def _rooms(size: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """Rooms of 3 m, a door to each neighbour, and a piece of furniture in each."""
    occupancy = np.zeros((size, size), np.float32)
    for wall in range(_ROOM, size, _ROOM):
        occupancy[wall], occupancy[:, wall] = 1.0, 1.0
    for top in range(0, size, _ROOM):
        for left in range(0, size, _ROOM):
            down, right = rng.integers(4, _ROOM - _DOOR - 4, 2)
            if top:
                occupancy[top, left + down : left + down + _DOOR] = 0.0
            if left:
                occupancy[top + right : top + right + _DOOR, left] = 0.0
            row, col = rng.integers(12, 30, 2)
            occupancy[top + row : top + row + 14, left + col : left + col + 12] = 1.0
    return occupancy


def _maze(size: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """Corridors of 0.75 m with one way between any two places."""
    side = size // _CORRIDOR
    number = np.arange(side * side).reshape(side, side)
    pairs = np.concatenate(
        [
            np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1),
            np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1),
        ]
    )
    weights = rng.random(len(pairs)) + 1e-3
    tree = minimum_spanning_tree(coo_matrix((weights, pairs.T), shape=(side * side,) * 2)).tocoo()
    occupancy = np.ones((size, size), np.float32)
    for a, b in zip(tree.row, tree.col, strict=True):
        (top, left), (bottom, right) = sorted([divmod(int(a), side), divmod(int(b), side)])
        rows = slice(top * _CORRIDOR, (bottom + 1) * _CORRIDOR - 1)
        occupancy[rows, left * _CORRIDOR : (right + 1) * _CORRIDOR - 1] = 0.0
    return occupancy


_DRAWN = {"open": _open, "rooms": _rooms, "maze": _maze}


def _read(path: Path) -> NDArray[np.uint8]:
    """Cells of a picture of a map: 0 free, 127 unknown, 254 occupied."""
    return np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), np.uint8)


def _known(cells: NDArray[np.uint8]) -> int:
    return int(np.count_nonzero(cells != 127))
