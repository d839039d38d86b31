"""Multi-goal A* on a costmap (paper, section C): the cheapest path to the cheapest of many goals.

The robot moves between the centres of neighbouring cells (8-connected); an edge costs its length
times the mean cost of its two cells. A diagonal needs both cells beside it passable, so no corner
is cut. The heuristic is the exact distance on an empty map of the cheapest floor to the nearest
goal, terminal cost included, for the whole set of goals at once: two sweeps over the grid, and the
search runs to the best goal almost straight. It is consistent, so the result equals Dijkstra's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from nav.costmap import Costmap
from nav.keep_out import way_out

ESCAPE_RADIUS = 0.35
"""Distance that a robot too near to an obstacle may drive before it must be clear of it [m]."""

ESCAPE_COST = 20.0
"""Cost of a metre there: more than any other, so that the path out is short."""


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
    cost = _with_escape(costmap, start)
    goals = costmap.grid.to_cells(np.asarray(goals_xy, np.float64).reshape(-1, 2))
    terminal_costs = np.zeros(len(goals)) if goal_costs is None else goal_costs
    reachable = np.flatnonzero(costmap.grid.contains(goals))
    reachable = reachable[np.isfinite(cost[tuple(goals[reachable].T)])]
    if costmap.closed is not None:
        reachable = reachable[~costmap.closed[tuple(goals[reachable].T)]]
    if not len(reachable):
        return None
    # The cheapest goal of each cell is written last, and stays.
    reachable = reachable[np.argsort(-terminal_costs[reachable], kind="stable")]
    rows, cols = goals[reachable].T
    goal_of = np.full(cost.shape, -1, np.int64)
    goal_of[rows, cols] = reachable
    # A closed ring around the map spares the search every test for its border.
    terminal = np.full((cost.shape[0] + 2, cost.shape[1] + 2), np.inf)
    terminal[rows + 1, cols + 1] = terminal_costs[reachable]
    width = terminal.shape[1]
    step = costmap.grid.resolution
    total, way = _search(
        np.pad(cost, 1, constant_values=np.inf).ravel(),
        width,
        int(start[0] + 1) * width + int(start[1]) + 1,
        terminal.ravel(),
        _distance_to_goals(terminal, float(cost.min()) * step).ravel(),
        step,
    )
    if not len(way):
        return None
    cells = np.stack(np.divmod(way, width), axis=1) - 1
    return Path(costmap.grid.to_xy(cells), total, int(goal_of[tuple(cells[-1])]))


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


def _with_escape(costmap: Costmap, start: NDArray[np.int64]) -> NDArray[np.float32]:
    """The costs, with a path out opened where the start cell is closed."""
    row, col = int(start[0]), int(start[1])
    if np.isfinite(costmap.cost[row, col]):
        return costmap.cost
    cost = costmap.cost.copy()
    reach = int(ESCAPE_RADIUS / costmap.grid.resolution)
    around = np.s_[max(row - reach, 0) : row + reach + 1, max(col - reach, 0) : col + reach + 1]
    rows, cols = np.mgrid[around]
    near = np.hypot(rows - row, cols - col) <= reach
    clearance = costmap.clearance[around]
    # With its centre on an obstacle the robot is not where the map says: any free cell will do.
    fits = (clearance >= costmap.clearance[row, col]) & (clearance > 0)
    opened = np.zeros(cost.shape, bool)
    opened[around] = near & fits
    if costmap.closed is not None:
        opened &= ~costmap.closed
        if costmap.closed[row, col]:
            out = way_out(costmap.closed, (row, col), costmap.grid.resolution)
            opened |= out & (costmap.clearance > costmap.config.closed_radius)
    cost[opened & np.isinf(cost)] = ESCAPE_COST
    cost[row, col] = ESCAPE_COST
    return cost


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _distance_to_goals(terminal: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Least of terminal cost plus 8-connected distance over all goals, on an empty map.

    Two sweeps are exact: a shortest path uses two neighbouring directions in any order, and on a
    full rectangle those that one sweep carries can all go first. The outer ring stays inf.
    """
    field = terminal.copy()
    rows, cols = field.shape
    diagonal = step * np.sqrt(2.0)
    for r in range(1, rows - 1):
        for c in range(1, cols - 1):
            best = min(field[r - 1, c], field[r, c - 1]) + step
            slant = min(field[r - 1, c - 1], field[r - 1, c + 1]) + diagonal
            field[r, c] = min(field[r, c], best, slant)
    for r in range(rows - 2, 0, -1):
        for c in range(cols - 2, 0, -1):
            best = min(field[r + 1, c], field[r, c + 1]) + step
            slant = min(field[r + 1, c - 1], field[r + 1, c + 1]) + diagonal
            field[r, c] = min(field[r, c], best, slant)
    return field


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _search(
    cost: NDArray[np.float32],
    width: int,
    start: int,
    terminal: NDArray[np.float64],
    to_go: NDArray[np.float64],
    step: float,
) -> tuple[float, NDArray[np.int64]]:
    """A* over flat cells with a closed outer ring; the path is empty when there is none."""
    reached = np.full(len(cost), np.inf)
    parent = np.full(len(cost), -1, np.int32)
    keys, cells = np.empty(1024), np.empty(1024, np.int32)
    keys[0], cells[0], size = to_go[start], start, 1
    reached[start] = 0.0
    total, goal = np.inf, -1
    while size > 0 and keys[0] < total:
        key, cell = keys[0], cells[0]
        size -= 1
        _sift_down(keys, cells, size, keys[size], cells[size])
        here = reached[cell]
        if key > here + to_go[cell]:
            continue
        if here + terminal[cell] < total:
            total, goal = here + terminal[cell], cell
        if size + 8 > len(keys):
            keys = np.concatenate((keys, np.empty_like(keys)))
            cells = np.concatenate((cells, np.empty_like(cells)))
        for row_step in range(-1, 2):
            for col_step in range(-1, 2):
                neighbour = cell + row_step * width + col_step
                if neighbour == cell or np.isinf(cost[neighbour]):
                    continue
                length = step
                if row_step != 0 and col_step != 0:
                    beside = cost[cell + row_step * width] + cost[cell + col_step]
                    if np.isinf(beside):
                        continue
                    length *= np.sqrt(2.0)
                there = here + length * 0.5 * (np.float64(cost[cell]) + cost[neighbour])
                if there < reached[neighbour]:
                    reached[neighbour] = there
                    parent[neighbour] = cell
                    _sift_up(keys, cells, size, there + to_go[neighbour], neighbour)
                    size += 1
    count, cell = 0, goal
    while cell >= 0:
        count, cell = count + 1, parent[cell]
    way = np.empty(count, np.int64)
    cell = goal
    for i in range(count - 1, -1, -1):
        way[i] = cell
        cell = parent[cell]
    return total, way


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _sift_up(
    keys: NDArray[np.float64], cells: NDArray[np.int32], at: int, key: float, cell: int
) -> None:
    """Put an entry at the free end `at` of the binary heap and let it rise to its place."""
    while at > 0:
        above = (at - 1) // 2
        if keys[above] <= key:
            break
        keys[at], cells[at] = keys[above], cells[above]
        at = above
    keys[at], cells[at] = key, cell


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _sift_down(
    keys: NDArray[np.float64], cells: NDArray[np.int32], size: int, key: float, cell: int
) -> None:
    """Put an entry at the free top of a binary heap of `size` and let it sink to its place."""
    at = 0
    while True:
        below = 2 * at + 1
        if below >= size:
            break
        if below + 1 < size and keys[below + 1] < keys[below]:
            below += 1
        if keys[below] >= key:
            break
        keys[at], cells[at] = keys[below], cells[below]
        at = below
    keys[at], cells[at] = key, cell
