"""A summary of all views of a place in a few numbers, from which its log odds follow.

Views of one place are no independent witnesses: a hundred pictures of a wrong thing are wrong a
hundred times. So the evidence is not added up; a fitted rule joins means, best views and counts, of
views from near and from afar, of the place and of its neighbours.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.evidence import NEAR
from vizbot.core.program.kernels import kernel

FIELDS = 15
"""Number of values that are kept of a place."""
(
    _NEAR_SUM, _NEAR_COUNT, _BEST, _SECOND, _THIRD, _SPOTS, _LAST_SPOT,
    _FAR_SUM, _FAR_COUNT, _FAR_BEST, _LIKENESS, _VIEWS, _FROM_X, _FROM_Y, _HEIGHT,
) = range(FIELDS)  # fmt: skip
NAMES = (
    "seen from near", "mean of the three best near views", "mean of near views",
    "number of spots (log) of near views", "spots by mean of near views",
    "spots by mean of the three best", "seen from afar", "mean of far views", "best far view",
    "number of far views (log)", "number by mean of far views", "best near views of neighbours",
    "far views of neighbours", "mean of far views, where also seen from near",
    "best far view, where not seen from near",
    "number by mean of far views, where not seen from near", "best near views of surroundings",
    "a room is asked for", "neighbours by surroundings, near views", "constant",
)  # fmt: skip
"""Names of the features, in their order."""
_NONE = -99.0
"""Value that stands for a view that does not exist."""
NEIGHBOURS, SURROUNDINGS = 3, 9
"""Edges of the squares of places that count as neighbours, and as surroundings [places]."""


class PlaceViews:
    """The views of places, on a part of the plan that grows.

    Attributes:
        low: (2,) column, row of the first place, counted in places from the origin of the map.
    """

    def __init__(self) -> None:
        self.low = np.zeros(2, np.int64)
        self._places = _blank((0, 0))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of places."""
        return self._places.shape[0], self._places.shape[1]

    def add(
        self,
        places: NDArray[np.int64],
        evidence: NDArray[np.float32],
        likeness: NDArray[np.float32],
        ranges: NDArray[np.float32],
        spots: NDArray[np.int64],
        cameras_xy: NDArray[np.float32],
        heights: NDArray[np.float32],
    ) -> None:
        """Add views, in the order in which they were taken.

        Args:
            places: (R, 2) column, row of the place that each shows, from the origin of the map.
            evidence: (R,) of each view [log odds].
            likeness: (R,) of what the camera saw around the place to what is asked for.
            ranges: (R,) distance of the place from the camera on the plan [m].
            spots: (R,) number of the spot that the camera stood on.
            cameras_xy: (R, 2) where it stood, in `map` [m].
            heights: (R,) of what each shows there [m].
        """
        if len(places) == 0:
            return
        self._make_room(places.min(axis=0), places.max(axis=0) + 1)
        _fold(
            self._places, places - self.low, evidence, likeness, ranges, spots, cameras_xy, heights
        )

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Places (rows, cols) that some view shows."""
        return np.asarray(self._places[..., _VIEWS] > 0)

    @property
    def seen_from(self) -> NDArray[np.float32]:
        """Where the camera stood (rows, cols, 2) when it saw each place best, in `map` [m].

        Best is the view that speaks most for it, of those from near where there are any.
        """
        return np.asarray(self._places[..., _FROM_X : _FROM_Y + 1])

    @property
    def heights(self) -> NDArray[np.float32]:
        """Height (rows, cols) of what the best view shows there [m].

        Best is the view that speaks most for the place, of those from near where one speaks for it:
        the others show what is beneath a thing that is out of the picture.
        """
        return np.asarray(self._places[..., _HEIGHT])

    @property
    def likeness(self) -> NDArray[np.float32]:
        """Mean likeness (rows, cols) around each place; 0 where it was not seen."""
        return np.asarray(self._places[..., _LIKENESS] / np.maximum(self._places[..., _VIEWS], 1.0))

    def features(self, room: bool) -> NDArray[np.float32]:
        """The features of every place (rows, cols, 20); a `room` is shown by many more places."""
        p = self._places
        near, far = (p[..., i] > 0 for i in (_NEAR_COUNT, _FAR_COUNT))
        is_near, is_far = near.astype(np.float32), far.astype(np.float32)
        near_mean = p[..., _NEAR_SUM] / np.maximum(p[..., _NEAR_COUNT], 1.0)
        far_mean = p[..., _FAR_SUM] / np.maximum(p[..., _FAR_COUNT], 1.0)
        three = p[..., _BEST : _THIRD + 1]
        there = (three > _NONE).astype(np.float32)
        top = (three * there).sum(axis=-1) / np.maximum(there.sum(axis=-1), 1.0)
        far_best = np.where(far, p[..., _FAR_BEST], 0.0)
        spots, views = np.log1p(p[..., _SPOTS]), np.log1p(p[..., _FAR_COUNT])
        beside = around(top, is_near, NEIGHBOURS)
        about = around(top, is_near, SURROUNDINGS)
        columns = (
            is_near, is_near * top, is_near * near_mean, is_near * spots,
            is_near * spots * near_mean, is_near * spots * top,
            is_far, is_far * far_mean, is_far * far_best, is_far * views, is_far * views * far_mean,
            beside, around(far_mean, is_far, NEIGHBOURS), is_near * is_far * far_mean,
            (1.0 - is_near) * far_best, (1.0 - is_near) * views * far_mean,
            about, np.full_like(is_near, room), beside * about,
            np.ones_like(is_near),
        )  # fmt: skip
        return np.stack(columns, axis=-1).astype(np.float32)

    def _make_room(self, low: NDArray[np.int64], end: NDArray[np.int64]) -> None:
        """Have places from `low` to before `end` (2,) column, row."""
        rows, columns = self.shape
        if rows == 0:
            self.low = low.copy()
        new_low = np.minimum(self.low, low)
        new_end = np.maximum(self.low + np.array([columns, rows]), end)
        if (new_low == self.low).all() and (new_end == self.low + np.array([columns, rows])).all():
            return
        grown = _blank((int(new_end[1] - new_low[1]), int(new_end[0] - new_low[0])))
        left, top = self.low - new_low
        grown[top : top + rows, left : left + columns] = self._places
        self.low, self._places = new_low, grown


def _blank(shape: tuple[int, int]) -> NDArray[np.float32]:
    """Values of places that were not seen."""
    places = np.zeros((*shape, FIELDS), np.float32)
    places[..., _BEST : _THIRD + 1] = _NONE
    places[..., [_FAR_BEST, _LAST_SPOT]] = _NONE
    return places


def around(
    values: NDArray[np.floating], there: NDArray[np.float32], edge: int
) -> NDArray[np.float32]:
    """Mean of the values that are there, in a square of places around each; 0 without any."""
    if there.size == 0:  # which OpenCV refuses
        return there
    size = (edge, edge)
    total = cv2.blur((values * there).astype(np.float32), size, borderType=cv2.BORDER_CONSTANT)
    count = cv2.blur(there, size, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(total / np.maximum(count, 1e-3))


@kernel("void(f4[:,:,::1], i8[:,::1], f4[::1], f4[::1], f4[::1], i8[::1], f4[:,::1], f4[::1])")
def _fold(
    kept: NDArray[np.float32],
    places: NDArray[np.int64],
    evidence: NDArray[np.float32],
    likeness: NDArray[np.float32],
    ranges: NDArray[np.float32],
    spots: NDArray[np.int64],
    cameras_xy: NDArray[np.float32],
    heights: NDArray[np.float32],
) -> None:
    """Add views to the values that are kept of their places."""
    for i in range(len(places)):
        place = kept[places[i, 1], places[i, 0]]
        odds = evidence[i]
        place[_VIEWS] += 1
        place[_LIKENESS] += likeness[i]
        near = ranges[i] <= NEAR
        best = place[_BEST] if near else place[_FAR_BEST]
        if odds > best and (near or place[_NEAR_COUNT] == 0):
            place[_FROM_X], place[_FROM_Y] = cameras_xy[i, 0], cameras_xy[i, 1]
        if not near or odds <= 0.0:
            best = np.inf if place[_BEST] > 0.0 else max(place[_BEST], place[_FAR_BEST])
        if odds > best:
            place[_HEIGHT] = heights[i]
        if not near:
            place[_FAR_SUM] += odds
            place[_FAR_COUNT] += 1
            place[_FAR_BEST] = max(place[_FAR_BEST], odds)
            continue
        place[_NEAR_SUM] += odds
        place[_NEAR_COUNT] += 1
        if place[_LAST_SPOT] != spots[i]:
            place[_SPOTS] += 1
            place[_LAST_SPOT] = spots[i]
        for rank in range(_BEST, _THIRD + 1):
            if odds > place[rank]:
                odds, place[rank] = place[rank], odds
