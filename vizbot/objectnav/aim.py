"""What the search does now."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vizbot.objectnav.looks import APART


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
