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

One view decides, by its cosine alone: the robot looks at nothing twice, and stops where it has
reached the element that it drove to. The paper does not say how the loop ends when nothing on the
map can be reached; here the search then ends as not found.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import GrowingRows
from mapping.clip.places.footprint import PLACE
from mapping.clip.retrieval import find, similarities
from nav.config import NavigatorConfig, Reach
from nav.costmap import Costmap, LiveCostmap
from nav.navigator import GoalPoints, Navigation, explore_distant, navigate
from vizbot.core.errors import ConfigError
from vizbot.core.observer import Candidate, Outcome
from vizbot.core.place_scores import Measure, PlaceScores
from vizbot.core.types import SE3, STOP, OccupancyGrid
from vizbot.objectnav import reasons
from vizbot.objectnav.tasks import Decision, Goal
from vizbot.perception.sightings import Sightings

if TYPE_CHECKING:  # a search may be made without a camera
    from vizbot.perception.perception import Perception

LOWERING = 0.001
"""Theta is lowered by this at a time."""
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
    """Run Algorithm 1 once on the maps of this moment; None when nothing can be reached.

    Args:
        sightings: M^CLIP with the similarities to q_t (equation 7).
        theta: Threshold; what is lowered does not outlive the run.
        costmap: That of M^Depth, with a frame, as of `LiveCostmap`.
        T_map_base: P_t.
        navigator: How the robot drives, and the distant point.
        previous: The navigation of the run before; None at first and after a stop.
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
    # What can be reached with one theta can be reached with a lower one, so bisection finds the
    # first.
    first = bisect_left(lowered, True, key=lambda each: find_and_navigate(each) is not None)
    return find_and_navigate(lowered[first]) if first < len(lowered) else None


def lowered_thetas(theta: float, similarities: NDArray[np.float32]) -> list[float]:
    """What theta becomes, one `LOWERING` after another, until it retrieves all of the map."""
    lowest, lowered = similarities.min(initial=np.inf), []
    while lowest <= theta:
        theta -= LOWERING
        lowered.append(theta)
    return lowered


class RunningScores:
    """Similarities of the elements of a growing CLIP map, each computed once for a goal."""

    def __init__(self) -> None:
        self._goal: Goal | None = None
        self._scores = GrowingRows(np.zeros(0, np.float32))

    def similarities_to(self, goal: Goal, embeddings: NDArray[np.float32]) -> NDArray[np.float32]:
        """Similarities (N,) to a goal.

        Args:
            goal: One other than that of the previous call begins anew.
            embeddings: (N, D) unit; they begin with those of the previous call.
        """
        if goal is not self._goal:
            self._goal, self._scores = goal, GrowingRows(np.zeros(0, np.float32))
        fresh = embeddings[len(self._scores) :]
        self._scores.add(similarities(fresh, goal.embedding))
        return self._scores.rows


class PaperSearch:
    """The `Search` by Algorithm 1 alone: it leaves no place out, and has no beliefs.

    Attributes:
        answer: Index of the element that the robot has arrived at last; None before.
    """

    measure: ClassVar = Measure.SIMILARITY
    assisted: ClassVar = False

    def __init__(self, navigator: NavigatorConfig) -> None:
        self._navigator = navigator
        self._costmap = LiveCostmap(navigator.costmap)
        self._previous: Navigation | None = None
        self.answer: int | None = None
        self._held: tuple[Goal, float] | None = None
        self._scores = RunningScores()
        self._seen = Sightings(np.zeros((0, 3)), np.zeros(0, np.float32), np.zeros((0, 2)))

    def observe(self, goal: Goal, perception: Perception) -> PlaceScores:
        """See `Search.observe`: a place has the highest similarity of what it shows."""
        scores = self._scores.similarities_to(goal, perception.clip_map.embeddings)
        seen = self._seen = perception.sightings(scores)
        return PlaceScores.of_points(seen.points, seen.similarities, PLACE)

    def decide(self, goal: Goal, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """See `Search.decide`."""
        return self.go(goal, self._seen, grid, T_map_base)

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        self._previous = None

    def leave_alone(self, places_xy: NDArray[np.float64]) -> None:
        """Do nothing: Algorithm 1 leaves nothing out."""

    def place_of(self, navigation: Navigation) -> None:
        """No place: Algorithm 1 goes to elements."""

    def threshold(self, goal: Goal) -> float:
        """Theta as the newest decision for a goal left it; before one, the goal's."""
        held = self._held
        return held[1] if held is not None and held[0] is goal else goal.threshold

    def found_above(self, goal: Goal) -> float:
        """Theta (section III-B)."""
        return goal.threshold

    def candidates(
        self, goal: Goal, perception: Perception, *, arrived: bool = False
    ) -> tuple[Candidate, ...]:
        """The places that are most similar to a goal (section III-B), best first."""
        elements = perception.clip_map.elements
        seen = perception.sightings(similarities(elements.embeddings, goal.embedding))
        return tuple(
            Candidate(
                seen.points[i],
                float(seen.similarities[i]),
                int(elements.frames[i]),
                elements.boxes[i],
            )
            for i in seen.answers(self.answer if arrived else None)
        )

    def candidate(self, place_xy: NDArray[np.float64]) -> Candidate:
        """Raise a `ConfigError`, as `refute` and `affirm` do: this search believes nothing."""
        raise _believes_nothing()

    def refute(self, place_xy: NDArray[np.float64] | None = None) -> None:
        """Raise a `ConfigError`."""
        raise _believes_nothing()

    def affirm(self, place_xy: NDArray[np.float64]) -> None:
        """Raise a `ConfigError`."""
        raise _believes_nothing()

    def go(
        self, goal: Goal, sightings: Sightings, grid: OccupancyGrid, T_map_base: SE3
    ) -> Decision:
        """Do one step of the search for `goal`; `sightings` have their similarities to it."""
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
        self.answer = action.element
        ended = Outcome.ARRIVED, f"similarity {similarity:.3f}, within reach"
        return Decision(STOP, "arrived", navigation, threshold=theta, ended=ended, score=similarity)


def _believes_nothing() -> ConfigError:
    return ConfigError(
        "the method 'paper' cannot learn what a place is; search with --method belief"
    )
