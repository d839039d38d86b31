"""The search for a goal on one map, by either method."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from nav.navigator import Navigation
from vizbot.core.observer import Candidate
from vizbot.core.place_scores import Measure, PlaceScores
from vizbot.core.types import SE3, OccupancyGrid
from vizbot.objectnav.tasks import Decision, Goal

if TYPE_CHECKING:  # a search may be made without a camera
    from vizbot.perception.perception import Perception


class Search(Protocol):
    """Searches for one goal after another on one map.

    Attributes:
        measure: What its scores are.
        assisted: Whether the robot looks around before its first step, and tries once more before
            the search ends in vain.
    """

    measure: ClassVar[Measure]
    assisted: ClassVar[bool]

    def observe(self, goal: Goal, perception: Perception) -> PlaceScores:
        """Take what the map shows of a goal now, and return what the search decides by."""
        ...

    def decide(self, goal: Goal, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        """Do one step; another `goal` than in the step before begins a new search."""
        ...

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        ...

    def leave_alone(self, places_xy: NDArray[np.float64]) -> None:
        """Go to none of these places (B, 2) in `map` [m] for now."""
        ...

    def place_of(self, navigation: Navigation) -> NDArray[np.float64] | None:
        """The place (2,) in `map` [m] that a way of this search leads to; None without one."""
        ...

    def threshold(self, goal: Goal) -> float:
        """The threshold of the newest decision for a goal, or of the first one to come."""
        ...

    def found_above(self, goal: Goal) -> float:
        """The score above which a place on the map answers a goal without driving there."""
        ...

    def candidates(
        self, goal: Goal, perception: Perception, *, arrived: bool = False
    ) -> tuple[Candidate, ...]:
        """The best places for a goal, best first; where the robot has arrived comes before them."""
        ...

    def candidate(self, place_xy: NDArray[np.float64]) -> Candidate | None:
        """The place of the present search that is nearest to (2,) a point in `map` [m].

        Returns:
            None where nothing is searched for, or nothing was seen.

        Raises:
            ConfigError: this search has no beliefs.
        """
        ...

    def refute(self, place_xy: NDArray[np.float64] | None = None) -> None:
        """Note that a place is not the goal, and let the search go on.

        Every search for the same words on this map believes it less.

        Args:
            place_xy: (2,) in `map` [m]; None for the place where the robot has arrived.

        Raises:
            ConfigError: this search has no beliefs.
        """
        ...

    def affirm(self, place_xy: NDArray[np.float64]) -> None:
        """Note, for this search, that the goal is at (2,) a place in `map` [m].

        Raises:
            ConfigError: this search has no beliefs.
        """
        ...
