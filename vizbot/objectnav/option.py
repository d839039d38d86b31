"""What the search may do next (options), and what it does now (the aim)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vizbot.objectnav.looks import APART


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """Something that may end the search.

    Attributes:
        kind: "place" or "frontier".
        xy: (2,) in `map` [m].
        probability: Probability that it does.
        way: Length of the way to it, in metres of free floor.
        seen_from: (2,) where the camera stood when it saw a place best; None where the robot may
            come from any side.
        height: Height of what the camera saw at a place [m].
        area: Unseen area behind a frontier, as far as it counts [m^2].
        likeness: Likeness to the goal of what was seen beside a frontier [standard deviations].
    """

    kind: str
    xy: NDArray[np.float64]
    probability: float
    way: float
    seen_from: NDArray[np.float64] | None = None
    height: float = 0.0
    area: float = 0.0
    likeness: float = 0.0


@dataclass(slots=True, eq=False)
class Aim:
    """What the robot does now.

    Attributes:
        kind: "place", "frontier", or "stop" for a place that the robot is sure of.
        xy: (2,) where it is, in `map` [m].
        sure: Probability that a place of kind "stop" had to have when it became the aim.
        looking: Steps for which the robot has stood before it, facing it.
        advantage: Why this frontier was chosen among the others, in words; empty for other kinds.
    """

    kind: str
    xy: NDArray[np.float64]
    sure: float = 1.0
    looking: int = 0
    advantage: str = ""

    def is_at(self, kind: str, xy: NDArray[np.float64]) -> bool:
        """Whether the aim is this one at (2,) in `map` [m]; its point moves as more is seen."""
        return self.kind == kind and bool(np.linalg.norm(self.xy - xy) <= APART)
