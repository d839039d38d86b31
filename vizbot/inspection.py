"""Looks closer at what may be the goal before anything is decided.

Encoders are surer of what they see from near by and from several sides. What looked somewhat like
the goal from across a room is driven up to, while it is on the way or once nothing is left to
explore, and is judged by what it looks like then. The paper has no such step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.retrieval import best
from nav.navigator import Navigation, NavigatorConfig, navigate
from vizbot.config import InspectionConfig
from vizbot.core.types import SE3, OccupancyGrid
from vizbot.sightings import Sightings

MOST = 20
"""No more places than these, the most similar, are weighed at a time."""


class Inspection:
    """What has been driven up to while searching for one goal."""

    def __init__(self, config: InspectionConfig) -> None:
        """Nothing has been looked at yet."""
        self._config = config
        self._done_xy = np.zeros((0, 2))
        self._target_xy: NDArray[np.float64] | None = None

    @property
    def under_way(self) -> bool:
        """Whether the last answer leads to a place worth a closer look."""
        return self._target_xy is not None

    def act(
        self,
        sightings: Sightings,
        threshold: float,
        grid: OccupancyGrid,
        T_map_base: SE3,
        navigator: NavigatorConfig,
        previous: Navigation | None,
        detour: float = np.inf,
    ) -> Navigation | None:
        """Act towards the nearest place worth a closer look; None when there is none.

        Args:
            sightings: Of the map, with believable similarities.
            threshold: Theta of the goal.
            grid: The obstacle map.
            T_map_base: Where the robot is.
            navigator: How the robot drives.
            previous: The answer one tick before; None at first and after a stop.
            detour: Places farther away wait [m]; one that the robot is on its way to does not.
        """
        config = self._config
        places = self._open(sightings, config.suspicion * threshold)
        while len(places):
            navigation = navigate(
                grid,
                sightings.points[places, :2],
                T_map_base,
                config.reach,
                navigator,
                previous,
                seen_from=sightings.seen_from[places],
            )
            if navigation is None:
                break
            if navigation.arrived:
                self._done_xy = np.vstack([self._done_xy, navigation.goal_xy])
                places = places[self._apart(sightings.points[places, :2])]
                continue
            target, self._target_xy = self._target_xy, navigation.goal_xy
            on_its_way = target is not None and self._same(target, navigation.goal_xy)
            if on_its_way or navigation.distance <= detour:
                return navigation
            break
        self._target_xy = None
        return None

    def _open(self, sightings: Sightings, least: float) -> NDArray[np.int64]:
        """Indices of elements, the best of their places, that have not been seen well yet."""
        config = self._config
        similar = np.flatnonzero(sightings.similarities >= least)
        chosen = similar[
            best(sightings.similarities[similar], sightings.points[similar], MOST, config.radius)
        ]
        chosen = chosen[self._apart(sightings.points[chosen, :2])]
        range_xy = np.linalg.norm(sightings.points[:, :2] - sightings.seen_from, axis=1)
        near = sightings.take(range_xy <= config.near)
        seen_well = [
            len(np.unique(near.keyframes[self._around(near.points[:, :2], place)])) >= config.views
            for place in sightings.points[chosen, :2]
        ]
        return np.asarray(chosen[~np.array(seen_well, bool)])

    def _apart(self, places_xy: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which places (N, 2) are not those that are done with."""
        offsets = np.linalg.norm(places_xy[:, None] - self._done_xy, axis=2)
        return np.asarray((offsets > self._config.radius).all(axis=1))

    def _around(
        self, points_xy: NDArray[np.float64], place_xy: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        return np.asarray(np.linalg.norm(points_xy - place_xy, axis=1) <= self._config.radius)

    def _same(self, one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
        return bool(np.linalg.norm(one - other) <= self._config.radius)
