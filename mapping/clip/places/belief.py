"""Belief: for every place seen so far, the probability that it is what is asked for.

It is kept up to date with a growing map: only new elements are scored and only new views are
weighed, and what stays of a question is the evidence of each view. All views that count are put
together anew each time, so that views may move, and grow old. A place that is more probably another
room is believed less.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import GrowingRows
from mapping.clip.places.evidence import Weights, evidence, features
from mapping.clip.places.footprint import PLACE
from mapping.clip.places.place_rows import PlacedRows, PlaceRows
from mapping.clip.places.place_views import PlaceViews, around
from mapping.clip.places.view_age import NEAR_LOOK
from mapping.clip.scores import Query

SPEAKS = 2.0
"""Evidence of a view that speaks for what is asked for [log odds]."""
ROOM = 21
"""Edge of the square of places whose average says which room this is [places]. In training homes
916 to 931 it removes six in seven of the wrong places that were believed, and keeps 97 % of the
rooms."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaceBelief:
    """The belief about the places on a part of the plan.

    Attributes:
        low: (2,) column, row of the first place, counted from the origin of the map.
        probabilities: (rows, cols) that the place shows what is asked for; 0 where it was not seen.
        likeness: (rows, cols) of what was seen around it to what is asked for, about 0; 0 where
            nothing was seen.
        seen: (rows, cols) whether it was seen.
        seen_from: (rows, cols, 2) where the camera stood when it saw it best, in `map` [m].
        heights: (rows, cols) of what the camera saw there, as of `PlaceViews.heights` [m].
    """

    low: NDArray[np.int64]
    probabilities: NDArray[np.float64]
    likeness: NDArray[np.float32]
    seen: NDArray[np.bool_]
    seen_from: NDArray[np.float64]
    heights: NDArray[np.float32]

    def xy(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.float64]:
        """Centres (N, 2) of places in `map` [m]."""
        return np.asarray((np.stack([columns, rows], axis=1) + self.low + 0.5) * PLACE, np.float64)


class Belief:
    """The belief for one question."""

    def __init__(self, question: Query, weights: Weights, *, room: bool = False) -> None:
        """Begin with nothing seen; a `room` that is asked for has rivals."""
        self._question, self._weights = question, weights
        self._room = room or len(question.rivals) > 0
        self._frames: NDArray[np.int32] = np.zeros(0, np.int32)
        self._evidence = GrowingRows(np.zeros(0, np.float16))
        self._likeness = GrowingRows(np.zeros(0, np.float16))
        rivals = (Query(each, question.log_odds) for each in question.rivals)
        self._rivals = [Belief(each, weights, room=True) for each in rivals]

    def update(
        self,
        embeddings: NDArray[np.float32],
        statistics: NDArray[np.float32],
        pictures: NDArray[np.float32],
        rows: PlaceRows,
        placed: PlacedRows,
    ) -> PlaceBelief:
        """What is believed now.

        Args:
            embeddings: (N, D) of the map's elements; those of the call before come first, but for
                those of frames that have left the map.
            statistics: (N, 2) of them, as of `Background.statistics`.
            pictures: (B, D) of the bank, as of `Background.pictures`; the same in every call.
            rows: The views of places; likewise.
            placed: Where those are now.
        """
        self._leave_out(rows.frames)
        self._frames = rows.frames
        weighed, weights = len(self._evidence), self._weights
        patches, ranges = rows.elements[weighed:], rows.ranges[weighed:]
        first = int(patches.min(initial=len(embeddings)))
        scores = self._question.scores(embeddings[first:], statistics[first:])
        patches = patches - first
        tail = self._question.tail(pictures)
        found = features(scores, patches, ranges, rows.shares[weighed:], tail)
        self._evidence.add(evidence(found, ranges, weights.near, weights.far).astype(np.float16))
        self._likeness.add(scores[patches[:, 2], 1].astype(np.float16))
        believed = self._believed(rows, placed)
        others = [
            each.update(embeddings, statistics, pictures, rows, placed) for each in self._rivals
        ]
        return against_rivals(believed, others)

    def _leave_out(self, frames: NDArray[np.int32]) -> None:
        """Forget the evidence of rows whose frames have left the map, of all frames (R,) now."""
        known = len(self._evidence)
        if np.array_equal(frames[:known], self._frames):
            return
        kept = np.isin(self._frames, frames)
        if not np.array_equal(frames[: np.count_nonzero(kept)], self._frames[kept]):
            kept[:] = False  # another map
        self._evidence = GrowingRows(self._evidence.rows[kept])
        self._likeness = GrowingRows(self._likeness.rows[kept])

    def _believed(self, rows: PlaceRows, placed: PlacedRows) -> PlaceBelief:
        views, found = PlaceViews(), self._evidence.rows.astype(np.float32)
        valid = _valid_rows(found, rows, placed)
        views.add(
            placed.places[valid],
            found[valid],
            self._likeness.rows[valid].astype(np.float32),
            rows.ranges[valid],
            rows.spots[valid].astype(np.int64),
            placed.cameras_xy[valid],
            placed.heights[valid],
        )
        odds = views.features(self._room) @ self._weights.join
        probabilities = np.where(views.seen, 1.0 / (1.0 + np.exp(-np.clip(odds, -30.0, 30.0))), 0.0)
        seen_from = views.seen_from.astype(np.float64)
        return PlaceBelief(
            views.low, probabilities, views.likeness, views.seen, seen_from, views.heights.copy()
        )


def _valid_rows(
    evidence: NDArray[np.float32], rows: PlaceRows, placed: PlacedRows
) -> NDArray[np.intp] | slice:
    """Which views count, of this evidence (R,).

    Older ones do where what was seen later from near speaks for the question, too: what is still
    there was seen best by all of them together, and what has gone by none of the later ones.
    """
    age = placed.age
    if not (age.retaken.any() or age.doubted.any()):
        return slice(None)
    low = placed.places.min(axis=0)
    columns, lines = placed.places.max(axis=0) - low + 1
    cells = (placed.places[:, 1] - low[1]) * columns + placed.places[:, 0] - low[0]
    later = np.flatnonzero((rows.ranges <= NEAR_LOOK) & ~age.doubted & ~age.retaken)
    speaks_most = np.full(columns * lines, -np.inf, np.float32)
    np.maximum.at(speaks_most, cells[later], evidence[later])
    in_vain = age.doubted & (speaks_most[cells] <= SPEAKS)
    return np.flatnonzero(~(age.retaken | in_vain))


def against_rivals(believed: PlaceBelief, rivals: Sequence[PlaceBelief]) -> PlaceBelief:
    """A belief, lowered where its rivals, what a place may be instead, are believed more."""
    if not rivals:
        return believed
    others = [each.probabilities for each in rivals]
    probabilities = unless_another(believed.probabilities, believed.seen, others)
    return replace(believed, probabilities=probabilities)


def unless_another(
    probabilities: NDArray[np.float64],
    seen: NDArray[np.bool_],
    rivals: Sequence[NDArray[np.float64]],
) -> NDArray[np.float64]:
    """Probabilities, lowered where a rival is more probable on average around the place.

    Args:
        probabilities: (rows, cols) of places.
        seen: (rows, cols) whether a place was seen.
        rivals: (rows, cols) of each of what they may be instead.
    """
    there = seen.astype(np.float32)
    own, *others = (around(each, there, ROOM) for each in (probabilities, *rivals))
    greatest = np.maximum.reduce(others)
    share = np.divide(own, greatest, out=np.ones_like(own), where=greatest > own)
    return probabilities * share
