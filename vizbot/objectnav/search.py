"""The search for a goal around Algorithm 1: go to what was found, confirm it, or explore."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nav.config import Reach
from nav.costmap import LiveCostmap
from nav.frontier import FrontierSearch
from nav.navigator import GoalPoints, Navigation, navigate
from vizbot.config import Config
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, OccupancyGrid
from vizbot.objectnav.algorithm import Theta, objectnav
from vizbot.objectnav.approach import NavigationState, approach
from vizbot.objectnav.confirmation import Confirmation
from vizbot.objectnav.exploration import Exploration
from vizbot.objectnav.tasks import Decision, Goal, Waypoint
from vizbot.perception.sightings import Sightings

CLOSING_STEPS = 40
"""Number of steps that the rest of the way, after a confirmation, may take."""


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """What a look has confirmed.

    Attributes:
        elements: Indices of the elements, best first.
        since: Number of the step from which on the robot drives closer.
        from_xy: (2,) where the robot stood when it saw them, in `map` [m].
        returning: Whether they were out of sight from closer by, and the robot drives back.
    """

    elements: NDArray[np.int64]
    since: int
    from_xy: NDArray[np.float64]
    returning: bool = False


class Search:
    """Searches for one goal after another on one map, and remembers what has been explored."""

    def __init__(self, config: Config, *, in_saved_map: bool = False) -> None:
        """Start idle. A search in a saved map is less choosy."""
        self._config = config
        self._in_saved_map = in_saved_map
        self._frontiers = FrontierSearch(config.frontier)
        self._costmap = LiveCostmap(config.navigator.costmap)
        self._goal: Goal | None = None
        self._since = 0
        self._confirmation = self._new_confirmation()
        self._exploration = Exploration(config, self._frontiers)
        self._found: _Found | None = None
        self._previous: Navigation | None = None

    @property
    def answer(self) -> int | None:
        """Index of the element confirmed as the goal; None while there is none."""
        return None if self._found is None else int(self._found.elements[0])

    @property
    def frontiers_xy(self) -> NDArray[np.float64]:
        """Frontiers (F, 2) x, y in `map` [m] at the latest exploration."""
        return self._frontiers.frontiers_xy

    @property
    def frontiers(self) -> FrontierSearch:
        """What the camera has looked at."""
        return self._frontiers

    def look(self, grid: OccupancyGrid, T_map_base: SE3) -> None:
        """Mark what the camera sees from `T_map_base` as explored."""
        radius = self._config.navigator.costmap.robot_radius
        self._frontiers.look(grid, T_map_base, radius)

    def interrupt(self) -> None:
        """Forget the present way and look: something else has moved the robot."""
        self._previous = None
        self._confirmation.interrupt()

    def _state(self, grid: OccupancyGrid, T_map_base: SE3) -> NavigationState:
        return NavigationState(grid, self._costmap.update(grid), T_map_base, self._previous)

    def explore(self, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """Do one step of an exploration, until nothing is left to see."""
        state = self._state(grid, T_map_base)
        self._previous = self._exploration.to_unknown(state)
        if self._previous is None:
            reason = "everything that can be reached was seen"
            return Decision(STOP, "nothing left to see", ended=(Outcome.EXPLORED, reason))
        return Decision(self._previous.twist, "exploring", self._previous, exploring=True)

    def drive_to(self, place: Waypoint, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """Do one step towards a place, as near to it as there is room."""
        config, navigation, state = self._config, None, self._state(grid, T_map_base)
        reaches, cell = config.objectnav.waypoint_reaches, tuple(grid.to_cells(place.xy))
        occupied = config.navigator.costmap.occupied_threshold
        if grid.contains(np.array(cell)) and grid.occupancy[cell] >= occupied:
            reaches += config.objectnav.reaches[-1:]
        for reach in reaches:
            navigation = navigate(
                state.costmap,
                GoalPoints(place.xy),
                T_map_base,
                reach,
                config.navigator,
                state.previous,
            )
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

    def go(
        self,
        goal: Goal,
        sightings: Sightings,
        grid: OccupancyGrid,
        T_map_base: SE3,
        frame: int,
        step: int,
    ) -> Decision:
        """Do one step of the search for `goal`.

        Args:
            goal: A goal other than that of the previous step begins a new search.
            sightings: Elements of the CLIP map with their similarities to the goal.
            grid: The obstacle map.
            T_map_base: Where the robot is.
            frame: Index of the newest frame.
            step: Number of this step.
        """
        if goal is not self._goal:
            self._goal, self._since = goal, step
            self._confirmation = self._new_confirmation()
            self._exploration = Exploration(self._config, self._frontiers)
            self._found = None
        config, confirmation = self._config.objectnav, self._confirmation
        believed = replace(sightings, similarities=confirmation.believable(sightings))
        if confirmation.looking:
            twist = confirmation.step(believed, frame, config.threshold_floor, T_map_base)
            if twist is not None:
                return Decision(twist, "making sure", self._previous)
            if len(confirmation.found):
                found = _Found(confirmation.found, step, T_map_base[:2, 3].copy())
                if self._found is not None:
                    return self._arrived(found, sightings)
                self._found = found
            elif self._found is not None and self._is_below_or_above_view(self._found, sightings):
                self._found = replace(self._found, since=step, returning=True)
            else:
                self._found = None
                believed = replace(sightings, similarities=confirmation.believable(sightings))
        state = self._state(grid, T_map_base)
        if self._found is not None:
            return self._close_in(self._found, goal, sightings, state, frame, step)
        action = objectnav(
            goal,
            believed,
            self._theta(goal, step),
            state,
            self._exploration,
            config,
            self._config.navigator,
        )
        if action is None:
            reason = "everything that can be reached was seen, and nothing is similar enough"
            return Decision(STOP, "nothing left to see", ended=(Outcome.NOT_FOUND, reason))
        navigation = self._previous = action.navigation
        if navigation.arrived:
            threshold = min(action.threshold, goal.threshold)
            place_xy, within = navigation.goal_xy, config.confirmation.in_sight
            confirmation.begin(frame + 1, threshold, place_xy, within, T_map_base)
            return Decision(STOP, "making sure", navigation, False, action.threshold)
        activity = "exploring" if action.exploring else "going to what was found"
        if action.exploring and self._exploration.inspecting:
            activity = "looking closer"
        return Decision(navigation.twist, activity, navigation, action.exploring, action.threshold)

    def _theta(self, goal: Goal, step: int) -> Theta:
        """Choosy early in a search, while something better may still be found."""
        config = self._config.objectnav
        elapsed, choosy_steps = step - self._since, config.choosy_share * config.max_steps
        share = 1.0 if self._in_saved_map else min(elapsed / max(choosy_steps, 1.0), 1.0)
        choosy = config.choosy + (config.settled_for - config.choosy) * share
        return Theta(
            goal.threshold * choosy,
            goal.threshold * config.threshold_floor,
            lower_first=elapsed > choosy_steps,
        )

    def _new_confirmation(self) -> Confirmation:
        config = self._config.objectnav
        return Confirmation(config.confirmation, config.look_around_rate)

    def _close_in(
        self,
        found: _Found,
        goal: Goal,
        sightings: Sightings,
        state: NavigationState,
        frame: int,
        step: int,
    ) -> Decision:
        """Do one step of the rest of the way, because the element may be the edge of the thing."""
        config, navigation = self._config, None
        if step - found.since < CLOSING_STEPS:
            navigation = self._way_to(found, sightings, state)
        self._previous = navigation
        if navigation is not None and not navigation.arrived:
            activity = "going back" if found.returning else "closing in"
            return Decision(navigation.twist, activity, navigation)
        moved = float(np.linalg.norm(state.T_map_base[:2, 3] - found.from_xy))
        if found.returning or moved <= config.objectnav.confirmation.spacing:
            return self._arrived(found, sightings)
        place_xy = sightings.points[found.elements[0], :2]
        within = config.objectnav.confirmation.agreement.radius
        self._confirmation.begin(frame + 1, goal.threshold, place_xy, within, state.T_map_base)
        return Decision(STOP, "making sure", navigation)

    def _way_to(
        self, found: _Found, sightings: Sightings, state: NavigationState
    ) -> Navigation | None:
        """The way closer to what was found, or back; None when there is none."""
        config = self._config
        if found.returning:
            on_the_spot = Reach(distance=config.objectnav.confirmation.spacing, extent=0.05)
            start = GoalPoints(found.from_xy)
            return navigate(
                state.costmap,
                start,
                state.T_map_base,
                on_the_spot,
                config.navigator,
                state.previous,
            )
        navigation = approach(
            sightings.take(found.elements),
            config.objectnav.closing_reaches,
            0.0,
            state,
            config.navigator,
        )
        if navigation is not None and navigation.distance > config.objectnav.confirmation.near:
            return None  # the way leads around a wall
        return navigation

    def _is_below_or_above_view(self, found: _Found, sightings: Sightings) -> bool:
        """Whether what was found cannot be in the picture from close by, so that it is not refuted.

        A robot that stands on a carpet does not see it.
        """
        nearest = self._config.objectnav.closing_reaches[0]
        height = sightings.points[found.elements[0], 2]
        return not nearest.least_height <= height <= nearest.most_height

    def _arrived(self, found: _Found, sightings: Sightings) -> Decision:
        self._found, similarity = found, sightings.similarities[found.elements[0]]
        reason = f"similarity {similarity:.3f}, seen from near by"
        return Decision(STOP, "arrived", self._previous, ended=(Outcome.ARRIVED, reason))
