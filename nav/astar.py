"""Multi-goal A* on a costmap (paper, section C): the cheapest path to the cheapest of many goals.

The robot moves between the centres of neighbouring cells (8-connected); an edge costs its length
times the mean cost of its two cells. A diagonal needs both cells beside it passable, so no corner
is cut. The heuristic is the exact distance on an empty map of the cheapest floor to the nearest
goal, terminal cost included, for the whole set of goals at once: two sweeps over the grid, and the
search runs to the best goal almost straight. It is consistent, so the result equals Dijkstra's.

Sweeps and search take place in a window around the start and the goals near enough to matter. When
the search reaches the end of its window it goes on in a larger one. So a way across a room costs
what the room costs, however large the map is, and the path is the one of the whole map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nav.costmap import Costmap, way_out
from nav.heap import sift_down, sift_up
from vizbot.core.program.kernels import kernel

ESCAPE_RADIUS = 0.35
"""Distance that a robot too near to an obstacle may drive before it must be clear of it [m]."""

ESCAPE_COST = 20.0
"""Cost of a metre there: more than any other, so that the path out is short."""

_GOAL = 16
"""Bit of a cell's move that marks a goal."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A path to one of the goals.

    Attributes:
        xy: (P, 2) float64 cell centres in `map` [m], from the start's cell to the goal's.
        cost: Of the path, the goal's own cost included.
        goal: Index of the goal reached.
    """

    xy: NDArray[np.float64]
    cost: float
    goal: int


def plan(
    costmap: Costmap,
    start_xy: NDArray[np.float64],
    goals_xy: NDArray[np.float64],
    goal_costs: NDArray[np.float64] | None = None,
) -> Path | None:
    """Find the cheapest path from `start_xy` to any of `goals_xy`.

    A robot may stand nearer to an obstacle than the map allows, after a bump or when the map has
    moved. It may then cross cells that are closed only by inflation, no farther than ESCAPE_RADIUS
    from the start and no nearer to an obstacle than it already is, at ESCAPE_COST a metre. Out of a
    keep-out zone it may drive however far that is, and no deeper in; no goal lies in one.

    Args:
        costmap: Where the robot can be, and at what cost.
        start_xy: (2,) in `map` [m].
        goals_xy: (N, 2) in `map` [m]; goals outside the map or where the robot cannot be are
            ignored.
        goal_costs: (N,) 0 or more, added to the cost of the path to each goal; None adds nothing.

    Returns:
        None when no goal can be reached, or the start is outside the map.
    """
    start = costmap.grid.to_cells(start_xy)
    if not costmap.grid.contains(start):
        return None
    cost, least = with_escape(costmap, start)
    goals = costmap.grid.to_cells(np.asarray(goals_xy, np.float64).reshape(-1, 2))
    terminal = np.zeros(len(goals)) if goal_costs is None else np.asarray(goal_costs, np.float64)
    if (closed := costmap.closed) is not None:
        inside = np.flatnonzero(costmap.grid.contains(goals))
        terminal = terminal.copy()
        terminal[inside[closed[tuple(goals[inside].T)]]] = np.inf
    total, goal = np.zeros(1), np.zeros(1, np.int64)
    cells = _plan(
        cost, least, costmap.grid.resolution, (int(start[0]), int(start[1])), goals, terminal,
        total, goal,
    )  # fmt: skip
    if goal[0] < 0:
        return None
    return Path(costmap.grid.to_xy(cells), float(total[0]), int(goal[0]))


def exits(
    costmap: Costmap, distant_xy: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Goals for `plan` towards a point far outside the map (the paper's g_distant, to explore).

    Everything outside is unknown and open, so the path there from a cell on the border that faces
    the point is the straight line at the cost of unknown floor. With each such cell as a goal of
    that cost, the result is the same as on a map that reaches as far as the point. The map needs a
    frame of unknown cells for paths around its outside.

    Returns:
        (N, 2) centres in `map` [m] of the border cells, and (N,) the cost from each to the point;
        the point itself at no cost when it lies in the map.
    """
    rows, cols = costmap.cost.shape
    row, col = costmap.grid.to_cells(distant_xy)
    if 0 <= row < rows and 0 <= col < cols:
        return distant_xy[None], np.zeros(1)
    facing = np.zeros((rows, cols), bool)
    facing[0] |= row < 0
    facing[-1] |= row >= rows
    facing[:, 0] |= col < 0
    facing[:, -1] |= col >= cols
    exits_xy = costmap.grid.to_xy(np.argwhere(facing))
    return exits_xy, costmap.config.unknown_cost * np.linalg.norm(exits_xy - distant_xy, axis=1)


