"""The paper's Algorithm 1 and nothing else (section III-C), as `objectnav.method = "paper"` drives.

    Input: object-goal q_t
    g_t <- Find(M^CLIP_t-1, q_t, theta)
    if g_t is not empty:
        a_t <- Navigation(M^Depth_t, g_t, P_t)
    if g_t is empty or a_t is empty:
        a_t <- Navigation(M^Depth_t, g_distant, P_t)
        while a_t is empty:
            theta <- theta - 0.001
            g_t <- Find(M^CLIP_t-1, q_t, theta)
            if g_t is not empty:
                a_t <- Navigation(M^Depth_t, g_t, P_t)
    return a_t

One view decides, by its cosine alone: nothing is looked at twice, and the robot stops where it has
reached what it was led to. The paper does not say how the loop ends when nothing on the map can be
reached; here the goal is not found then.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.clip.retrieval import find
from nav.config import NavigatorConfig, Reach
from nav.costmap import Costmap, LiveCostmap
from nav.navigator import GoalPoints, Navigation, explore_distant, navigate
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, OccupancyGrid
from vizbot.objectnav import reasons
from vizbot.objectnav.tasks import Decision, Goal
from vizbot.perception.sightings import Sightings

LOWERING = 0.001
"""Theta is lowered by this much at a time."""
REACH = Reach(distance=1.0, extent=0.6)
"""When an element is reached; the paper counts a stop within 2 m of the thing (section IV-C)."""


@dataclass(frozen=True, slots=True, eq=False)
class PaperAction:
    """What Algorithm 1 returns.

    Attributes:
        navigation: The way to go and the twist to begin it.
        element: Index of the element that it leads to; None where that is the distant point.
        theta: After lowering.
    """

    navigation: Navigation
    element: int | None
    theta: float


def decide(
    sightings: Sightings,
    theta: float,
    costmap: Costmap,
    T_map_base: SE3,
    navigator: NavigatorConfig,
    previous: Navigation | None = None,
) -> PaperAction | None:
    """Run Algorithm 1 once on the maps of this moment.

    Args:
        sightings: M^CLIP with the similarities to q_t (equation 7).
        theta: Threshold; what is lowered does not outlive the run.
        costmap: That of M^Depth, with a frame, as of `LiveCostmap`.
        T_map_base: P_t.
        navigator: How the robot drives, and the distant point.
        previous: The navigation of the run before; None at first and after a stop.

    Returns:
        None when the space is closed and nothing on the map can be reached.
    """

    def find_and_navigate(threshold: float) -> PaperAction | None:
        found = find(sightings.similarities, threshold)  # equation 8
        if len(found) == 0:
            return None
        # The planner keeps the first goal of a cell: the most similar, whatever theta adds to it.
        found = found[np.argsort(-sightings.similarities[found], kind="stable")]
        goals = GoalPoints(sightings.points[found, :2], seen_from=sightings.seen_from[found])
        navigation = navigate(costmap, goals, T_map_base, REACH, navigator, previous)
        if navigation is None or navigation.goal is None:
            return None
        return PaperAction(navigation, int(found[navigation.goal]), threshold)

    action = find_and_navigate(theta)
    if action is not None:
        return action
    distant = explore_distant(costmap, T_map_base, navigator, previous)
    if distant is not None:
        return PaperAction(distant, None, theta)
    lowered = lowered_thetas(theta, sightings.similarities)
    # What can be reached can still be reached with a lower theta, so that halving finds the first.
    first = bisect_left(lowered, True, key=lambda each: find_and_navigate(each) is not None)
    return find_and_navigate(lowered[first]) if first < len(lowered) else None


def lowered_thetas(theta: float, similarities: NDArray[np.float32]) -> list[float]:
    """What theta becomes, one `LOWERING` after another, until it retrieves all of the map."""
    lowest, lowered = similarities.min(initial=np.inf), []
    while lowest <= theta:
        theta -= LOWERING
        lowered.append(theta)
    return lowered


class PaperSearch:
    """Searches for one goal after another on one map."""

    def __init__(self, navigator: NavigatorConfig) -> None:
        """Start idle."""
        self._navigator = navigator
        self._costmap = LiveCostmap(navigator.costmap)
        self._previous: Navigation | None = None
        self._answer: int | None = None
        self._held: tuple[Goal, float] | None = None

    @property
    def answer(self) -> int | None:
        """Index of the element that the robot has arrived at last; None before."""
        return self._answer

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        self._previous = None

    def threshold(self, goal: Goal) -> float:
        """Theta as the newest decision for a goal left it; before one, the goal's."""
        held = self._held
        return held[1] if held is not None and held[0] is goal else goal.threshold

    def go(
        self, goal: Goal, sightings: Sightings, grid: OccupancyGrid, T_map_base: SE3
    ) -> Decision:
        """Do one step of the search for `goal`.

        Args:
            goal: What to look for, and theta.
            sightings: Elements of the CLIP map with their similarities to the goal.
            grid: The obstacle map.
            T_map_base: Where the robot is.
        """
        action = decide(
            sightings,
            goal.threshold,
            self._costmap.update(grid),
            T_map_base,
            self._navigator,
            self._previous,
        )
        if action is None:
            self._previous = None
            theta = [goal.threshold, *lowered_thetas(goal.threshold, sightings.similarities)][-1]
            self._held = goal, theta
            ended = Outcome.NOT_FOUND, "the space is closed, and nothing on the map can be reached"
            return Decision(STOP, "nothing left to try", threshold=theta, ended=ended)
        navigation, theta = action.navigation, action.theta
        self._previous, self._held = navigation, (goal, theta)
        if action.element is None:
            why = reasons.none_above(theta)
            return Decision(navigation.twist, "exploring", navigation, True, theta, why=why)
        similarity = float(sightings.similarities[action.element])
        if not navigation.arrived:
            activity = "going to what was found"
            why = reasons.above(similarity, theta, lowered=theta < goal.threshold)
            return Decision(
                navigation.twist, activity, navigation, threshold=theta, why=why, score=similarity
            )
        self._answer = action.element
        ended = Outcome.ARRIVED, f"similarity {similarity:.3f}, within reach"
        return Decision(STOP, "arrived", navigation, threshold=theta, ended=ended, score=similarity)
