"""A closer look at suspects, places that may be the goal.

Encoders are more certain from close by and from several sides. The robot drives up to what looked
somewhat like the goal from across a room, and what it sees from there counts. The paper has no such
step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nav.config import NavigatorConfig
from nav.navigator import GoalPoints, Navigation, navigate
from vizbot.config import InspectionConfig
from vizbot.objectnav.approach import NavigationState
from vizbot.perception.sightings import Sightings
from vizbot.perception.vicinity import around_any

MOST_SUSPECTS = 100
"""Only this number of most similar elements is considered at a time."""


class Inspection:
    """Leads to suspects, and remembers which are settled, while searching for one goal."""

    def __init__(self, config: InspectionConfig) -> None:
        self._config = config
        self._settled = np.zeros(0, bool)
        self._target_xy: NDArray[np.float64] | None = None

    @property
    def under_way(self) -> bool:
        """Whether the last navigation leads to a suspect."""
        return self._target_xy is not None

    def navigate(
        self,
        sightings: Sightings,
        threshold: float,
        state: NavigationState,
        navigator: NavigatorConfig,
        detour: float = np.inf,
    ) -> Navigation | None:
        """Navigate to the nearest suspect; None when there is none.

        Args:
            sightings: Of the whole map, with believable similarities; they grow from tick to tick.
            threshold: Theta of the goal.
            state: The obstacle map and the robot on it.
            navigator: How the robot drives.
            detour: Suspects farther away wait [m], except one that the robot is on its way to.
        """
        config = self._config
        last_xy, self._target_xy = self._target_xy, None
        suspects = self._suspects(sightings, config.suspicion * threshold)
        while len(suspects):
            goals = GoalPoints(
                sightings.points[suspects, :2], seen_from=sightings.seen_from[suspects]
            )
            navigation = navigate(
                state.costmap, goals, state.T_map_base, config.reach, navigator, state.previous
            )
            if navigation is None:
                return None
            offsets = sightings.points[suspects, :2] - navigation.goal_xy
            if navigation.arrived:
                there = np.linalg.norm(offsets, axis=1) <= config.radius
                self._settled[suspects[there]] = True
                suspects = suspects[~there]
                continue
            on_its_way = last_xy is not None and (
                np.linalg.norm(last_xy - navigation.goal_xy) <= config.radius
            )
            if not on_its_way and navigation.distance > detour:
                return None
            self._target_xy = navigation.goal_xy
            return navigation
        return None

    def _suspects(self, sightings: Sightings, least: float) -> NDArray[np.int64]:
        """Indices of elements from `least` similarity on that are not settled."""
        config, points_xy = self._config, sightings.points[:, :2]
        self._settled = np.pad(self._settled, (0, len(points_xy) - len(self._settled)))
        similar = np.flatnonzero((sightings.similarities >= least) & ~self._settled)
        similar = similar[~self._is_near(sightings, similar)]
        similar = similar[
            np.argsort(-sightings.similarities[similar], kind="stable")[:MOST_SUSPECTS]
        ]
        near = around_any(sightings.points, points_xy[similar], config.radius)
        near = near[self._is_near(sightings, near)]
        near_xy, near_from = points_xy[near], sightings.seen_from[near]
        for i in similar:
            around = np.linalg.norm(near_xy - points_xy[i], axis=1) <= config.radius
            cameras = near_from[around]
            # A view of the other side of a wall does not show it.
            this_side = (cameras - points_xy[i]) @ (sightings.seen_from[i] - points_xy[i]) > 0
            positions = np.unique(np.floor(cameras[this_side] / config.spacing), axis=0)
            self._settled[i] = len(positions) >= config.views
        return similar[~self._settled[similar]]

    def _is_near(self, sightings: Sightings, chosen: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which of the chosen elements were seen from near by."""
        offsets = sightings.points[chosen, :2] - sightings.seen_from[chosen]
        return np.asarray(np.linalg.norm(offsets, axis=1) <= self._config.near)
