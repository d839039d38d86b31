"""The exploration of a map: from frontier to frontier, until nothing is left to see."""

from __future__ import annotations

from nav.costmap import LiveCostmap
from nav.frontier import FrontierSearch
from nav.navigator import Navigation
from vizbot.config import Config
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, OccupancyGrid
from vizbot.objectnav import reasons
from vizbot.objectnav.tasks import Decision


class Exploration:
    """Explores one map.

    Attributes:
        frontiers: What the camera has looked at.
    """

    def __init__(self, config: Config) -> None:
        self._config = config
        self.frontiers = FrontierSearch(config.frontier)
        self._costmap = LiveCostmap(config.navigator.costmap)
        self._previous: Navigation | None = None

    def look(self, grid: OccupancyGrid, T_map_base: SE3) -> None:
        """Mark what the camera sees from `T_map_base` as explored."""
        self.frontiers.look(grid, T_map_base, self._config.navigator.costmap.robot_radius)

    def remember(self, grid: OccupancyGrid, T_map_base: SE3) -> None:
        """Mark what the camera saw from `T_map_base` in an earlier run of the map.

        A search counts it as seen; an exploration looks at it again.
        """
        self.frontiers.remember(grid, T_map_base, self._config.navigator.costmap.robot_radius)

    def seen(self, grid: OccupancyGrid, *, exploring: bool) -> float:
        """How much floor was looked at so far [m^2]; for one that is `exploring` in this run."""
        area = self.frontiers.looked_at if exploring else self.frontiers.explored
        return area.area(grid.resolution)

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        self._previous = None

    def decide(self, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """What to do in this step."""
        navigation = self._previous = self.frontiers.act(
            grid, self._costmap.update(grid), T_map_base, self._config.navigator, self._previous
        )
        if navigation is None:
            reason = "everything that can be reached was seen"
            return Decision(STOP, "nothing left to see", ended=(Outcome.EXPLORED, reason))
        why = reasons.MOST_FOR_THE_WAY
        return Decision(navigation.twist, "exploring", navigation, exploring=True, why=why)
