"""Ways from the robot to everywhere: one field that says what it costs to go to any place.

It is Dijkstra's on the planner's graph, so a cost is that of the path that `nav.astar.plan` finds.
It spreads from the robot only as far as the points that are asked for, and goes on for farther
ones: unknown cells count as open, so most of a map lies beyond them (1 ms up to 8 m of way on 340 x
340 cells, 5 ms to the last of them).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nav.astar import with_escape
from nav.costmap import Costmap
from nav.goal_region import clear_line
from vizbot.core.program.kernels import kernel
from vizbot.core.types import OccupancyGrid

_NEAR = 4.0
"""Cost up to which the field spreads at first, where no point that is asked for was reached [m]."""


class WayField:
    """Costs of the cheapest ways from the robot, as of the last `update`."""

    def __init__(self) -> None:
        self._grid: OccupancyGrid | None = None
        self._price: NDArray[np.float32] = np.zeros((0, 0), np.float32)
        self._start = -1
        self._spreading = _Spreading(self._price, 1.0, None)

    def update(self, costmap: Costmap, position: NDArray[np.float64]) -> None:
        """Follow the map and the robot; nothing is done where neither changed.

        From a `position` (2,) in `map` [m] outside of it nothing can be reached.
        """
        grid, cell = costmap.grid, costmap.grid.to_cells(position)
        if not grid.contains(cell):
            self._grid, self._start = None, -1
            return
        price, _ = with_escape(costmap, cell)
        start = int(cell[0]) * price.shape[1] + int(cell[1])
        same = (
            self._grid is not None
            and start == self._start
            and np.array_equal(self._grid.origin, grid.origin)
            and (price is self._price or np.array_equal(price, self._price))
        )
        self._grid, self._start, self._price = grid, start, price
        if not same:
            self._spreading = _Spreading(price, grid.resolution, cell)

    def costs(self, points_xy: NDArray[np.float64], within: float = 0.0) -> NDArray[np.float64]:
        """What the cheapest way to each point costs, in metres of free floor.

        Args:
            points_xy: (N, 2) in `map` [m].
            within: The way may end in any cell with its centre so near to the point [m]; with 0 in
                that of the point alone.

        Returns:
            (N,), inf where no way leads, and outside the map.
        """
        if self._grid is None:
            return np.full(len(points_xy), np.inf)
        resolution = self._grid.resolution
        points = (np.asarray(points_xy, np.float64).reshape(-1, 2) - self._grid.origin)[:, ::-1]
        points /= resolution
        while True:
            costs = np.asarray(_least_around(points, within / resolution, self._spreading.field))
            if not self._spreading.goes_beyond(costs):
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

        A point may be near a goal without seeing it, past a corner; the way to a point that sees it
        may lead elsewhere.

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
        origin, resolution = self._grid.origin, self._grid.resolution
        goal, seen = (
            (xy - origin)[::-1] / resolution
            for xy in (goal_xy, goal_xy if front_xy is None else front_xy)
        )
        reach, own = within / resolution, extent / resolution
        while True:
            field = self._spreading.field
            cost = _least_in_sight(field, costmap.clearance, costmap.cost, goal, seen, reach, own)
            if not self._spreading.goes_beyond(np.array([cost])):
                return float(cost)


class _Spreading:
    """A field that has spread from a cell up to some cost.

    Attributes:
        field: (rows, cols) what the cheapest way to each cell costs [m]: final below `_settled`,
            no less than that beyond.
    """

    def __init__(
        self, price: NDArray[np.float32], resolution: float, start: NDArray[np.int64] | None
    ) -> None:
        rows, cols = price.shape
        self._resolution, self._settled = resolution, 0.0
        self._price = np.full((rows + 2, cols + 2), np.inf, np.float32)
        self._price[1:-1, 1:-1] = price
        self._values = np.full(self._price.size, np.inf)
        self.field = self._values.reshape(self._price.shape)[1:-1, 1:-1]
        # No step leads farther than around the ring of buckets; each is a chain of cells.
        dearest = float(np.max(price, where=price < np.inf, initial=1.0))
        self._chains = np.full(int(np.sqrt(2.0) * dearest) + 3, -1, np.int32)
        self._chain_of = np.full(self._price.size, -1, np.int32)
        self._links = np.full((self._price.size, 2), -1, np.int32)
        self._waiting = 0
        if start is not None:
            cell = (int(start[0]) + 1) * (cols + 2) + int(start[1]) + 1
            self._values[cell] = 0.0
            self._chains[0], self._chain_of[cell], self._waiting = cell, 0, 1
        self._bucket = 0

    def goes_beyond(self, costs: NDArray[np.float64]) -> bool:
        """Spread on while one of these costs may still fall; return whether it did."""
        dearest = float(costs.max(initial=0.0))
        if self._waiting == 0 or dearest < self._settled:
            return False
        limit = dearest if dearest < np.inf else max(1.25 * self._settled, _NEAR)
        # At the rim of what is settled the division may round down to the bucket before.
        last = max(int(limit / self._resolution), self._bucket)
        self._waiting = _spread(
            self._price.ravel(), self._price.shape[1], self._resolution, self._bucket, last,
            self._waiting, self._values, self._chains, self._chain_of, self._links,
        )  # fmt: skip
        self._bucket = last + 1
        self._settled = self._bucket * self._resolution
        return True


@kernel()
def _wait(
    chains: NDArray[np.int32], links: NDArray[np.int32], cell: int, chain: int, old_chain: int
) -> None:
    """Put a flat cell at the head of a chain, out of the one it is in (-1 for none)."""
    if old_chain >= 0:
        before, after = links[cell]
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


@kernel("i8(f4[::1], i8, f8, i8, i8, i8, f8[::1], i4[::1], i4[::1], i4[:,::1])")
def _spread(
    price: NDArray[np.float32],
    cols: int,
    step: float,
    bucket: int,
    last: int,
    waiting: int,
    field: NDArray[np.float64],
    chains: NDArray[np.int32],
    chain_of: NDArray[np.int32],
    links: NDArray[np.int32],
) -> int:
    """Dijkstra, from one bucket to a last one, on flat cells with a border that is closed.

    Open cells wait in buckets, each as wide as a step on free floor (Dial 1969), half as fast again
    as a heap. A cell that another one of its bucket improves is opened again.

    Returns:
        The number of cells that wait then.
    """
    half, half_diagonal, per_step = step * 0.5, step * np.sqrt(2.0) * 0.5, 1.0 / step
    while waiting > 0 and bucket <= last:
        chain = bucket % len(chains)
        while chains[chain] >= 0:
            cell = chains[chain]
            chains[chain] = links[cell, 1]
            if chains[chain] >= 0:
                links[chains[chain], 0] = -1
            chain_of[cell] = -1
            waiting -= 1
            here, own = field[cell], np.float64(price[cell])
            for down in (-cols, 0, cols):
                for right in (-1, 0, 1):
                    neighbour = cell + down + right
                    other = price[neighbour]
                    if other == np.inf or neighbour == cell:
                        continue
                    length = half
                    if down != 0 and right != 0:
                        if price[cell + down] == np.inf or price[cell + right] == np.inf:
                            continue
                        length = half_diagonal
                    there = here + length * (own + other)
                    if there < field[neighbour]:
                        field[neighbour] = there
                        new_chain = int(there * per_step) % len(chains)
                        if chain_of[neighbour] != new_chain:
                            waiting += chain_of[neighbour] < 0
                            _wait(chains, links, neighbour, new_chain, chain_of[neighbour])
                            chain_of[neighbour] = new_chain
        bucket += 1
    return waiting


@kernel("f8[::1](f8[:,:], f8, f8[:,:])")
def _least_around(
    points: NDArray[np.float64], within: float, field: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The least value (N,) around each of points (N, 2) row, col; inf where all are."""
    rows, cols = field.shape
    least, reach = np.full(len(points), np.inf), int(np.ceil(within))
    for k in range(len(points)):
        row, col = points[k]
        own_row, own_col = int(np.floor(row)), int(np.floor(col))
        for r in range(max(own_row - reach, 0), min(own_row + reach + 1, rows)):
            for c in range(max(own_col - reach, 0), min(own_col + reach + 1, cols)):
                near = (r + 0.5 - row) ** 2 + (c + 0.5 - col) ** 2 <= within**2
                if near or (r == own_row and c == own_col):
                    least[k] = min(least[k], field[r, c])
    return least


