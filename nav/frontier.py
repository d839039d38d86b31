"""Frontiers: where what has been seen ends (Yamauchi 1997), for what the distant point leaves out.

A path to the distant point leads the robot out of a home, not into its corners. Once that space is
closed, the robot looks into every corner that is left before it says that there is nothing.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from nav.navigator import Navigation, NavigatorConfig, navigate
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, OccupancyGrid


class FrontierConfig(BaseModel):
    """Which frontiers are worth a look."""

    model_config = SETTINGS

    min_length: float = Field(default=0.4, gt=0.0)
    """Shorter ones are gaps in what was measured [m]."""
    looked_radius: float = Field(default=0.5, gt=0.0)
    """What lies this near to a place that was looked at is not looked at again [m]."""


def frontiers(
    grid: OccupancyGrid, config: NavigatorConfig, min_length: float
) -> NDArray[np.float64]:
    """One point (N, 2) x, y in `map` [m] on each frontier, the cell nearest to its middle.

    A frontier is a connected run of free cells that have an unknown one beside them.
    """
    thresholds = config.costmap
    free = grid.occupancy <= thresholds.free_threshold
    unknown = ~free & (grid.occupancy < thresholds.occupied_threshold)
    beside = cv2.dilate(
        unknown.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    )
    _, labels, stats, centres = cv2.connectedComponentsWithStats(
        (free & (beside > 0)).astype(np.uint8), connectivity=8
    )
    points = []
    for label in range(1, len(stats)):
        if stats[label, cv2.CC_STAT_AREA] * grid.resolution < min_length:
            continue
        cells = np.argwhere(labels == label)
        middle = centres[label][::-1]
        points.append(cells[np.argmin(np.linalg.norm(cells - middle, axis=1))])
    return grid.to_xy(np.array(points, np.int64).reshape(-1, 2))


class FrontierSearch:
    """Goes from frontier to frontier and remembers where it has looked."""

    def __init__(self, config: FrontierConfig) -> None:
        self._config = config
        self._looked_xy = np.zeros((0, 2))

    def act(
        self,
        grid: OccupancyGrid,
        T_map_base: SE3,
        config: NavigatorConfig,
        previous: Navigation | None,
    ) -> Navigation | None:
        """Act towards the cheapest frontier; None when every one that can be reached was seen.

        Args:
            grid: The obstacle map.
            T_map_base: Where the base is.
            config: How the robot drives.
            previous: The answer one tick before; None at first and after a stop.
        """
        points_xy = frontiers(grid, config, self._config.min_length)
        offsets = points_xy[:, None] - self._looked_xy
        near = np.linalg.norm(offsets, axis=2) < self._config.looked_radius
        points_xy = points_xy[~near.any(axis=1)]
        navigation = navigate(grid, points_xy, T_map_base, config, previous)
        if navigation is not None and navigation.arrived:
            self._looked_xy = np.vstack([self._looked_xy, navigation.goal_xy])
        return navigation
