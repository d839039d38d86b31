"""The search by belief: one comparison of all that can be done next.

Every step compares what may end the search: going to a place that may be the goal, and seeing what
lies behind a frontier. Each is worth its probability divided by the length of the way to it. The
robot says that it has arrived where a place near by, seen from near, is believed enough: it
approaches such a place before anything is compared. In a room it first turns around, and says that
it has arrived only if it is as sure then: seen from its door one room looks like another. When
nothing is worth its way any more, the robot goes back to the likeliest place if that is likely
enough, else the search ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import Belief, PlaceBelief
from mapping.clip.places.evidence import fitted_weights
from mapping.clip.scores import Query
from nav.config import Reach
from nav.costmap import Costmap, LiveCostmap
from nav.frontier import FrontierSearch
from nav.goal_region import sees
from nav.navigator import GoalPoints, Navigation, navigate
from nav.way_field import WayField
from vizbot.config import Config
from vizbot.core.observer import Candidate, Outcome
from vizbot.core.place_scores import Measure, PlaceScores
from vizbot.core.types import SE3, STOP, OccupancyGrid
from vizbot.objectnav import reasons
from vizbot.objectnav.candidates import NOTHING_SEEN, believed_places, question_of, scores_of
from vizbot.objectnav.looks import APART, Looks, Turns
from vizbot.objectnav.option import Aim, Option
from vizbot.objectnav.place_options import FrontierOptions, PlaceOptions
from vizbot.objectnav.search_parts import ALL_PARTS, SearchParts
from vizbot.objectnav.seen_places import AROUND, SeenPlaces
from vizbot.objectnav.stops import (
    BAND,
    EXTENT,
    NEAR,
    ROOM_LOOK,
    ROOM_REACH,
    WITHIN,
    Stops,
)
from vizbot.objectnav.tasks import Decision, Goal
from vizbot.objectnav.verdicts import Verdicts

if TYPE_CHECKING:  # a search may be made without a camera
    from vizbot.perception.perception import Perception

CLOSING = 2.0
"""Distance within which the robot approaches a believed place before anything else [m]."""
LOOK_WAY = {"place": 0.5, "frontier": 2.0}
"""What looking costs once the robot is there, by the kind of option, as a length of way [m]."""
LOOK_STEPS = 2
"""Steps after which the view from where the robot stands is in the map."""
HELD = 0.8
"""Factor on the threshold of a place while the robot approaches it."""
MOST_BELIEFS = 64
"""Goals whose beliefs are kept."""
_OUT_OF_SIGHT = f"there is no spot within {WITHIN:.0f} m to see it from"


@dataclass(frozen=True, slots=True, eq=False)
class _SurePlace:
    """A place near by that the robot is sure of.

    Attributes:
        xy: (2,) in `map` [m].
        probability: Probability that it is the goal.
        threshold: Probability that it needs.
        in_picture: Whether it is in the picture from anywhere near enough.
    """

    xy: NDArray[np.float64]
    probability: float
    threshold: float
    navigation: Navigation
    in_picture: bool


class BeliefSearch:
    """The `Search` by the probabilities of places.

    Attributes:
        goal: The present or the last goal; None before the first.
        answer_xy: (2,) the place where the robot arrived last, in `map` [m]; None before the first.
    """

    measure: ClassVar = Measure.PROBABILITY
    assisted: ClassVar = True

    def __init__(
        self, config: Config, frontiers: FrontierSearch, parts: SearchParts = ALL_PARTS
    ) -> None:
        self._parts = parts
        self._config, self._search = config, config.objectnav.search
        self._frontiers = frontiers
        self._places, self._stops = PlaceOptions(config), Stops(config)
        self._unseen = FrontierOptions(config, frontiers, likeness=parts.likeness)
        self._costmap = LiveCostmap(config.navigator.costmap)
        self._ways = WayField()
        self._beliefs: dict[str, Belief] = {}
        self._verdicts = Verdicts()
        self.goal: Goal | None = None
        self._looks, self._turns = Looks(), Turns(config.objectnav.look_around_rate)
        self._aim: Aim | None = None
        self._previous: Navigation | None = None
        self._steps = 0
        self._threshold = self._search.arrival_probability_early
        self.answer_xy: NDArray[np.float64] | None = None
        self._barred_xy = np.zeros((0, 2))
        self._belief = NOTHING_SEEN
        self._perception: Perception | None = None

    def observe(self, goal: Goal, perception: Perception) -> PlaceScores:
        """See `Search.observe`: a place has its probability."""
        self._perception, self._belief = perception, self._believed(goal, perception)
        return scores_of(self._belief)

    def _believed(self, goal: Goal, perception: Perception) -> PlaceBelief:
        belief = self.belief_of(goal, question_of(goal))
        return self.as_judged(goal, perception.believe(belief))

    def decide(self, goal: Goal, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """See `Search.decide`."""
        return self.go(goal, self._belief, grid, T_map_base)

    def belief_of(self, goal: Goal, question: Query) -> Belief:
        """The belief for a goal, kept after the search; `question` has the encoder's log odds.

        The goal that was asked for least recently is forgotten where there are too many.
        """
        belief = self._beliefs.pop(goal.text, None)
        if belief is None:
            own = self._parts.weights
            weights = question.weights if own is None else fitted_weights(own)
            belief = Belief(question, weights)
        self._beliefs[goal.text] = belief  # the last one, as it was asked for last
        if len(self._beliefs) > MOST_BELIEFS:
            del self._beliefs[next(iter(self._beliefs))]
        return belief

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        self._previous = None

    def leave_alone(self, places_xy: NDArray[np.float64]) -> None:
        """See `Search.leave_alone`."""
        self._barred_xy = places_xy

    def place_of(self, navigation: Navigation) -> NDArray[np.float64]:
        """See `Search.place_of`."""
        return navigation.goal_xy

    def refute(self, place_xy: NDArray[np.float64] | None = None) -> None:
        """See `Search.refute`."""
        place_xy = self.answer_xy if place_xy is None else place_xy
        if self.goal is not None and place_xy is not None:
            self._verdicts.refute(self.goal.text, place_xy)
        self._verdicts.forget_affirmed()
        self._aim = self.answer_xy = None

    def affirm(self, place_xy: NDArray[np.float64]) -> None:
        """See `Search.affirm`."""
        self._verdicts.affirm(place_xy)

    def as_judged(self, goal: Goal, belief: PlaceBelief) -> PlaceBelief:
        """The belief for a goal, corrected by what people have said of places."""
        return self._verdicts.applied(belief, goal, searching=goal is self.goal)

    def threshold(self, goal: Goal) -> float:
        """Threshold of the newest decision for a goal; before one, `sure`."""
        return self._threshold if goal is self.goal else self._search.arrival_probability_early

    def found_above(self, goal: Goal) -> float:
        """The probability of the settings, the same for every goal."""
        return self._config.objectnav.answer_probability

    def candidates(
        self, goal: Goal, perception: Perception, *, arrived: bool = False
    ) -> tuple[Candidate, ...]:
        """See `Search.candidates`."""
        answer_xy = self.answer_xy if arrived else None
        return believed_places(goal, perception, self._believed(goal, perception), answer_xy)

    def candidate(self, place_xy: NDArray[np.float64]) -> Candidate | None:
        """See `Search.candidate`."""
        goal, perception = self.goal, self._perception
        if goal is None or perception is None:
            return None
        belief = self._believed(goal, perception)
        return next(iter(believed_places(goal, perception, belief, place_xy)), None)

    def go(self, goal: Goal, belief: PlaceBelief, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """Do one step; another `goal` than in the step before begins a new search."""
        if goal is not self.goal:
            self.goal, self._steps = goal, 0
            self._looks, self._aim, self.answer_xy = Looks(), None, None
            self._turns = Turns(self._config.objectnav.look_around_rate)
            self._verdicts.forget_affirmed()
        self._steps += 1
        decision = self._decide(_without(belief, self._barred_xy), grid, T_map_base)
        assert decision.threshold is not None
        self._threshold = decision.threshold
        return decision

    def _decide(self, belief: PlaceBelief, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """Compare all that can be done now, and choose."""
        costmap, sure = self._costmap.update(grid), self._sure
        self._ways.update(costmap, T_map_base[:2, 3])
        closing = self._close_in(belief, sure, costmap, T_map_base)
        if closing is not None:
            return closing
        while options := [
            *self._places.options(belief, costmap, self._ways, self._looks, self._look_reach),
            *self._unseen.options(belief, costmap, self._ways, T_map_base),
        ]:
            option = max(options, key=self._worth)
            if self._worth(option) < self._worth_trying:
                break
            navigation = self._towards(option, costmap, T_map_base)
            if navigation is not None and not navigation.arrived:
                exploring = option.kind == "frontier"
                activity = "exploring" if exploring else "looking closer"
                self._previous = navigation
                why = self._why(option, options, T_map_base)
                score = None if exploring else option.probability
                return Decision(
                    navigation.twist, activity, navigation, exploring, sure, why=why, score=score
                )
            if navigation is not None and option.kind == "place" and self._aim is not None:
                self._aim.looking += 1
                if self._aim.looking <= LOOK_STEPS:
                    why = reasons.near_by(option.probability, sure=False, standing=True)
                    why = self._verdicts.reason(option.xy, why)
                    return Decision(
                        STOP,
                        "making sure",
                        navigation,
                        threshold=sure,
                        why=why,
                        score=option.probability,
                    )
            self._aim = None
            if option.kind == "place":
                self._looks.add(option.xy)
            else:
                self._frontiers.give_up(option.xy)
        return self._last(belief, grid, costmap, T_map_base)

    def _close_in(
        self, belief: PlaceBelief, sure: float, costmap: Costmap, T_map_base: SE3
    ) -> Decision | None:
        """Approach a place near by that the robot is sure of, look, and stop; None without one."""
        for place in self._sure_places(belief, sure, costmap, T_map_base):
            if (decision := self._go_up_to(place, sure, T_map_base)) is not None:
                return decision
        return None

    def _sure_places(
        self, belief: PlaceBelief, sure: float, costmap: Costmap, T_map_base: SE3
    ) -> Iterator[_SurePlace]:
        """Places near by that the robot is sure of, the most probable first.

        Each is computed when it is asked for, since it depends on the aim at that moment.
        """
        held = self._aim if self._aim is not None and self._aim.kind == "stop" else None
        kept = sure if held is None else HELD * min(sure, held.sure)
        places, here = SeenPlaces.from_belief(belief, kept, costmap), T_map_base[:2, 3]
        near = np.flatnonzero(places.within(CLOSING, here))

        def way_to(i: int) -> Navigation | None:
            height = float(places.heights[i])
            reach = ROOM_REACH if self._wants_room else self._stops.reach(height)
            return self._to_any(places, np.array([i]), reach, costmap, T_map_base)

        for i in near[np.argsort(-places.probabilities[near])].tolist():
            if not sees(costmap, here, places.fronts_xy[i], costmap.grid.resolution):
                continue
            threshold = kept if self._aims_at("stop", places.xy[i]) else sure
            if places.probabilities[i] < threshold:
                continue
            navigation = way_to(i)
            if navigation is None or navigation.distance > CLOSING:
                continue
            # A room is large, and reached at the place itself.
            chosen = i if self._wants_room else places.likeliest_around(i)
            way = way_to(chosen) if chosen != i else None
            if way is not None and way.distance <= navigation.distance + AROUND:
                navigation = way
            else:
                chosen = i
            yield _SurePlace(
                places.xy[chosen],
                float(places.probabilities[chosen]),
                threshold,
                navigation,
                self._wants_room or self._stops.sees(float(places.heights[chosen])),
            )

    def _to_any(
        self,
        places: SeenPlaces,
        chosen: NDArray[np.int64],
        reach: Reach,
        costmap: Costmap,
        T_map_base: SE3,
    ) -> Navigation | None:
        """The way to whichever of the chosen places is nearest; None without one."""
        side = places.seen_from[chosen] if places.known[chosen].any() else None
        heights = places.heights[chosen]
        return self._navigate(places.xy[chosen], reach, costmap, T_map_base, side, heights)

    def _go_up_to(self, place: _SurePlace, sure: float, T_map_base: SE3) -> Decision | None:
        """Approach a place, look, and stop; None where a room is doubted after a turn in it."""
        xy, score, navigation = place.xy, place.probability, place.navigation
        aim = self._aim
        if aim is None or not self._aims_at("stop", xy):
            aim = self._aim = Aim("stop", xy, sure=sure)
        self._previous = navigation
        standing = navigation.arrived
        why = reasons.near_by(score, sure=True, standing=standing)
        decision = Decision(
            navigation.twist,
            "closing in",
            navigation,
            threshold=place.threshold,
            why=self._verdicts.reason(xy, why),
            score=score,
        )
        if self._wants_room and navigation.distance == 0.0:
            least = min(sure, aim.sure)
            decision = replace(decision, threshold=least)
            if (turn := self._turns.twist(T_map_base)) is not None:
                return replace(decision, twist=turn, activity="looking around")
            if score < least:
                self._looks.add(xy)
                self._aim = None
                return None
        if not standing:
            return decision
        aim.looking += 1
        if aim.looking <= LOOK_STEPS:
            return replace(decision, twist=STOP, activity="making sure")
        self.answer_xy = xy
        seen = "from near by" if place.in_picture else f"but {_OUT_OF_SIGHT}"
        ended = Outcome.ARRIVED, self._verdicts.reason(xy, f"{score:.0%} sure, {seen}")
        return replace(decision, twist=STOP, activity="arrived", why="", ended=ended)

    @property
    def _wants_room(self) -> bool:
        """Whether a room is searched for."""
        return self.goal is not None and self.goal.is_room

    def _look_reach(self, height: float) -> Reach:
        """Where a place is looked at, by the height of what was seen there [m]."""
        return ROOM_LOOK if self._wants_room else self._stops.reach(height)

    @property
    def _sure(self) -> float:
        """Probability from which a place is believed now; that of a room does not fall."""
        if self._wants_room:
            return self._search.arrival_probability_early
        return self._at_now(
            self._search.arrival_probability_early,
            self._search.arrival_probability_late,
            self._search.arrival_probability_last,
        )

    @property
    def _worth_trying(self) -> float:
        """Worth below which nothing is tried any more; it rises during a search."""
        return self._at_now(0.0, 0.0, self._search.min_probability_per_metre)

    def _at_now(self, early: float, late: float, last: float) -> float:
        """A value that goes from `early` over `late`, when a search is late, to `last`."""
        times = np.array([0.0, 1.0, 2.0]) * self._search.late_after_steps
        return float(np.interp(self._steps, times, [early, late, last]))

    def _last(
        self, belief: PlaceBelief, grid: OccupancyGrid, costmap: Costmap, T_map_base: SE3
    ) -> Decision:
        """Nothing is left to try: go to the likeliest place if it is likely enough, else end."""
        least = self._search.arrival_probability_last
        closing = self._close_in(belief, least, costmap, T_map_base)
        if closing is not None:
            return closing
        places = SeenPlaces.from_belief(belief, least, costmap)
        if len(places.xy):
            everyone = np.arange(len(places.xy))
            reach = ROOM_LOOK if self._wants_room else Reach(distance=NEAR, extent=EXTENT)
            navigation = self._to_any(places, everyone, reach, costmap, T_map_base)
            if navigation is not None and not navigation.arrived:
                assert navigation.goal is not None
                self._previous = navigation
                probability = float(places.probabilities[navigation.goal])
                why = reasons.going_back(navigation.goal_xy, probability, T_map_base)
                return Decision(
                    navigation.twist,
                    "going back",
                    navigation,
                    threshold=least,
                    why=why,
                    score=probability,
                )
            if navigation is None and not self._wants_room:
                likeliest = float(belief.probabilities.max())
                reason = f"{likeliest:.0%} sure, but {_OUT_OF_SIGHT}"
                ended = Outcome.NOT_FOUND, reason
                return Decision(STOP, "nothing left to try", threshold=least, ended=ended)
        share = self._frontiers.seen_share or 0.0
        reason = f"{share:.0%} of what can be reached was seen, and nothing there is likely enough"
        ended = Outcome.NOT_FOUND, reason
        return Decision(STOP, "nothing left to try", threshold=least, ended=ended)

    def _worth(self, option: Option) -> float:
        """Probability divided by way."""
        ratio = option.probability / (option.way + LOOK_WAY[option.kind])
        if option.kind == "place":
            ratio *= min(option.probability / self._search.candidate_probability, 1.0) ** 2
        return ratio

    def _towards(self, option: Option, costmap: Costmap, T_map_base: SE3) -> Navigation | None:
        """The way to an option, which becomes the aim."""
        aim = self._aim
        if aim is None or not self._aims_at(option.kind, option.xy):
            aim = self._aim = Aim(option.kind, option.xy)
        aim.xy = option.xy
        if option.kind == "frontier":
            reach = Reach(distance=self._config.frontier.stand_off, extent=costmap.grid.resolution)
            return self._navigate(option.xy, reach, costmap, T_map_base)
        side, height = option.seen_from, option.height
        reach = self._look_reach(height)
        return self._navigate(option.xy, reach, costmap, T_map_base, side, height)

    def _why(self, option: Option, options: Sequence[Option], T_map_base: SE3) -> str:
        """Why the robot is on its way to one of the options, in words."""
        if option.kind == "place":
            return self._verdicts.reason(option.xy, reasons.looking_closer(option, T_map_base))
        assert self._aim is not None
        self._aim.advantage = self._aim.advantage or reasons.advantage_of(option, options)
        return reasons.exploring(self._aim.advantage, options)

    def _aims_at(self, kind: str, xy: NDArray[np.float64]) -> bool:
        """Whether an option is the present aim."""
        return self._aim is not None and self._aim.is_at(kind, xy)

    def _navigate(
        self,
        goals_xy: NDArray[np.float64],
        reach: Reach,
        costmap: Costmap,
        T_map_base: SE3,
        seen_from: NDArray[np.float64] | None = None,
        heights: NDArray[np.floating] | float | None = None,
    ) -> Navigation | None:
        """The way to the point, or to the nearest of the points; None without one.

        With `heights` of things the robot stops where these are in the picture, or as far away as
        there is room.
        """
        goals = GoalPoints(goals_xy.reshape(-1, 2))
        if seen_from is not None:
            goals = replace(goals, seen_from=seen_from.reshape(-1, 2))
        if heights is not None and not self._wants_room:
            least = self._stops.least(np.atleast_1d(heights))
            goals = replace(goals, least=np.minimum(least, reach.distance - BAND))
        config, previous = self._config.navigator, self._previous
        while True:
            navigation = navigate(costmap, goals, T_map_base, reach, config, previous)
            if navigation is not None or goals.least is None or not goals.least.any():
                return navigation
            goals = replace(goals, least=np.maximum(goals.least - BAND, 0.0))


def _without(belief: PlaceBelief, places_xy: NDArray[np.float64]) -> PlaceBelief:
    """A belief with probability 0 at some places (N, 2) in `map` [m]."""
    if len(places_xy) == 0:
        return belief
    rows, columns = np.nonzero(belief.probabilities)
    away = np.linalg.norm(belief.xy(rows, columns)[:, None] - places_xy, axis=2)
    probabilities = belief.probabilities.copy()
    probabilities[rows, columns] *= away.min(axis=1) > APART
    return replace(belief, probabilities=probabilities)