def with_escape(costmap: Costmap, start: NDArray[np.int64]) -> tuple[NDArray[np.float32], float]:
    """Open a path out for a robot whose cell is closed, as `plan` says.

    Args:
        costmap: Where the robot can be.
        start: (2,) row and column of the robot, in the map.

    Returns:
        The costs (rows, cols) of a metre, and the least of them.
    """
    row, col = int(start[0]), int(start[1])
    if np.isfinite(costmap.cost[row, col]):
        return costmap.cost, costmap.least
    cost = costmap.cost.copy()
    reach = int(ESCAPE_RADIUS / costmap.grid.resolution)
    around = np.s_[max(row - reach, 0) : row + reach + 1, max(col - reach, 0) : col + reach + 1]
    clearance = costmap.clearance[around]
    rows, cols = np.indices(clearance.shape) + np.array([[[around[0].start]], [[around[1].start]]])
    near = np.hypot(rows - row, cols - col) <= reach
    # With its centre on an obstacle the robot is not where the map says: any free cell will do.
    fits = (clearance >= costmap.clearance[row, col]) & (clearance > 0)
    opened = np.zeros(cost.shape, bool)
    opened[around] = near & fits
    closed = costmap.closed
    if closed is not None:
        opened &= ~closed
        if closed[row, col]:
            out = way_out(closed, (row, col), costmap.grid.resolution)
            opened |= out & (costmap.clearance > costmap.config.closed_radius)
    cost[opened & np.isinf(cost)] = ESCAPE_COST
    cost[row, col] = ESCAPE_COST
    return cost, min(costmap.least, ESCAPE_COST)


@kernel()
def _estimate(
    field: NDArray[np.float64],
    goals: NDArray[np.int64],
    goal_costs: NDArray[np.float64],
    corner: tuple[int, int],
    step: float,
) -> None:
    """Least of goal cost plus 8-connected distance over all goals, on an empty map.

    Two sweeps are exact: a shortest path uses two neighbouring directions in any order, and on a
    full rectangle those that one sweep carries can all go first. The outer ring stays inf.
    """
    rows, cols = field.shape
    first, last, edge = rows, 0, 0
    for k in range(len(goals)):
        row, col = goals[k, 0] - corner[0], goals[k, 1] - corner[1]
        field[row, col] = min(field[row, col], goal_costs[k])
        first, last, edge = min(first, row), max(last, row), max(edge, row + col)
    diagonal = step * np.sqrt(2.0)
    for r in range(first, rows - 1):
        left = np.inf
        for c in range(1, cols - 1):
            straight = min(field[r, c], field[r - 1, c] + step)
            slant = min(field[r - 1, c - 1], field[r - 1, c + 1]) + diagonal
            left = min(min(straight, slant), left + step)
            field[r, c] = left
    for r in range(rows - 2, 0, -1):
        # Below all goals, the first sweep has come to all cells but those far on the left.
        end = cols - 2 if r < last else min(cols - 2, max(edge - r, 0))
        right = field[r, end + 1]
        for c in range(end, 0, -1):
            straight = min(field[r, c], field[r + 1, c] + step)
            slant = min(field[r + 1, c - 1], field[r + 1, c + 1]) + diagonal
            right = min(min(straight, slant), right + step)
            field[r, c] = right


