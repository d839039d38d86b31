"""Where the robot goes while its goal is not found: up to a suspect, or into the unknown."""

from __future__ import annotations

import numpy as np

from nav.frontier import FrontierSearch
from nav.navigator import Navigation, explore_distant
from vizbot.config import Config
from vizbot.objectnav.approach import NavigationState
from vizbot.objectnav.inspection import Inspection
from vizbot.perception.sightings import Sightings


class Exploration:
    """Explores for one goal.

    Attributes:
        frontiers: What the camera has looked at. It outlives the goal.
    """

    def __init__(self, config: Config, frontiers: FrontierSearch) -> None:
        self.frontiers = frontiers
        self._config = config
        self._inspection = Inspection(config.objectnav.inspection)

    @property
    def inspecting(self) -> bool:
        """Whether the last navigation leads to a suspect."""
        return self._inspection.under_way

    def to_suspects_or_unknown(
        self, sightings: Sightings, threshold: float, state: NavigationState
    ) -> Navigation | None:
        """Navigate to a suspect or into the unknown, small frontiers last.

        Args:
            sightings: Of the goal, with believable similarities.
            threshold: Theta of the goal.
            state: The obstacle map and the robot on it.

        Returns:
            None when nothing is left to explore.
        """
        frontier = self.to_unknown(state, large_only=True)
        detour = np.inf if frontier is None else self._config.objectnav.inspection.detour
        navigator = self._config.navigator
        closer = self._inspection.navigate(sightings, threshold, state, navigator, detour)
        return closer or frontier or self.to_unknown(state)

    def to_unknown(self, state: NavigationState, *, large_only: bool = False) -> Navigation | None:
        """Navigate into the unknown; None when nothing of it can be reached.

        Args:
            state: The obstacle map and the robot on it.
            large_only: Whether small frontiers are left out.
        """
        T_map_base, previous = state.T_map_base, state.previous
        grid, costmap, navigator = state.grid, state.costmap, self._config.navigator
        if self._config.objectnav.exploration == "distant_point":
            navigation = explore_distant(costmap, T_map_base, navigator, previous)
            if navigation is not None:
                return navigation
        return self.frontiers.act(
            grid, costmap, T_map_base, navigator, previous, large_only=large_only
        )
