"""The search by belief: one comparison of all that can be done next.

Every step compares what may end the search: going to a place that may be what is asked for, and
seeing what lies behind a frontier. Each is worth its probability over the way that it takes. The
robot says that it has arrived where a place near by, seen from near, is believed enough.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from mapping.clip.belief import PlaceBelief
from nav.config import Reach
from nav.costmap import Costmap, LiveCostmap
from nav.frontier import FrontierSearch
from nav.navigator import GoalPoints, Navigation, navigate
from nav.way_field import WayField
from vizbot.config import Config
from vizbot.core.geometry import wrap_angle, yaw_of
from vizbot.core.observer import Outcome
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, STOP, OccupancyGrid
from vizbot.objectnav.tasks import Decision

APART = 0.8
"""Places nearer to each other than this are one thing [m]."""
MOST_CANDIDATES = 8
LEAST = 0.02
"""Less likely places are not looked at, even when nothing else is left."""
LOOK_STEPS = 2
"""Steps after which the view from where the robot stands is in the map."""


class BeliefSearchConfig(BaseModel):
    """When a place is believed, and what is worth going to."""

    model_config = SETTINGS

    sure: float = Field(default=0.8, gt=0.0, lt=1.0)
    """Probability from which the robot says that it has arrived, early in a search."""
    settled: float = Field(default=0.6, gt=0.0, lt=1.0)
    """The same, late in a search."""
    patience: int = Field(default=300, gt=0)
    """Number of steps after which a search is late."""
    candidate: float = Field(default=0.25, gt=0.0, lt=1.0)
    """Probability from which a place is looked at before all is seen."""
    commitment: float = Field(default=0.3, ge=0.0)
    """Share by which another aim must be better than the present one."""
    findings: float = Field(default=0.015, gt=0.0)
    """Chance that a square metre not seen yet shows what is asked for, in a place like any other
    [1/m^2]."""
    doubt: float = Field(default=0.2, gt=0.0, lt=1.0)
    """Factor of the probability of a place that was looked at from near and not believed."""


@dataclass(slots=True, eq=False)
class _Aim:
    """What the robot does now.

    Attributes:
        kind: "place" or "frontier".
        xy: (2,) where that is, in `map` [m].
        looking: Steps for which the robot has stood before it, facing it.
    """

    kind: str
    xy: NDArray[np.float64]
    looking: int = 0


@dataclass(slots=True, eq=False)
class _Checked:
    """Places that were looked at from near and not believed."""

    xy: list[NDArray[np.float64]] = field(default_factory=list)

    def factor(self, points_xy: NDArray[np.float64], doubt: float) -> NDArray[np.float64]:
        """By how much (N,) the probabilities of points (N, 2) are lowered."""
        times = np.zeros(len(points_xy))
        for each in self.xy:
            times += np.linalg.norm(points_xy - each, axis=1) <= APART
        return np.asarray(doubt**times)


@dataclass(frozen=True, slots=True, eq=False)
class _Option:
    """Something that may end the search.

    Attributes:
        kind: "place" or "frontier".
        xy: (2,) in `map` [m].
        probability: That it does.
        way: What it takes, in metres of free floor.
    """

    kind: str
    xy: NDArray[np.float64]
    probability: float
    way: float


class BeliefSearch:
    """Searches for one goal on one map."""

    LOOK_WAY: ClassVar = {"place": 0.5, "frontier": 2.0}
    """What looking costs once the robot is there, as a length of way [m]."""
    REACH = Reach(distance=1.3, extent=0.6)
    """From where a place is looked at."""
    GAIN_REACH, MOST_GAIN = 5.0, 30.0
    """How far behind a frontier the unseen area counts [m], and how much of it at most [m^2]."""
    VALUE_RADIUS = 1.5
    """What was seen within this distance of a frontier says what may be behind it [m]."""
    TURN_WAY = 0.1
    """Length of way that a turn by one radian is worth [m]."""

    def __init__(
        self,
        config: Config,
        frontiers: FrontierSearch,
        search: BeliefSearchConfig = BeliefSearchConfig(),  # noqa: B008
    ) -> None:
        """Begin a search.

        Args:
            config: Settings of the robot.
            frontiers: What the camera has looked at; it outlives the goal.
            search: When a place is believed.
        """
        self._config, self._search, self._frontiers = config, search, frontiers
        self._costmap = LiveCostmap(config.navigator.costmap)
        self._ways = WayField()
        self._checked = _Checked()
        self._aim: _Aim | None = None
        self._previous: Navigation | None = None
        self._steps = 0

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        self._previous = None

    def go(self, belief: PlaceBelief, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """Do one step.

        Args:
            belief: Where the goal is believed to be.
            grid: The obstacle map.
            T_map_base: Where the robot is.
        """
        self._steps += 1
        search = self._search
        costmap = self._costmap.update(grid)
        self._ways.update(costmap, T_map_base[:2, 3])
        late = min(self._steps / search.patience, 1.0)
        sure = search.sure + (search.settled - search.sure) * late
        places_xy, probabilities = self._places(belief)
        options = self._place_options(places_xy, probabilities, search.candidate)
        options += self._frontier_options(belief, grid, T_map_base)
        if not options:
            options = self._place_options(places_xy, probabilities, LEAST)
        while options:
            option = max(options, key=self._worth)
            navigation = self._towards(option, costmap, T_map_base)
            if navigation is not None and not navigation.arrived:
                exploring = option.kind == "frontier"
                activity = "exploring" if exploring else "looking closer"
                self._previous = navigation
                return Decision(navigation.twist, activity, navigation, exploring)
            if navigation is not None and option.kind == "place" and self._aim is not None:
                self._aim.looking += 1
                if self._aim.looking <= LOOK_STEPS:
                    return Decision(STOP, "making sure", navigation)
                if option.probability >= sure:
                    reason = f"{option.probability:.0%} sure, seen from near by"
                    return Decision(STOP, "arrived", navigation, ended=(Outcome.ARRIVED, reason))
            self._aim = None
            options.remove(option)
            if option.kind == "place":
                self._checked.xy.append(option.xy)
            else:
                self._frontiers.give_up(option.xy)
        reason = "everything that can be reached was seen, and nothing is likely enough"
        return Decision(STOP, "nothing left to see", ended=(Outcome.NOT_FOUND, reason))

    def _places(self, belief: PlaceBelief) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The places (P, 2) that may be it, and how likely each is after what was looked at."""
        rows, columns = np.nonzero(belief.probabilities >= LEAST)
        places_xy = belief.xy(rows, columns)
        looked_at = self._checked.factor(places_xy, self._search.doubt)
        return places_xy, belief.probabilities[rows, columns] * looked_at

    def _place_options(
        self, places_xy: NDArray[np.float64], probabilities: NDArray[np.float64], least: float
    ) -> list[_Option]:
        """The likeliest places that can be reached, apart from one another."""
        left = probabilities.copy()
        chosen: list[int] = []
        while len(chosen) < MOST_CANDIDATES and len(left) and left.max() >= least:
            best = int(np.argmax(left))
            chosen.append(best)
            left[np.linalg.norm(places_xy - places_xy[best], axis=1) <= APART] = 0.0
        ways = self._ways.costs(places_xy[chosen], self.REACH.distance)
        return [
            _Option("place", places_xy[i], float(probabilities[i]), float(way))
            for i, way in zip(chosen, ways, strict=True)
            if np.isfinite(way)
        ]

    def _frontier_options(
        self, belief: PlaceBelief, grid: OccupancyGrid, T_map_base: SE3
    ) -> list[_Option]:
        points_xy, areas = self._frontiers.options(
            grid, self._config.navigator.costmap, self.GAIN_REACH
        )
        ways = self._ways.costs(points_xy, self._config.frontier.stand_off)
        dx, dy = (points_xy - T_map_base[:2, 3]).T
        turns = np.abs([wrap_angle(float(a)) for a in np.arctan2(dy, dx) - yaw_of(T_map_base)])
        likeness = self._likeness(belief, points_xy)
        chances = 1.0 - np.exp(
            -self._search.findings * np.minimum(areas, self.MOST_GAIN) * np.exp(likeness)
        )
        return [
            _Option("frontier", xy, float(chance), float(way + self.TURN_WAY * turn))
            for xy, chance, way, turn in zip(points_xy, chances, ways, turns, strict=True)
            if np.isfinite(way)
        ]

    def _likeness(self, belief: PlaceBelief, points_xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean likeness (F,) to the goal of what was seen around each point."""
        rows, columns = np.nonzero(belief.seen)
        seen_xy, values = belief.xy(rows, columns), belief.likeness[rows, columns]
        if len(values) == 0:
            return np.zeros(len(points_xy))
        mean, spread = float(values.mean()), float(values.std()) + 1e-3
        found = np.zeros(len(points_xy))
        for i, xy in enumerate(points_xy):
            near = np.linalg.norm(seen_xy - xy, axis=1) < self.VALUE_RADIUS
            if near.any():
                found[i] = (float(values[near].mean()) - mean) / spread
        return found

    def _worth(self, option: _Option) -> float:
        """Probability over way, and more for what the robot is on its way to."""
        aim = self._aim
        ratio = option.probability / (option.way + self.LOOK_WAY[option.kind])
        if aim is None or aim.kind != option.kind or np.linalg.norm(aim.xy - option.xy) > APART:
            return ratio
        return ratio * (1.0 + self._search.commitment)

    def _towards(self, option: _Option, costmap: Costmap, T_map_base: SE3) -> Navigation | None:
        """The way to an option, which becomes the aim."""
        aim = self._aim
        if aim is None or aim.kind != option.kind or np.linalg.norm(aim.xy - option.xy) > APART:
            self._aim = _Aim(option.kind, option.xy)
        else:
            aim.xy = option.xy
        reach = self.REACH
        if option.kind == "frontier":
            reach = Reach(distance=self._config.frontier.stand_off, extent=costmap.grid.resolution)
        return navigate(
            costmap,
            GoalPoints(option.xy),
            T_map_base,
            reach,
            self._config.navigator,
            self._previous,
        )
