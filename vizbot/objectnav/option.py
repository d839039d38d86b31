"""What the search may do next, and what it does now."""

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
        probability: That it does.
        way: What it takes, in metres of free floor.
        spot_xy: (2,) from where a place is looked at that was looked at before; else None.
        seen_from: (2,) where the camera stood when it saw a place best; None where the robot may
            come from any side.
        area: What is unseen behind a frontier, as far as it counts [m^2].
        likeness: To the goal, of what was seen beside a frontier [standard deviations].
    """

    kind: str
    xy: NDArray[np.float64]
    probability: float
    way: float
    spot_xy: NDArray[np.float64] | None = None
    seen_from: NDArray[np.float64] | None = None
    area: float = 0.0
    likeness: float = 0.0


@dataclass(slots=True, eq=False)
class Aim:
    """What the robot does now.

    Attributes:
        kind: "place", "frontier", or "stop" for a place that the robot is sure of.
        xy: (2,) where that is, in `map` [m].
        spot_xy: (2,) from where it is looked at next; None for anywhere within reach.
        sure: Probability that a place of kind "stop" had to have when it became the aim.
        looking: Steps for which the robot has stood before it, facing it.
        advantage: Of the frontier over the other ones when it was chosen, in words; else empty.
    """

    kind: str
    xy: NDArray[np.float64]
    spot_xy: NDArray[np.float64] | None = None
    sure: float = 1.0
    looking: int = 0
    advantage: str = ""

    def is_at(self, kind: str, xy: NDArray[np.float64]) -> bool:
        """Whether it is this, at (2,) in `map` [m]; as more is seen, the point of it moves."""
        return self.kind == kind and bool(np.linalg.norm(self.xy - xy) <= APART)
