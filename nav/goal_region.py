"""Where a robot may stop for its goals: near enough and no nearer, with nothing in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nav.costmap import Costmap
from vizbot.core.program.kernels import kernel

NO_GOAL = -1


@dataclass(frozen=True, slots=True, eq=False)
class GoalRegion:
    """Cells that reach a goal.

    Attributes:
        corner: (2,) row and column on the map of the first cell of `nearest`.
        nearest: (R, C) int64 index of the nearest goal that a cell reaches, NO_GOAL for none; no
            cell of the map beyond reaches any.
    """

    corner: NDArray[np.int64]
    nearest: NDArray[np.int64]

    def stops(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Cells (S, 2) that reach a goal, row by row, and the index (S,) of its goal."""
        cells = np.argwhere(self.nearest != NO_GOAL)
        return cells + self.corner, self.nearest[tuple(cells.T)]

    def goal_from(self, cell: NDArray[np.int64]) -> int:
        """Index of the goal that a cell (2,) reaches; NO_GOAL for none, and outside the map."""
        row, col = cell - self.corner
        inside = 0 <= row < self.nearest.shape[0] and 0 <= col < self.nearest.shape[1]
        return int(self.nearest[row, col]) if inside else NO_GOAL


def fronts(
    costmap: Costmap,
    goals_xy: NDArray[np.float64],
    seen_from: NDArray[np.float64],
    depth: float,
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Find the front of the object that each goal lies on or in, on the side it was seen from.

    A goal mostly lies in an occupied cell or close behind one, and another room may be as near to
    it as the one that it was seen from.

    Args:
        costmap: Which cells are free.
        goals_xy: (N, 2) in `map` [m].
        seen_from: (N, 2) positions of the camera in `map` [m].
        depth: Largest distance between a front and its goal [m].

    Returns:
        (N, 2) the first free point from the goal back along the line of sight [m], and (N,) whether
        there is one.
    """
    back = seen_from - goals_xy
    length = np.linalg.norm(back, axis=1)
    back *= (np.minimum(depth, length) / np.maximum(length, 1e-9))[:, None]
    steps = int(np.ceil(2 * depth / costmap.grid.resolution)) + 1
    line = goals_xy + np.linspace(0.0, 1.0, steps)[:, None, None] * back
    cells = costmap.grid.to_cells(line.reshape(-1, 2))
    inside = costmap.grid.contains(cells)
    free = np.zeros(len(cells), bool)
    occupancy = costmap.grid.occupancy[tuple(cells[inside].T)]
    free[inside] = occupancy <= costmap.config.free_threshold
    along = free.reshape(steps, len(goals_xy))
    first = line[np.argmax(along, axis=0), np.arange(len(goals_xy))]
    return first, np.asarray(along.any(axis=0))


def goal_region(
    costmap: Costmap,
    goals_xy: NDArray[np.float64],
    reach: float,
    own_extent: float,
    fronts_xy: NDArray[np.float64] | None = None,
    least: NDArray[np.float64] | None = None,
) -> GoalRegion:
    """Find for each cell the index of the nearest goal that a robot in it would have reached.

    A goal is a point on or in an object, mostly in an occupied cell or close behind one. A cell
    reaches it from within `reach` over a straight line that crosses no occupied cell, except within
    `own_extent` of the goal itself, where it crosses the object. Cells closed to the robot reach
    nothing.

    Args:
        costmap: Where the robot can be.
        goals_xy: (N, 2) in `map` [m].
        reach: Distance from the robot's centre to the goal [m].
        own_extent: Size of the object that may surround the goal point [m].
        fronts_xy: (N, 2) points that must be in sight instead of the goals; None for the goals [m].
        least: (N,) distances from the goals within which they are not reached; None for 0 [m].
    """
    goals_xy = np.asarray(goals_xy, np.float64).reshape(-1, 2)
    least = np.zeros(len(goals_xy)) if least is None else least
    # Hundreds of points of one object share few cells; one goal a cell is enough.
    _, one_each = np.unique(costmap.grid.to_cells(goals_xy), axis=0, return_index=True)
    one_each.sort()
    resolution = costmap.grid.resolution
    seen_xy = goals_xy if fronts_xy is None else fronts_xy
    goal_cells, seen_cells = (
        (xy[one_each] - costmap.grid.origin)[:, ::-1] / resolution for xy in (goals_xy, seen_xy)
    )
    # Beyond the reach of all goals there is nothing to look at.
    size, cells = np.array(costmap.cost.shape), reach / resolution
    low = np.clip(np.floor(goal_cells.min(axis=0, initial=np.inf) - cells), 0, size)
    high = np.clip(np.floor(goal_cells.max(axis=0, initial=-np.inf) + cells) + 1, low, size)
    corner = low.astype(np.int64)
    nearest = np.full((high - low).astype(np.int64), NO_GOAL)
    _nearest_goals(
        nearest,
        corner,
        costmap.clearance,
        costmap.cost,
        goal_cells,
        seen_cells,
        one_each.astype(np.int64),
        least[one_each] / resolution,
        cells,
        own_extent / resolution,
    )
    return GoalRegion(corner, nearest)


def reached_goal(
    costmap: Costmap,
    goals_xy: NDArray[np.float64],
    position: NDArray[np.float64],
    reach: float,
    own_extent: float,
    fronts_xy: NDArray[np.float64] | None = None,
    least: NDArray[np.float64] | None = None,
) -> int | None:
    """Index of the nearest goal that a robot at `position` (2,) has reached, as in `goal_region`.

    The cell of the robot itself may be closed or unknown.
    """
    goals_xy = np.asarray(goals_xy, np.float64).reshape(-1, 2)
    seen_xy = goals_xy if fronts_xy is None else fronts_xy
    distances = np.linalg.norm(goals_xy - position, axis=1)
    for goal in np.argsort(distances, kind="stable"):
        if distances[goal] > reach:
            return None
        if least is not None and distances[goal] < least[goal]:
            continue
        if sees(costmap, position, seen_xy[goal], own_extent):
            return int(goal)
    return None


def sees(
    costmap: Costmap,
    from_xy: NDArray[np.float64],
    to_xy: NDArray[np.float64],
    own_extent: float,
) -> bool:
    """Whether no occupied cell lies between, farther than `own_extent` [m] from `to_xy`."""
    grid = costmap.grid
    (row, col), (goal_row, goal_col) = (
        ((xy - grid.origin) / grid.resolution)[::-1] for xy in (from_xy, to_xy)
    )
    extent = own_extent / grid.resolution
    return bool(clear_line(costmap.clearance, row, col, goal_row, goal_col, extent))


@kernel("b1(f4[:,::1], f8, f8, f8, f8, f8)")
def clear_line(
    clearance: NDArray[np.float32],
    row: float,
    col: float,
    goal_row: float,
    goal_col: float,
    own_extent: float,
) -> bool:
    """Walk a line, in cells, by half cells; outside the grid nothing blocks it."""
    length = np.sqrt((goal_row - row) ** 2 + (goal_col - col) ** 2)
    steps = int(2 * length) + 1
    for i in range(1, steps):
        along = i / steps
        if (1 - along) * length <= own_extent:
            break
        r = int(np.floor(row + along * (goal_row - row)))
        c = int(np.floor(col + along * (goal_col - col)))
        inside = 0 <= r < clearance.shape[0] and 0 <= c < clearance.shape[1]
        if inside and clearance[r, c] == 0:
            return False
    return True


@kernel(
    "void(i8[:,::1], i8[::1], f4[:,::1], f4[:,::1], f8[:,::1], f8[:,::1], i8[::1], f8[::1], f8, f8)"
)
def _nearest_goals(
    region: NDArray[np.int64],
    corner: NDArray[np.int64],
    clearance: NDArray[np.float32],
    cost: NDArray[np.float32],
    goal_cells: NDArray[np.float64],
    seen_cells: NDArray[np.float64],
    indices: NDArray[np.int64],
    least: NDArray[np.float64],
    reach: float,
    own_extent: float,
) -> None:
    """Write the index of the nearest visible goal into every cell within reach of one."""
    rows, cols = cost.shape
    top, left = corner
    nearest = np.full(region.shape, np.inf)
    for k in range(len(goal_cells)):
        goal_row, goal_col = goal_cells[k]
        for r in range(max(int(goal_row - reach), 0), min(int(goal_row + reach) + 1, rows)):
            for c in range(max(int(goal_col - reach), 0), min(int(goal_col + reach) + 1, cols)):
                distance = np.sqrt((r + 0.5 - goal_row) ** 2 + (c + 0.5 - goal_col) ** 2)
                if distance > reach or distance < least[k] or np.isinf(cost[r, c]):
                    continue
                if distance >= nearest[r - top, c - left]:
                    continue
                front_row, front_col = seen_cells[k]
                if clear_line(clearance, r + 0.5, c + 0.5, front_row, front_col, own_extent):
                    nearest[r - top, c - left] = distance
                    region[r - top, c - left] = indices[k]