@kernel()
def _search(
    cost: NDArray[np.float32],
    step: float,
    corner: tuple[int, int],
    inner: tuple[int, int, int, int],
    goals: NDArray[np.int64],
    goal_costs: NDArray[np.float64],
    estimate: NDArray[np.float64],
    move: NDArray[np.uint8],
    reached: NDArray[np.float64],
    width: int,
    keys: NDArray[np.float64],
    cells: NDArray[np.int32],
    size: int,
    total: float,
    goal: int,
) -> tuple[NDArray[np.float64], NDArray[np.int32], int, float, int]:
    """A* on flat cells of a window whose first cell is the cell `corner` of the map.

    Returns:
        The heap, its size, the cost and the index of the goal (-1 for none), once they are final or
        the next cell lies outside `inner` (its first and last row and column).
    """
    rows, cols = cost.shape
    # Unsigned indices spare the compiled code a test for those that count from the end.
    prices = cost.ravel()
    half, half_diagonal = step * 0.5, step * np.sqrt(2.0) * 0.5
    while size > 0 and keys[0] < total:
        key, cell = keys[0], cells[0]
        row, col = cell // width + corner[0], cell % width + corner[1]
        if row < inner[0] or row > inner[2] or col < inner[1] or col > inner[3]:
            break
        size -= 1
        sift_down(keys, cells, size, keys[size], cells[size])
        here = reached[cell]
        if key > here + estimate[cell]:
            continue
        if move[cell] >= _GOAL:
            best = _cheapest_in(goals, goal_costs, row, col)
            if here + goal_costs[best] < total:
                total, goal = here + goal_costs[best], best
        if size + 8 > len(keys):
            keys = np.concatenate((keys, np.empty_like(keys)))
            cells = np.concatenate((cells, np.empty_like(cells)))
        flat = row * cols + col
        own = np.float64(prices[np.uintp(flat)])
        for down in range(-1, 2):
            if not 0 <= row + down < rows:
                continue
            for right in range(-1, 2):
                if not 0 <= col + right < cols or (down == 0 and right == 0):
                    continue
                other = prices[np.uintp(flat + down * cols + right)]
                if other == np.inf:
                    continue
                length = half
                if down != 0 and right != 0:
                    below, beside = np.uintp(flat + down * cols), np.uintp(flat + right)
                    if prices[below] == np.inf or prices[beside] == np.inf:
                        continue
                    length = half_diagonal
                there = here + length * (own + other)
                neighbour = np.uintp(cell + down * width + right)
                mark = move[neighbour] & _GOAL
                if move[neighbour] == mark or there < reached[neighbour]:
                    reached[neighbour] = there
                    move[neighbour] = mark + 3 * down + right + 5
                    sift_up(keys, cells, size, there + estimate[neighbour], np.int32(neighbour))
                    size += 1
    return keys, cells, size, total, goal


@kernel()
def _cheapest_in(
    goals: NDArray[np.int64], goal_costs: NDArray[np.float64], row: int, col: int
) -> int:
    """Index of the cheapest goal in a cell, the last one among equals."""
    best, least = -1, np.inf
    for k in range(len(goals)):
        if goals[k, 0] == row and goals[k, 1] == col and goal_costs[k] <= least:
            best, least = k, goal_costs[k]
    return best


