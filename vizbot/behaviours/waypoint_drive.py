"""The drive to a place on the map, as near to it as there is room."""

from __future__ import annotations

import numpy as np

from nav.config import Reach
from nav.costmap import LiveCostmap
from nav.navigator import GoalPoints, Navigation, navigate
from vizbot.config import Config
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, OccupancyGrid
from vizbot.objectnav.tasks import Decision, Waypoint

_BESIDE = Reach(distance=1.7, extent=1.0)
"""Distance at which a place with an obstacle on it, as the middle of a bed, counts as reached."""


class WaypointDrive:
    """Drives to one place after another on one map."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._costmap = LiveCostmap(config.navigator.costmap)
        self._previous: Navigation | None = None

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        self._previous = None

    def decide(self, place: Waypoint, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """What to do in this step."""
        navigator, navigation = self._config.navigator, None
        reaches, cell = self._config.objectnav.waypoint_reaches, tuple(grid.to_cells(place.xy))
        occupied = navigator.costmap.occupied_threshold
        if grid.contains(np.array(cell)) and grid.occupancy[cell] >= occupied:
            reaches = (*reaches, _BESIDE)
        costmap = self._costmap.update(grid)
        for reach in reaches:
            goal = GoalPoints(place.xy)
            navigation = navigate(costmap, goal, T_map_base, reach, navigator, self._previous)
            if navigation is not None:
                break
        self._previous = navigation
        if navigation is None:
            reason = "the map shows no way to that place"
            return Decision(STOP, "no way there", ended=(Outcome.GAVE_UP, reason))
        if navigation.distance == 0.0:  # it need not face the place
            rest = float(np.linalg.norm(place.xy - T_map_base[:2, 3]))
            reason = f"{rest:.1f} m from the place, as near as there is room"
            return Decision(STOP, "arrived", navigation, ended=(Outcome.ARRIVED, reason))
        return Decision(navigation.twist, "going to a place", navigation)
