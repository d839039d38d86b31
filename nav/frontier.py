"""Exploration from frontier to frontier (Yamauchi 1997), on the area that the camera explored.

A frontier is a border between the explored area and the rest of the map. The robot drives to the
cheapest one: near, rather ahead than behind, and with a large area to see behind it, so that a door
comes before a corner. A frontier that persists when the robot stands before it and faces it cannot
be resolved, and is given up.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from nav.config import CostmapConfig, FrontierConfig, NavigatorConfig, Reach
from nav.costmap import Costmap
from nav.explored_area import BLOCKING, ExploredArea
from nav.navigator import GoalPoints, Navigation, navigate
from vizbot.core.geometry import wrap_angle, yaw_of
from vizbot.core.program.kernels import kernel
from vizbot.core.types import SE3, OccupancyGrid

_CELLS_PER_POINT = 3
"""Number of cells of a frontier that share a point."""


def frontiers(
    grid: OccupancyGrid, explored: NDArray[np.bool_], costmap: CostmapConfig, min_length: float
) -> list[NDArray[np.float64]]:
    """Find the borders between explored open cells and unexplored ones.

    A frontier is at least `min_length` long [m]; `explored` (rows, cols) masks the explored cells.

    Returns:
        Points (N, 2) x, y in `map` [m] along each frontier, the nearest to its middle first.
    """
    seen = explored & (grid.occupancy < BLOCKING)
    unseen = ~explored & (grid.occupancy < costmap.occupied_threshold)
    beside = cv2.dilate(unseen.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)))
    count, labels, stats, middles = cv2.connectedComponentsWithStats(
        (seen & (beside > 0)).astype(np.uint8), connectivity=8
    )
    points = []
    for label in range(1, count):  # 0 is the background
        left, top, width, height, area = stats[label]
        if area * grid.resolution < min_length:
            continue
        inside = labels[top : top + height, left : left + width] == label
        cells = np.argwhere(inside) + np.array([top, left])
        away = np.linalg.norm(cells - middles[label][::-1], axis=1)
        points.append(grid.to_xy(cells[np.argsort(away, kind="stable")[::_CELLS_PER_POINT]]))
    return points


def gains(
    grid: OccupancyGrid,
    explored: NDArray[np.bool_],
    points_xy: NDArray[np.float64],
    reach: float,
    costmap: CostmapConfig,
) -> NDArray[np.float64]:
    """Unexplored area (N,) [m^2] that may be seen from each of `points_xy` within `reach` [m]."""
    starts = (points_xy - grid.origin)[:, ::-1] / grid.resolution
    cells = _unseen_around(
        explored, grid.occupancy >= costmap.occupied_threshold, starts, reach / grid.resolution
    )
    return np.asarray(cells * grid.resolution**2)


@kernel("f8[::1](b1[:,::1], b1[:,::1], f8[:,::1], f8)")
def _unseen_around(
    explored: NDArray[np.bool_],
    occupied: NDArray[np.bool_],
    starts: NDArray[np.float64],
    reach: float,
) -> NDArray[np.float64]:
    """Unexplored cells (N,) on rays from `starts` (N, 2) row, col, weighted by their share."""
    rays = 72
    unseen = np.zeros(len(starts))
    for ray in range(rays):
        angle = 2 * np.pi * ray / rays
        down, right = np.sin(angle), np.cos(angle)
        for k in range(len(starts)):
            for i in range(1, int(2 * reach)):
                r = int(np.floor(starts[k, 0] + 0.5 * i * down))
                c = int(np.floor(starts[k, 1] + 0.5 * i * right))
                inside = 0 <= r < explored.shape[0] and 0 <= c < explored.shape[1]
                if not inside or occupied[r, c]:
                    break
                if not explored[r, c]:
                    unseen[k] += 0.5 * (0.5 * i) * 2 * np.pi / rays
    return unseen


def area_behind(
    grid: OccupancyGrid,
    explored: NDArray[np.bool_],
    points_xy: NDArray[np.float64],
    reach: float,
    costmap: CostmapConfig,
) -> float:
    """Unexplored area [m^2] that may be seen from any of `points_xy` within `reach` [m].

    What several of them may show counts once.
    """
    starts = (points_xy - grid.origin)[:, ::-1] / grid.resolution
    occupied = grid.occupancy >= costmap.occupied_threshold
    cells = _unseen_from_any(explored, occupied, starts, reach / grid.resolution)
    return float(cells * grid.resolution**2)


@kernel("i8(b1[:,::1], b1[:,::1], f8[:,::1], f8)")
def _unseen_from_any(
    explored: NDArray[np.bool_],
    occupied: NDArray[np.bool_],
    starts: NDArray[np.float64],
    reach: float,
) -> int:
    """Number of unexplored cells on rays from any of `starts` (N, 2) row, col."""
    rays = int(np.ceil(2 * np.pi * reach))
    counted, unseen = np.zeros_like(explored), 0
    for ray in range(rays):
        angle = 2 * np.pi * ray / rays
        down, right = np.sin(angle), np.cos(angle)
        for k in range(len(starts)):
            for i in range(1, int(2 * reach)):
                r = int(np.floor(starts[k, 0] + 0.5 * i * down))
                c = int(np.floor(starts[k, 1] + 0.5 * i * right))
                inside = 0 <= r < explored.shape[0] and 0 <= c < explored.shape[1]
                if not inside or occupied[r, c]:
                    break
                if not explored[r, c] and not counted[r, c]:
                    counted[r, c] = True
                    unseen += 1
    return unseen


class FrontierSearch:
    """Drives from frontier to frontier, and keeps the explored area.

    A robot that explores a saved map looks at all of it again, since a home changes; one that
    searches in it need not.

    Attributes:
        explored: What was in view, in earlier runs of the map, too.
        looked_at: What was in view in this run.
        frontiers_xy: (F, 2) a point on each frontier with enough gain, in `map` [m], as of the last
            search for one.
        seen_share: Share of the floor that was seen, 0 to 1, as of that search; None before one.
        barred_xy: (B, 2) places near which frontiers are left out for now, in `map` [m].
    """

    def __init__(self, config: FrontierConfig) -> None:
        self._config = config
        self.explored = self.looked_at = ExploredArea()
        self.frontiers_xy = np.zeros((0, 2))
        self.seen_share: float | None = None
        self.barred_xy = np.zeros((0, 2))
        self._given_up_xy = np.zeros((0, 2))
        self._target_xy: NDArray[np.float64] | None = None

    def look(self, grid: OccupancyGrid, T_map_base: SE3, robot_radius: float) -> None:
        """Add what is in view to the explored area; call with every frame that is in the map."""
        self._add_view(self.explored, grid, T_map_base, robot_radius)
        if self.looked_at is not self.explored:
            self._add_view(self.looked_at, grid, T_map_base, robot_radius)

    def remember(self, grid: OccupancyGrid, T_map_base: SE3, robot_radius: float) -> None:
        """Add what was in view in an earlier run; call it before `look`."""
        if self.looked_at is self.explored:
            self.looked_at = ExploredArea()
        self._add_view(self.explored, grid, T_map_base, robot_radius)

    def _add_view(
        self, area: ExploredArea, grid: OccupancyGrid, T_map_base: SE3, robot_radius: float
    ) -> None:
        config = self._config
        area.add_view(
            grid,
            T_map_base,
            config.field_of_view,
            config.look_range,
            config.blind_range,
            config.unmeasured_gap,
            # Less half a cell, so that the free floor under the robot borders on unexplored cells.
            robot_radius - grid.resolution / 2,
        )

    def act(
        self,
        grid: OccupancyGrid,
        costmap: Costmap,
        T_map_base: SE3,
        navigator: NavigatorConfig,
        previous: Navigation | None,
    ) -> Navigation | None:
        """Act towards the cheapest frontier; None when none is left that can be reached.

        `costmap` is that of `grid`, with a frame, as of `LiveCostmap`; `previous` is the answer one
        tick before, None at first and after a stop.
        """
        config = self._config
        reach = Reach(distance=config.stand_off, extent=grid.resolution)
        explored = self.looked_at.mask_on(grid)
        points_xy, to_see = self._worthwhile(grid, explored, navigator.costmap)
        self.frontiers_xy = points_xy
        while True:
            open_ones = self._are_open(points_xy)
            points_xy, to_see = points_xy[open_ones], to_see[open_ones]
            self._count_left(grid, explored, points_xy, navigator.costmap)
            costs = self._costs(points_xy, to_see, T_map_base)
            goals = GoalPoints(points_xy, costs)
            navigation = navigate(costmap, goals, T_map_base, reach, navigator, previous)
            self._target_xy = None if navigation is None else navigation.goal_xy
            if navigation is None or not navigation.arrived:
                return navigation
            # The frontier is near and in view, and persists: it cannot be resolved.
            self.give_up(navigation.goal_xy)

    def options(
        self, grid: OccupancyGrid, costmap: CostmapConfig, reach: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The frontiers that are left: a point (F, 2) on each [m], and what it may show (F,) [m^2].

        What lies within `reach` [m] of a frontier counts as shown by it.
        """
        explored = self.explored.mask_on(grid)
        points_xy, _ = self._worthwhile(grid, explored, costmap)
        self.frontiers_xy = points_xy
        points_xy = points_xy[self._are_open(points_xy)]
        return points_xy, gains(grid, explored, points_xy, reach, costmap)

    def count_left(
        self, grid: OccupancyGrid, points_xy: NDArray[np.float64], costmap: CostmapConfig
    ) -> None:
        """Set the share of the floor that was seen.

        The area behind frontiers is taken to have the same share of floor as the known area.

        `points_xy` (F, 2) in `map` [m] are the frontiers that are left, without those out of reach.
        """
        self._count_left(grid, self.explored.mask_on(grid), points_xy, costmap)

    def _count_left(
        self,
        grid: OccupancyGrid,
        explored: NDArray[np.bool_],
        points_xy: NDArray[np.float64],
        costmap: CostmapConfig,
    ) -> None:
        reach = self._config.gain_reach
        free = int(np.count_nonzero(grid.occupancy <= costmap.free_threshold))
        occupied = int(np.count_nonzero(grid.occupancy >= costmap.occupied_threshold))
        floor = free / max(free + occupied, 1)
        left = floor * area_behind(grid, explored, points_xy, reach, costmap)
        seen = np.count_nonzero(explored & (grid.occupancy < BLOCKING)) * grid.resolution**2
        self.seen_share = seen / (seen + left) if seen > 0.0 else 0.0

    def give_up(self, point_xy: NDArray[np.float64]) -> None:
        """Leave out a frontier that persists though the robot faces it from near by."""
        self._given_up_xy = np.vstack([self._given_up_xy, point_xy])

    def give_up_ahead(self, T_map_base: SE3) -> None:
        """Leave out the frontiers right ahead of a place from which the camera shows nothing.

        It need not face them: as soon as it did, it would show nothing again.
        """
        config, (x, y) = self._config, T_map_base[:2, 3]
        for point_xy in self.frontiers_xy:
            dx, dy = point_xy - (x, y)
            aside = wrap_angle(float(np.arctan2(dy, dx)) - yaw_of(T_map_base))
            near = np.hypot(dx, dy) <= config.blind_range
            if near and abs(aside) <= config.field_of_view / 2:
                self.give_up(point_xy)

    def reopen(self) -> None:
        """Reopen the frontiers that were given up: what was in the way may be gone."""
        self._given_up_xy = np.zeros((0, 2))

    def _are_open(self, points_xy: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which of the points (N, 2) are near no frontier that was given up or is barred."""
        left_out_xy = np.vstack([self._given_up_xy, self.barred_xy])
        away = np.linalg.norm(points_xy[:, None] - left_out_xy, axis=2)
        return np.asarray((away >= self._config.given_up_radius).all(axis=1))

    def _worthwhile(
        self, grid: OccupancyGrid, explored: NDArray[np.bool_], costmap: CostmapConfig
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """A point (N, 2) on each frontier with enough gain [m], and its gain (N,) [m^2].

        The point is the middle of the frontier, unless that has much less gain than the best point,
        as behind a corner.
        """
        config = self._config
        chosen: list[tuple[NDArray[np.float64], float]] = []
        found = frontiers(grid, explored, costmap, config.min_length)
        points_xy = np.concatenate([np.zeros((0, 2)), *found])
        to_see_all = gains(grid, explored, points_xy, config.gain_reach, costmap)
        begins = np.cumsum([0, *(len(along) for along in found)])
        for along, begin in zip(found, begins[:-1], strict=True):
            to_see = to_see_all[begin : begin + len(along)]
            best = int(np.argmax(to_see >= config.min_gain_share * to_see.max()))
            if to_see[best] >= config.min_gain:
                chosen.append((along[best], to_see[best]))
        points = np.array([point for point, _ in chosen]).reshape(-1, 2)
        return points, np.array([gain for _, gain in chosen])

    def _from_target(self, points_xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distances (N,) of points (N, 2) from the frontier being driven to [m].

        The middle of a frontier moves as more of it is seen, so a near point is of the same one.
        """
        if self._target_xy is None:
            return np.full(len(points_xy), np.inf)
        return np.asarray(np.linalg.norm(points_xy - self._target_xy, axis=1))

    def _costs(
        self, points_xy: NDArray[np.float64], to_see: NDArray[np.float64], T_map_base: SE3
    ) -> NDArray[np.float64]:
        """Cost of each frontier beside the path to it [m]."""
        config = self._config
        dx, dy = (points_xy - T_map_base[:2, 3]).T
        turns = np.abs((np.arctan2(dy, dx) - yaw_of(T_map_base) + np.pi) % (2 * np.pi) - np.pi)
        costs = config.turn_cost * turns
        costs += config.path_per_gain * np.maximum(config.max_gain - to_see, 0.0)
        away = self._from_target(points_xy) / config.given_up_radius
        costs += config.frontier_change_saving * np.minimum(away, 1.0)
        return np.asarray(costs)
