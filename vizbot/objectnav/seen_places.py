"""Places that a belief holds for likely, and what the robot has to know to stop before one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import PlaceBelief
from nav.costmap import Costmap
from nav.goal_region import fronts
from vizbot.objectnav.stops import EXTENT

AROUND = 1.6
"""Distance of places that one patch may show [m]: what stands before a thing is believed for its
sake, and the robot approaches the thing."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenPlaces:
    """Places that are likely enough.

    Attributes:
        xy: (N, 2) in `map` [m].
        probabilities: (N,) that each is what is asked for.
        seen_from: (N, 2) where the camera stood when it saw each best, in `map` [m].
        heights: (N,) of what it saw there [m].
        fronts_xy: (N, 2) points in front of them, on the side they were seen from, in `map` [m].
            Where nothing stands there, it is the point on the line of sight that is as far from the
            place as an object in it may reach.
        known: (N,) whether the point in front is known to be free.
    """

    xy: NDArray[np.float64]
    probabilities: NDArray[np.float64]
    seen_from: NDArray[np.float64]
    heights: NDArray[np.floating]
    fronts_xy: NDArray[np.float64]
    known: NDArray[np.bool_]

    @staticmethod
    def from_belief(belief: PlaceBelief, least: float, costmap: Costmap) -> SeenPlaces:
        """The places that have at least this probability."""
        rows, columns = np.nonzero(belief.probabilities >= least)
        xy, seen_from = belief.xy(rows, columns), belief.seen_from[rows, columns]
        fronts_xy, known = fronts(costmap, xy, seen_from, EXTENT)
        back = seen_from - xy
        length = np.linalg.norm(back, axis=1)
        back *= (np.minimum(EXTENT, length) / np.maximum(length, 1e-9))[:, None]
        return SeenPlaces(
            xy,
            belief.probabilities[rows, columns],
            seen_from,
            belief.heights[rows, columns],
            np.where(known[:, None], fronts_xy, xy + back),
            known,
        )

    def within(self, distance: float, point_xy: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which places (N,) are within a distance of a point (2,) [m]."""
        return np.asarray(np.linalg.norm(self.xy - point_xy, axis=1) <= distance)

    def likeliest_around(self, place: int) -> int:
        """The likeliest place around one if its doubt is at most half as large, else that one."""
        around, doubt = self.within(AROUND, self.xy[place]), 1.0 - self.probabilities
        likeliest = int(np.argmax(np.where(around, self.probabilities, 0.0)))
        return likeliest if doubt[likeliest] <= doubt[place] / 2 else place
