"""What people have said of the places that the robot approached."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import PlaceBelief
from vizbot.objectnav import reasons
from vizbot.objectnav.looks import APART
from vizbot.objectnav.tasks import Goal

REFUTED = 0.05
"""Factor on the probability of a place that somebody has said is not the goal."""
OF_ROOM = 2.0
"""Places within this distance of a place that is not in the wanted room are not in it either [m]:
half of the width of a common room, beyond which the right one may begin."""


class Verdicts:
    """Places that are not what was searched for, by its words, and the one that is.

    The former hold for every search for the same words, the latter for the present one. They stay
    where they were said: a correction of the map moves what was seen by centimetres, and a place
    counts as the same within `APART`.
    """

    def __init__(self) -> None:
        self._refuted: dict[str, list[NDArray[np.float64]]] = {}
        self._affirmed_xy: NDArray[np.float64] | None = None

    def refute(self, text: str, place_xy: NDArray[np.float64]) -> None:
        """Note that (2,) a place in `map` [m] is not what these words ask for."""
        self._refuted.setdefault(text, []).append(place_xy)

    def affirm(self, place_xy: NDArray[np.float64]) -> None:
        """Note that the present goal is at (2,) a place in `map` [m]."""
        self._affirmed_xy = place_xy

    def forget_affirmed(self) -> None:
        """Another search begins, or goes on elsewhere."""
        self._affirmed_xy = None

    def applied(self, belief: PlaceBelief, goal: Goal, *, searching: bool) -> PlaceBelief:
        """A belief after these verdicts: refuted places lose most of it, affirmed ones are sure."""
        refuted = self._refuted.get(goal.text, [])
        affirmed_xy = self._affirmed_xy if searching else None
        if not refuted and affirmed_xy is None:
            return belief
        rows, columns = np.nonzero(belief.probabilities)
        places_xy, judged = belief.xy(rows, columns), belief.probabilities[rows, columns]
        if refuted:
            apart = OF_ROOM if goal.is_room else APART
            away = np.linalg.norm(places_xy[:, None] - np.array(refuted), axis=2)
            judged *= np.where(away.min(axis=1) <= apart, REFUTED, 1.0)
        if affirmed_xy is not None:
            there = np.linalg.norm(places_xy - affirmed_xy, axis=1) <= APART
            judged[there] /= judged[there].max(initial=0.0)
        probabilities = belief.probabilities.copy()
        probabilities[rows, columns] = judged
        return replace(belief, probabilities=probabilities)

    def reason(self, place_xy: NDArray[np.float64], seen: str) -> str:
        """Why to go to (2,) a place: what was seen of it, unless it was affirmed."""
        affirmed_xy = self._affirmed_xy
        if affirmed_xy is None or np.linalg.norm(affirmed_xy - place_xy) > APART:
            return seen
        return reasons.AFFIRMED
