"""Exploration from frontier to frontier (Yamauchi 1997), by what the camera has looked at.

A frontier is where what the camera has looked at borders on what it has not. The robot goes
to the cheapest: near, rather ahead than behind, and with much to see behind it, so that a door
comes before a corner. One that is still there when the robot stands before it and faces it cannot
be resolved, and is given up.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from nav.costmap import CostmapConfig
from nav.explored_area import BLOCKING, ExploredArea
from nav.navigator import Navigation, NavigatorConfig, Reach, navigate
from vizbot.core.geometry import yaw_of
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, OccupancyGrid

_EVERY = 3
"""So many cells of a frontier share a point."""


class FrontierConfig(BaseModel):
    """What counts as seen, and which frontier is worth the way."""

    model_config = SETTINGS

    field_of_view: float = Field(default=1.1, gt=0.0, lt=3.1)
    """Horizontal, of the camera, somewhat less than it truly has [rad]."""
    look_range: float = Field(default=2.5, gt=0.0)
    """What is farther away has not been looked at, though depth may reach it [m]."""
    blind_range: float = Field(default=1.3, ge=0.0)
    """Nearer floor lies below the image; it counts as looked at [m]."""
    unmeasured_gap: float = Field(default=0.4, ge=0.0)
    """So much floor without depth, dark or shiny, does not end a look [m]."""
    min_length: float = Field(default=0.4, gt=0.0)
    """Shorter frontiers are left alone [m]."""
    stand_off: float = Field(default=0.6, gt=0.0)
    """One that is still there when the robot faces it from within this distance is given up [m]."""
    given_up_radius: float = Field(default=0.5, gt=0.0)
    """Frontiers this near to one that was given up are left alone, too [m]."""
    gain_reach: float = Field(default=2.5, gt=0.0)
    """How far beyond a frontier it is estimated what is to be seen there [m]."""
    min_gain: float = Field(default=0.2, ge=0.0)
    """A frontier with less to see is left alone [m^2]."""
    large_gain: float = Field(default=1.0, ge=0.0)
    """One with less is small: a search looks closer at what it has found first. A frontier that is
    being driven to is large down to half of it [m^2]."""
    good_view: float = Field(default=0.5, gt=0.0, le=1.0)
    """A point of a frontier will do if this share of what its best point shows is seen from it."""
    most_gain: float = Field(default=6.0, gt=0.0)
    """More to see is worth no more [m^2]."""
    gain_worth: float = Field(default=2.5, ge=0.0)
    """How much way a square metre to see is worth [m/m^2]."""
    turn_cost: float = Field(default=0.15, ge=0.0)
    """How much way a radian of turning towards the frontier costs [m/rad]."""
    keep_worth: float = Field(default=0.6, ge=0.0)
    """A frontier must save this much way to replace the one being driven to [m]."""


def frontiers(
    grid: OccupancyGrid, looked: NDArray[np.bool_], costmap: CostmapConfig, min_length: float
) -> list[NDArray[np.float64]]:
    """Where what was looked at and is open borders on what has not been looked at.

    Args:
        grid: The obstacle map.
        looked: (rows, cols) cells that the camera has looked at.
        costmap: What counts as occupied.
        min_length: Shorter frontiers are left out [m].

    Returns:
        Points (N, 2) x, y in `map` [m] along each frontier, the nearest to its middle first.
    """
    seen = looked & (grid.occupancy < BLOCKING)
    unseen = ~looked & (grid.occupancy < costmap.occupied_threshold)
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
        points.append(grid.to_xy(cells[np.argsort(away, kind="stable")[::_EVERY]]))
    return points


def gains(
    grid: OccupancyGrid,
    looked: NDArray[np.bool_],
    points_xy: NDArray[np.float64],
    reach: float,
    costmap: CostmapConfig,
) -> NDArray[np.float64]:
    """Area (N,) [m^2] not looked at that may be seen from each of `points_xy` within `reach`."""
    at = (points_xy - grid.origin)[:, ::-1] / grid.resolution
    cells = _unseen_around(
        looked, grid.occupancy >= costmap.occupied_threshold, at, reach / grid.resolution
    )
    return np.asarray(cells * grid.resolution**2)


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _unseen_around(
    looked: NDArray[np.bool_], occupied: NDArray[np.bool_], at: NDArray[np.float64], reach: float
) -> NDArray[np.float64]:
    """Cells (N,) on rays from `at` (N, 2) row, col that are not looked at; each by its share."""
    rays = 72
    unseen = np.zeros(len(at))
    for k in range(len(at)):
        for ray in range(rays):
            angle = 2 * np.pi * ray / rays
            for i in range(1, int(2 * reach)):
                r = int(np.floor(at[k, 0] + 0.5 * i * np.sin(angle)))
                c = int(np.floor(at[k, 1] + 0.5 * i * np.cos(angle)))
                if not (0 <= r < looked.shape[0] and 0 <= c < looked.shape[1]) or occupied[r, c]:
                    break
                if not looked[r, c]:
                    unseen[k] += 0.5 * (0.5 * i) * 2 * np.pi / rays
    return unseen


class FrontierSearch:
    """Goes from frontier to frontier and remembers what has been looked at.

    Attributes:
        looked: What the camera has looked at.
        frontiers_xy: (F, 2) a point on each frontier with enough to see behind it, in `map` [m],
            when one was last looked for.
    """

    def __init__(self, config: FrontierConfig) -> None:
        """Nothing has been looked at yet."""
        self._config = config
        self.looked = ExploredArea()
        self.frontiers_xy = np.zeros((0, 2))
        self._given_up_xy = np.zeros((0, 2))
        self._target_xy: NDArray[np.float64] | None = None

    def look(self, grid: OccupancyGrid, T_map_base: SE3, robot_radius: float) -> None:
        """Remember what is in view; call with every frame that is in the map."""
        config = self._config
        self.looked.look(
            grid,
            T_map_base,
            config.field_of_view,
            config.look_range,
            config.blind_range,
            config.unmeasured_gap,
            # A cell less, so that the free floor under the robot borders on what is unseen.
            robot_radius - grid.resolution / 2,
        )

    def act(
        self,
        grid: OccupancyGrid,
        T_map_base: SE3,
        navigator: NavigatorConfig,
        previous: Navigation | None,
        *,
        large_only: bool = False,
    ) -> Navigation | None:
        """Act towards the cheapest frontier; None when none is left that can be reached.

        Args:
            grid: The obstacle map.
            T_map_base: Where the base is.
            navigator: How the robot drives.
            previous: The answer one tick before; None at first and after a stop.
            large_only: Leave small ones alone.
        """
        config = self._config
        reach = Reach(distance=config.stand_off, extent=grid.resolution)
        looked, costmap = self.looked.on(grid), navigator.costmap
        points_xy, to_see = self._worthwhile(grid, looked, costmap)
        self.frontiers_xy = points_xy
        if large_only:
            same = self._from_target(points_xy) < config.given_up_radius
            large = to_see >= np.where(same, 0.5, 1.0) * config.large_gain
            points_xy, to_see = points_xy[large], to_see[large]
        while True:
            offsets = points_xy[:, None] - self._given_up_xy
            open_ones = (np.linalg.norm(offsets, axis=2) >= config.given_up_radius).all(axis=1)
            points_xy, to_see = points_xy[open_ones], to_see[open_ones]
            costs = self._costs(points_xy, to_see, T_map_base)
            navigation = navigate(grid, points_xy, T_map_base, reach, navigator, previous, costs)
            if navigation is not None or not large_only:
                self._target_xy = None if navigation is None else navigation.goal_xy
            if navigation is None or not navigation.arrived:
                return navigation
            # It is in view and near, and still a frontier: more cannot be seen of it.
            self._given_up_xy = np.vstack([self._given_up_xy, navigation.goal_xy])

    def _worthwhile(
        self, grid: OccupancyGrid, looked: NDArray[np.bool_], costmap: CostmapConfig
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """A point (N, 2) on each frontier beyond which there is enough to see, and how much (N,).

        The middle, unless from there much less is seen than from the frontier's best point: it may
        lie behind a corner.
        """
        config = self._config
        chosen: list[tuple[NDArray[np.float64], float]] = []
        for along in frontiers(grid, looked, costmap, config.min_length):
            to_see = gains(grid, looked, along, config.gain_reach, costmap)
            best = int(np.argmax(to_see >= config.good_view * to_see.max()))
            if to_see[best] >= config.min_gain:
                chosen.append((along[best], to_see[best]))
        points = np.array([point for point, _ in chosen]).reshape(-1, 2)
        return points, np.array([gain for _, gain in chosen])

    def _from_target(self, points_xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far (N,) points (N, 2) are from the frontier that is being driven to [m].

        Its middle moves as more of it is seen: what is near is the same one.
        """
        if self._target_xy is None:
            return np.full(len(points_xy), np.inf)
        return np.asarray(np.linalg.norm(points_xy - self._target_xy, axis=1))

    def _costs(
        self, points_xy: NDArray[np.float64], to_see: NDArray[np.float64], T_map_base: SE3
    ) -> NDArray[np.float64]:
        """What each frontier costs beside the way to it [m]."""
        config = self._config
        dx, dy = (points_xy - T_map_base[:2, 3]).T
        turns = np.abs((np.arctan2(dy, dx) - yaw_of(T_map_base) + np.pi) % (2 * np.pi) - np.pi)
        costs = config.turn_cost * turns
        costs += config.gain_worth * np.maximum(config.most_gain - to_see, 0.0)
        away = self._from_target(points_xy) / config.given_up_radius
        costs += config.keep_worth * np.minimum(away, 1.0)
        return np.asarray(costs)
