"""Where on the map of a running robot the rooms of a household are."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import PlaceBelief
from mapping.clip.places.footprint import PLACE
from mapping.map_bundle import MapBundle
from vizbot.core.home_vocabulary import ROOMS
from vizbot.operator.session.household import HouseholdBeliefs
from vizbot.pipeline import Pipeline

_LEAST_AREA = 1.5
"""Area of places that make a room [m^2]."""
_GAP = 1.0
"""Places of one room are at most this far apart [m]."""
_MOST = 20
_PERIOD = 10.0
"""An answer is given again for so long [s]."""


@dataclass(frozen=True, slots=True)
class RoomArea:
    """A part of the plan that most probably belongs to a room.

    Attributes:
        position: x, y in `map` of a place about in its middle [m].
    """

    name: str
    position: tuple[float, float]


class RoomAreas:
    """The rooms on a growing map; it may be asked by several threads."""

    def __init__(
        self, household: HouseholdBeliefs, now: Callable[[], float] = time.monotonic
    ) -> None:
        self._now = now
        self._lock = threading.Lock()
        self._household = household
        self._found: list[RoomArea] = []
        self._found_at, self._map = 0.0, -1

    def found(
        self, number: int, whole: Callable[[], tuple[MapBundle | None, int, Pipeline]]
    ) -> list[RoomArea]:
        """The rooms that the map shows, the largest first.

        `number` counts the maps of the run: an answer about another one is not given again. `whole`
        reads the map as it is now, its number, and what answers questions about it.
        """
        with self._lock:
            now = self._now()
            if number != self._map or now - self._found_at >= _PERIOD:
                bundle, self._map, pipeline = whole()
                self._found = []
                if bundle is not None:
                    beliefs = self._household.believed(tuple(ROOMS), bundle, self._map, pipeline)
                    self._found = room_areas(beliefs, pipeline.config.objectnav.answer_probability)
                self._found_at = now
            return self._found


def room_areas(beliefs: dict[str, PlaceBelief], least: float) -> list[RoomArea]:
    """The parts of the plan that most probably belong to each room, the largest first.

    A place belongs to the room that it most probably shows.

    `beliefs` are of the same places; the probability of a place has to exceed `least`.
    """
    names = list(beliefs)
    if not names:
        return []
    probabilities = np.stack([beliefs[name].probabilities for name in names])
    if probabilities.size == 0:
        return []
    likeliest, enough = probabilities.argmax(axis=0), probabilities.max(axis=0) > least
    areas = []
    for index, name in enumerate(names):
        for places in _parts(enough & (likeliest == index)):
            position = beliefs[name].xy(*places)[_middle(places)]
            areas.append((len(places[0]), RoomArea(name, (float(position[0]), float(position[1])))))
    areas.sort(key=lambda area: -area[0])
    return [area for _, area in areas[:_MOST]]


def _parts(belongs: NDArray[np.bool_]) -> Sequence[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Rows and columns of the places of each part that is large enough."""
    width = 2 * round(_GAP / 2 / PLACE) + 1
    near = cv2.dilate(belongs.astype(np.uint8), np.ones((width, width), np.uint8))
    count, labels = cv2.connectedComponents(near)
    parts = [np.nonzero(belongs & (labels == label)) for label in range(1, count)]
    return [(rows, cols) for rows, cols in parts if len(rows) * PLACE**2 >= _LEAST_AREA]


def _middle(places: tuple[NDArray[np.intp], NDArray[np.intp]]) -> int:
    """Which of some places is the nearest to the mean of all."""
    offsets = np.stack(places, axis=1) - np.mean(places, axis=1)
    return int(np.argmin(np.linalg.norm(offsets, axis=1)))