@kernel("f8(f8[:,:], f4[:,::1], f4[:,::1], f8[:], f8[:], f8, f8)")
def _least_in_sight(
    field: NDArray[np.float64],
    clearance: NDArray[np.float32],
    cost: NDArray[np.float32],
    goal: NDArray[np.float64],
    seen: NDArray[np.float64],
    reach: float,
    own_extent: float,
) -> float:
    """The least value in the cells of a `nav.goal_region` of one goal; inf where all are.

    Args:
        field: (rows, cols) the values.
        clearance: (rows, cols) as of the costmap.
        cost: (rows, cols) as of the costmap.
        goal: (2,) row, col of the goal.
        seen: (2,) row, col of what must be in sight.
        reach: Distance to the goal [cells].
        own_extent: Extent of the goal [cells].
    """
    rows, cols = field.shape
    row, col = goal
    least = np.inf
    for r in range(max(int(row - reach), 0), min(int(row + reach) + 1, rows)):
        for c in range(max(int(col - reach), 0), min(int(col + reach) + 1, cols)):
            if field[r, c] >= least or cost[r, c] == np.inf:
                continue
            if np.sqrt((r + 0.5 - row) ** 2 + (c + 0.5 - col) ** 2) > reach:
                continue
            if clear_line(clearance, r + 0.5, c + 0.5, seen[0], seen[1], own_extent):
                least = field[r, c]
    return least
