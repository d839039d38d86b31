"""Options of the search: places that may be the goal, and frontiers that may show it."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import PlaceBelief
from nav.config import Reach
from nav.costmap import Costmap
from nav.frontier import FrontierSearch
from nav.way_field import WayField
from vizbot.config import Config
from vizbot.core.geometry import wrap_angle, yaw_of
from vizbot.core.types import SE3
from vizbot.objectnav.looks import APART, Looks
from vizbot.objectnav.option import Option
from vizbot.objectnav.seen_places import SeenPlaces

MOST_CANDIDATES = 8
LEAST = 0.02
"""Least probability of a place that is looked at, even when nothing else is left."""


class PlaceOptions:
    """Values each place by its probability; one that was looked at in vain is left."""

    def __init__(self, config: Config) -> None:
        self._margin = config.navigator.reach_margin

    def options(
        self,
        belief: PlaceBelief,
        costmap: Costmap,
        ways: WayField,
        looks: Looks,
        reach_of: Callable[[float], Reach],
    ) -> list[Option]:
        """The likeliest places to look at, apart from one another.

        `reach_of` says from where, by the height of what was seen there [m].
        """
        places = SeenPlaces.from_belief(belief, LEAST, costmap)
        left = np.where(looks.are_done(places.xy), 0.0, places.probabilities)
        options: list[Option] = []
        for _ in range(MOST_CANDIDATES):
            if len(left) == 0 or left.max() < LEAST:
                break
            best = int(np.argmax(left))
            xy, front_xy = places.xy[best], places.fronts_xy[best]
            height = float(places.heights[best])
            reach = reach_of(height)
            side = places.seen_from[best] if places.known[best] else None
            extent = reach.extent if side is None else costmap.grid.resolution
            within = reach.distance - self._margin
            seen_xy = None if side is None else front_xy
            way = ways.cost_to_reach(costmap, xy, within, extent, seen_xy)
            if not np.isfinite(way):  # visible from no spot: try it as it is, then leave it
                way = float(ways.costs(front_xy[None], reach.distance)[0])
            if np.isfinite(way):
                options.append(Option("place", xy, float(left[best]), way, side, height))
            left[places.within(APART, xy)] = 0.0
        return options


class FrontierOptions:
    """Values each frontier by how much is unseen behind it, and by what was seen beside it."""

    GAIN_REACH: ClassVar = 5.0
    """How far behind a frontier the unseen area counts [m]."""
    MOST_GAIN: ClassVar = 30.0
    """Largest unseen area behind a frontier that counts [m^2]."""
    VALUE_RADIUS: ClassVar = 1.5
    """What was seen within this distance of a frontier says what may be behind it [m]."""
    TURN_WAY: ClassVar = 0.1
    """Length of way that a turn by one radian is worth [m]."""
    LEAST_CHANCE: ClassVar = 0.02
    """Frontiers that are less likely to show what is asked for are left."""
    MOST_LIKENESS: ClassVar = 2.0
    """Likeness that counts at a frontier, at most [standard deviations]."""

    def __init__(self, config: Config, frontiers: FrontierSearch, *, likeness: bool) -> None:
        """Create it; with `likeness` what was seen beside a frontier counts."""
        self._config, self._frontiers, self._counts_likeness = config, frontiers, likeness

    def options(
        self, belief: PlaceBelief, costmap: Costmap, ways: WayField, T_map_base: SE3
    ) -> list[Option]:
        """The frontiers that can be reached and may show what is asked for."""
        grid, settings = costmap.grid, self._config.navigator
        points_xy, areas = self._frontiers.options(grid, settings.costmap, self.GAIN_REACH)
        stand_off = self._config.frontier.stand_off
        costs, within = ways.costs(points_xy, stand_off), stand_off - settings.reach_margin
        for i in np.flatnonzero(np.isfinite(costs)):
            # A frontier that is visible from no spot is tried as it is, and then given up.
            way = ways.cost_to_reach(costmap, points_xy[i], within, grid.resolution)
            costs[i] = way if np.isfinite(way) else costs[i]
        reached_xy = points_xy[np.isfinite(costs)]
        self._frontiers.count_left(grid, reached_xy, settings.costmap)
        dx, dy = (points_xy - T_map_base[:2, 3]).T
        turns = np.abs([wrap_angle(float(a)) for a in np.arctan2(dy, dx) - yaw_of(T_map_base)])
        likeness = np.minimum(self._likeness(belief, points_xy), self.MOST_LIKENESS)
        findings = self._config.objectnav.search.finding_density
        areas = np.minimum(areas, self.MOST_GAIN)
        chances = 1.0 - np.exp(-findings * areas * np.exp(likeness))
        lengths = costs + self.TURN_WAY * turns
        return [
            Option(
                "frontier",
                points_xy[i],
                float(chances[i]),
                float(lengths[i]),
                area=float(areas[i]),
                likeness=float(likeness[i]),
            )
            for i in np.flatnonzero(np.isfinite(costs) & (chances >= self.LEAST_CHANCE))
        ]

    def _likeness(self, belief: PlaceBelief, points_xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean likeness (F,) to the goal of what was seen around each point."""
        rows, columns = np.nonzero(belief.seen)
        seen_xy, values = belief.xy(rows, columns), belief.likeness[rows, columns]
        if len(values) == 0 or not self._counts_likeness:
            return np.zeros(len(points_xy))
        mean, spread = float(values.mean()), float(values.std()) + 1e-3
        found = np.zeros(len(points_xy))
        for i, xy in enumerate(points_xy):
            near = np.linalg.norm(seen_xy - xy, axis=1) < self.VALUE_RADIUS
            if near.any():
                found[i] = (float(values[near].mean()) - mean) / spread
        return found