@kernel()
def _way_back(
    move: NDArray[np.uint8],
    corner: tuple[int, int],
    start: tuple[int, int],
    goal: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Cells (P, 2) of the map from the start to a goal, by the moves that led there."""
    backwards = np.empty((64, 2), np.int64)
    count, row, col = 0, goal[0], goal[1]
    while True:
        if count == len(backwards):
            backwards = np.concatenate((backwards, np.empty_like(backwards)))
        backwards[count] = row, col
        count += 1
        if row == start[0] and col == start[1]:
            return backwards[:count][::-1].copy()
        back = np.int64(move[row - corner[0], col - corner[1]] & (_GOAL - 1)) - 1
        row, col = row - (back // 3 - 1), col - (back % 3 - 1)


# A kernel returns no tuple with arrays: an interrupt while numba wraps one ends in a crash.
@kernel("i8[:,::1](f4[:,::1], f8, f8, UniTuple(i8, 2), i8[:,:], f8[::1], f8[::1], i8[::1])")
def _plan(
    cost: NDArray[np.float32],
    least: float,
    step: float,
    start: tuple[int, int],
    goals: NDArray[np.int64],
    goal_costs: NDArray[np.float64],
    total_out: NDArray[np.float64],
    goal_out: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Search in windows, each larger than the last, until the path cannot lead outside.

    Returns:
        The cells (P, 2) of the path; its cost and the index of its goal (-1 for none) are written
        to the last two arguments, (1,) each.
    """
    total_out[0], goal_out[0] = np.inf, -1
    rows, cols = cost.shape
    slant, unit = np.sqrt(2.0) - 1.0, step * least
    bounds = np.full(len(goals), np.inf)
    nearest, away = np.inf, 0.0
    for k in range(len(goals)):
        row, col = goals[k]
        if 0 <= row < rows and 0 <= col < cols and not np.isinf(cost[row, col]):
            down, right = abs(row - start[0]), abs(col - start[1])
            distance = max(down, right) + slant * min(down, right)
            bounds[k] = goal_costs[k] + distance * unit
            if bounds[k] < nearest:
                nearest, away = bounds[k], distance
    if nearest == np.inf:
        return np.empty((0, 2), np.int64)
    corner, width, total, goal = (start[0], start[1]), 1, np.inf, -1
    # By which move, 1 to 9, each cell was reached; 0 for those that were not.
    move, reached = np.full((1, 1), 5, np.uint8), np.zeros((1, 1))
    keys, cells, size = np.empty(1024), np.zeros(1024, np.int32), 1
    keys[0] = 0.0
    margin = 4 + int(away) // 8
    while True:
        # The goals left out are the nearest of no cell within `reach` on an empty map: an estimate
        # differs from that at the start by the way between them, at most 1.42 times the reach.
        reach = int(away) + 1 + margin
        chosen = np.flatnonzero(bounds <= nearest + (3.0 * reach + 3.0) * unit)
        near = goals[chosen]
        low_row, high_row = near[:, 0].min(), near[:, 0].max()
        low_col, high_col = near[:, 1].min(), near[:, 1].max()
        inner = (
            max(min(low_row, start[0]) - margin, start[0] - reach, 0),
            max(min(low_col, start[1]) - margin, start[1] - reach, 0),
            min(max(high_row, start[0]) + margin, start[0] + reach, rows - 1),
            min(max(high_col, start[1]) + margin, start[1] + reach, cols - 1),
        )
        top, left = max(min(inner[0] - 1, low_row), 0), max(min(inner[1] - 1, low_col), 0)
        bottom = min(max(inner[2] + 1, high_row), rows - 1)
        right_end = min(max(inner[3] + 1, high_col), cols - 1)
        down, right = corner[0] - (top - 1), corner[1] - (left - 1)
        corner = (top - 1, left - 1)
        height, old_width, width = bottom - top + 3, width, right_end - left + 3
        to_go = np.full((height, width), np.inf)
        _estimate(to_go, near, goal_costs[chosen], corner, unit)
        # The search goes on where it was.
        before, move, far = move, np.zeros((height, width), np.uint8), reached
        reached = np.empty((height, width))
        move[down : down + before.shape[0], right : right + before.shape[1]] = before
        reached[down : down + before.shape[0], right : right + before.shape[1]] = far
        for i in range(size):
            cells[i] = (cells[i] // old_width + down) * width + cells[i] % old_width + right
        for k in range(len(goals)):
            row, col = goals[k, 0] - corner[0], goals[k, 1] - corner[1]
            if bounds[k] < np.inf and 0 < row < height - 1 and 0 < col < width - 1:
                move[row, col] |= _GOAL
        keys, cells, size, total, goal = _search(
            cost, step, corner, inner, goals, goal_costs, to_go.ravel(), move.ravel(),
            reached.ravel(), width, keys, cells, size, total, goal,
        )  # fmt: skip
        if size == 0 or keys[0] >= total:
            break
        margin *= 3
    if goal < 0:
        return np.empty((0, 2), np.int64)
    total_out[0], goal_out[0] = total, goal
    way: NDArray[np.int64] = _way_back(move, corner, start, goals[goal])
    return way
