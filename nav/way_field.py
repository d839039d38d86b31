"""Ways from the robot to everywhere: one field that says what it costs to go to any place.

It is Dijkstra's on the planner's graph, so a cost is that of the path that `nav.astar.plan` finds.
Where the robot stays in its cell while the map changes, the field is mended (Ramalingam and Reps
1996): ways through cells that became dearer are taken back, and cheaper ones spread. A robot in
another cell needs a new field, which takes 25 times as long (9 ms on 340 x 400 cells).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from nav.astar import with_escape
from nav.costmap import Costmap
from nav.goal_region import goal_region
from vizbot.core.types import OccupancyGrid


class WayField:
    """Costs and lengths of the cheapest ways from the robot, as of the last `update`."""

    def __init__(self) -> None:
        self._grid: OccupancyGrid | None = None
        self._price: NDArray[np.float32] = np.zeros((0, 0), np.float32)
        self._start = -1
        self._field = np.zeros(0)
        self._parent: NDArray[np.int32] = np.zeros(0, np.int32)

    def update(self, costmap: Costmap, position: NDArray[np.float64]) -> None:
        """Follow the map and the robot; nothing is done where neither changed.

        Args:
            costmap: Where the robot can be, and at what cost.
            position: (2,) of the robot in `map` [m]; outside the map nothing can be reached.
        """
        grid, cell = costmap.grid, costmap.grid.to_cells(position)
        if not grid.contains(cell):
            self._grid, self._start = None, -1
            return
        price, _ = with_escape(costmap, cell)
        start = int(cell[0]) * price.shape[1] + int(cell[1])
        same_cells = (
            self._grid is not None
            and self._price.shape == price.shape
            and np.array_equal(self._grid.origin, grid.origin)
        )
        before, self._price = self._price, price
        moved = not same_cells or start != self._start
        self._grid, self._start = grid, start
        if not moved and before is price:
            return
        if not moved and before.ravel()[start] == price.ravel()[start]:
            changed = np.flatnonzero(before.ravel() != price.ravel())
            _mend(before, price, grid.resolution, start, changed, self._field, self._parent)
            return
        self._field = np.full(price.size, np.inf)
        self._parent = np.full(price.size, -1, np.int32)
        self._field[start] = 0.0
        seeds = np.array([start])
        _spread(price, grid.resolution, seeds, self._field, self._parent)

    def costs(self, points_xy: NDArray[np.float64], within: float = 0.0) -> NDArray[np.float64]:
        """What the cheapest way to each point costs, in metres of free floor.

        Args:
            points_xy: (N, 2) in `map` [m].
            within: The way may end in any cell with its centre so near to the point [m]; with 0 in
                that of the point alone.

        Returns:
            (N,), inf where no way leads, and outside the map.
        """
        ends = self._ends(points_xy, within)
        costs = np.full(len(ends), np.inf)
        costs[ends >= 0] = self._field[ends[ends >= 0]]
        return costs

    def cost_to_reach(
        self,
        costmap: Costmap,
        goal_xy: NDArray[np.float64],
        within: float,
        extent: float,
        front_xy: NDArray[np.float64] | None = None,
    ) -> float:
        """What the cheapest way costs to where a robot has reached a goal, in metres of free floor.

        A place may be near to a goal and not see it, past a corner: the way to where it does may
        lead elsewhere.

        Args:
            costmap: That of the last `update`.
            goal_xy: (2,) in `map` [m].
            within: Distance from the robot's centre to the goal [m].
            extent: As `own_extent` of `goal_region` [m].
            front_xy: (2,) what must be in sight instead of the goal [m].

        Returns:
            inf where no way leads.
        """
        if self._grid is None:
            return np.inf
        fronts_xy = None if front_xy is None else front_xy[None]
        stops, _ = goal_region(costmap, goal_xy[None], within, extent, fronts_xy).stops()
        cells = stops[:, 0] * self._price.shape[1] + stops[:, 1]
        return float(self._field[cells].min(initial=np.inf))

    def lengths(self, points_xy: NDArray[np.float64], within: float = 0.0) -> NDArray[np.float64]:
        """Lengths (N,) of the ways that `costs` rates [m]; inf where there is none."""
        if self._grid is None:
            return np.full(len(points_xy), np.inf)
        ends = self._ends(points_xy, within)
        return np.asarray(_lengths(ends, self._parent, self._price.shape[1], self._grid.resolution))

    def _ends(self, points_xy: NDArray[np.float64], within: float) -> NDArray[np.int64]:
        """Flat cells (N,) in which the cheapest ways end; -1 where there is none."""
        if self._grid is None:
            return np.full(len(points_xy), -1)
        points = (np.asarray(points_xy, np.float64).reshape(-1, 2) - self._grid.origin)[:, ::-1]
        field = self._field.reshape(self._price.shape)
        resolution = self._grid.resolution
        return np.asarray(_cheapest_cells(points / resolution, within / resolution, field))


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _neighbours(cell: int, rows: int, cols: int) -> NDArray[np.int64]:
    """The eight flat cells (8,) around one, -1 for those outside the map."""
    around, i = np.full(8, -1), 0
    row, col = cell // cols, cell % cols
    for down in range(-1, 2):
        for right in range(-1, 2):
            if down == 0 and right == 0:
                continue
            if 0 <= row + down < rows and 0 <= col + right < cols:
                around[i] = cell + down * cols + right
            i += 1
    return around


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _wait(
    chains: NDArray[np.int32], links: NDArray[np.int32], cell: int, chain: int, old_chain: int
) -> None:
    """Put a flat cell at the head of a chain, out of the one it is in (-1 for none)."""
    before, after = links[cell]
    if old_chain >= 0:
        if before >= 0:
            links[before, 1] = after
        else:
            chains[old_chain] = after
        if after >= 0:
            links[after, 0] = before
    first = chains[chain]
    links[cell, 0], links[cell, 1] = -1, first
    if first >= 0:
        links[first, 0] = cell
    chains[chain] = cell


@njit(  # type: ignore[untyped-decorator]
    "void(f4[:,::1], f8, i8[::1], f8[::1], i4[::1])",
    cache=True,
    nogil=True,
)
def _spread(
    cost: NDArray[np.float32],
    step: float,
    seeds: NDArray[np.int64],
    field: NDArray[np.float64],
    parent: NDArray[np.int32],
) -> None:
    """Dijkstra from flat cells whose values in the field are right.

    Open cells wait in buckets, each as wide as a step on free floor (Dial 1969), half as fast again
    as a heap. A cell that another one of its bucket improves is opened again.
    """
    rows, cols = cost.shape
    half, half_diagonal = step * 0.5, step * np.sqrt(2.0) * 0.5
    dearest = np.float32(0.0)
    for price in cost.ravel():
        if price > dearest and not np.isinf(price):
            dearest = price
    # No step leads farther than around the ring of buckets; each is a chain of cells.
    ring = int(2.0 * half_diagonal * dearest / step) + 2
    chains = np.full(ring, -1, np.int32)
    links = np.empty((len(field), 2), np.int32)
    chain_of = np.full(len(field), -1, np.int32)
    order = seeds[np.argsort(field[seeds])]
    bucket, fed, waiting = 0, 0, 0
    while fed < len(order) or waiting > 0:
        if waiting == 0:
            bucket = int(field[order[fed]] / step)
        chain = bucket % ring
        while fed < len(order) and int(field[order[fed]] / step) <= bucket:
            if chain_of[order[fed]] < 0:
                _wait(chains, links, order[fed], chain, -1)
                chain_of[order[fed]] = chain
                waiting += 1
            fed += 1
        while chains[chain] >= 0:
            cell = chains[chain]
            chains[chain] = links[cell, 1]
            if chains[chain] >= 0:
                links[chains[chain], 0] = -1
            chain_of[cell] = -1
            waiting -= 1
            here, row, col = field[cell], cell // cols, cell % cols
            own = np.float64(cost[row, col])
            for down in range(-1, 2):
                if not 0 <= row + down < rows:
                    continue
                for right in range(-1, 2):
                    if not 0 <= col + right < cols or (down == 0 and right == 0):
                        continue
                    other = cost[row + down, col + right]
                    if np.isinf(other):
                        continue
                    length = half
                    if down != 0 and right != 0:
                        if np.isinf(cost[row + down, col]) or np.isinf(cost[row, col + right]):
                            continue
                        length = half_diagonal
                    there, neighbour = here + length * (own + other), cell + down * cols + right
                    if there < field[neighbour]:
                        field[neighbour] = there
                        parent[neighbour] = cell
                        new_chain = int(there / step) % ring
                        if chain_of[neighbour] != new_chain:
                            waiting += chain_of[neighbour] < 0
                            _wait(chains, links, neighbour, new_chain, chain_of[neighbour])
                            chain_of[neighbour] = new_chain
        bucket += 1


@njit(  # type: ignore[untyped-decorator]
    "void(f4[:,::1], f4[:,::1], f8, i8, i8[::1], f8[::1], i4[::1])",
    cache=True,
    nogil=True,
)
def _mend(
    before: NDArray[np.float32],
    cost: NDArray[np.float32],
    step: float,
    start: int,
    changed: NDArray[np.int64],
    field: NDArray[np.float64],
    parent: NDArray[np.int32],
) -> None:
    """Make the field of the costs `before` that of `cost`, which differ in `changed` flat cells."""
    rows, cols = cost.shape
    lost, is_lost, count = np.empty(len(field), np.int64), np.zeros(len(field), np.bool_), 0
    for cell in changed:
        row, col = cell // cols, cell % cols
        if cost[row, col] < before[row, col]:
            continue
        # Ways into the cell, and those that passed by it over a corner that is closed now.
        for down in range(-1, 2):
            for right in range(-1, 2):
                inside = 0 <= row + down < rows and 0 <= col + right < cols
                other = cell + down * cols + right
                if not inside or is_lost[other] or np.isinf(field[other]) or other == start:
                    continue
                corner = False
                if np.isinf(cost[row, col]) and (down == 0) != (right == 0):
                    source = parent[other]
                    away = abs(source // cols - row) + abs(source % cols - col)
                    slanted = source // cols != row + down and source % cols != col + right
                    corner = away == 1 and slanted
                if other == cell or corner:
                    lost[count], is_lost[other], count = other, True, count + 1
    done = 0
    while done < count:
        cell, done = lost[done], done + 1
        for neighbour in _neighbours(cell, rows, cols):
            if neighbour >= 0 and parent[neighbour] == cell and not is_lost[neighbour]:
                lost[count], is_lost[neighbour], count = neighbour, True, count + 1
    for cell in lost[:count]:
        field[cell], parent[cell] = np.inf, -1
    is_seed = np.zeros(len(field), np.bool_)
    for cells in (changed, lost[:count]):
        for cell in cells:
            is_seed[cell] = not np.isinf(field[cell])
            for neighbour in _neighbours(cell, rows, cols):
                if neighbour >= 0 and not np.isinf(field[neighbour]):
                    is_seed[neighbour] = True
    _spread(cost, step, np.flatnonzero(is_seed), field, parent)


@njit(  # type: ignore[untyped-decorator]
    "i8[::1](f8[:,:], f8, f8[:,::1])",
    cache=True,
    nogil=True,
)
def _cheapest_cells(
    points: NDArray[np.float64], within: float, field: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Flat cells (N,) of the least value around points (N, 2) row, col; -1 where all are inf."""
    rows, cols = field.shape
    found = np.full(len(points), -1)
    for k in range(len(points)):
        row, col = points[k]
        least = np.inf
        reach = int(np.ceil(within))
        for r in range(
            max(int(np.floor(row)) - reach, 0), min(int(np.floor(row)) + reach + 1, rows)
        ):
            for c in range(
                max(int(np.floor(col)) - reach, 0), min(int(np.floor(col)) + reach + 1, cols)
            ):
                own = r == int(np.floor(row)) and c == int(np.floor(col))
                near = (r + 0.5 - row) ** 2 + (c + 0.5 - col) ** 2 <= within**2
                if (own or near) and field[r, c] < least:
                    least, found[k] = field[r, c], r * cols + c
    return found


@njit(  # type: ignore[untyped-decorator]
    "f8[::1](i8[::1], i4[::1], i8, f8)",
    cache=True,
    nogil=True,
)
def _lengths(
    ends: NDArray[np.int64], parent: NDArray[np.int32], cols: int, step: float
) -> NDArray[np.float64]:
    """Lengths (N,) of the ways to flat cells; inf for those below 0."""
    lengths = np.full(len(ends), np.inf)
    for k in range(len(ends)):
        cell = ends[k]
        if cell < 0:
            continue
        straight, slanted = 0, 0
        while parent[cell] >= 0:
            before = parent[cell]
            if before // cols != cell // cols and before % cols != cell % cols:
                slanted += 1
            else:
                straight += 1
            cell = before
        lengths[k] = step * (straight + np.sqrt(2.0) * slanted)
    return lengths
