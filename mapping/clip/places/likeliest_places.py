"""The places of a map that most probably are what is asked for, and the elements that show them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import Belief, PlaceBelief
from mapping.clip.places.place_rows import PlaceMap
from mapping.clip.retrieval import best, similarities
from mapping.clip.scores import Query
from mapping.keyframes.anchors import points_in_map
from vizbot.core.types import SE3

_NOWHERE = np.iinfo(np.int64).min
"""Stands for the place of a view that counts no longer."""
MOST = 5
"""A question to a whole map has at most this number of answers."""
APART = 0.8
"""Answers are at least this far apart [m]."""
SPREAD = 0.7
"""Standard deviation of the average of probabilities by which places are chosen [places]. The
likeliest place of a thing is often one at its edge; its middle is likely all around. In the homes
of the list of `vizbot calibrate encoder` the share of first places that are right goes from 0.62 to
0.65 with `embedded`, and from 0.32 to 0.34 with `photos` (469 questions)."""


@dataclass(frozen=True, slots=True, eq=False)
class LikelyPlace:
    """A place that may show what is asked for.

    Attributes:
        position: (3,) of what a view shows there, in `map` [m].
        probability: Probability that it is what is asked for.
        element: Row of the map's element that shows it best.
        seen_at: When it was last seen, UTC [s since 1970].
    """

    position: NDArray[np.float64]
    probability: float
    element: int
    seen_at: float


def belief_of_map(
    views: PlaceMap,
    keyframe_poses: Mapping[int, SE3],
    embeddings: NDArray[np.float32],
    statistics: NDArray[np.float32],
    pictures: NDArray[np.float32],
    question: Query,
) -> PlaceBelief:
    """The belief about the places of a whole map.

    Args:
        views: The views of places.
        keyframe_poses: T_map_cam of every keyframe.
        embeddings: (N, D) of the map's elements.
        statistics: (N, 2) of them, as of `Background.statistics`.
        pictures: (B, D) of the bank, as of `Background.pictures`.
        question: What is asked for.
    """
    placed = views.placed(keyframe_poses)
    belief = Belief(question, question.weights)
    return belief.update(embeddings, statistics, pictures, views.rows, placed)


def likeliest_places(
    belief: PlaceBelief,
    views: PlaceMap,
    keyframe_poses: Mapping[int, SE3],
    embeddings: NDArray[np.float32],
    question: Query,
    first_xy: NDArray[np.float64] | None = None,
) -> list[LikelyPlace]:
    """The likeliest places of a map, at most `MOST`, the likeliest first.

    Arrays and poses are as for `belief_of_map`; `first_xy` (2,) in `map` [m] comes before all
    others.
    """
    rows, placed, frames = views.rows, views.placed(keyframe_poses), views.frames
    places = np.where(placed.age.retaken[:, None], _NOWHERE, placed.places)
    row_of, column_of = np.nonzero(belief.seen)
    if len(row_of) == 0:
        return []
    likely = belief.probabilities.astype(np.float32)
    ranks = cv2.GaussianBlur(likely, (0, 0), SPREAD)[row_of, column_of]
    probabilities = likely[row_of, column_of]
    places_xy = belief.xy(row_of, column_of)
    order = probabilities.copy()
    if first_xy is not None:
        first = np.argmin(np.linalg.norm(places_xy - first_xy, axis=1))
        ranks[first] = order[first] = 2.0
    found = []
    chosen = best(ranks, places_xy, MOST, APART)
    for i in chosen[np.argsort(-order[chosen], kind="stable")].tolist():
        place = belief.low + np.array([column_of[i], row_of[i]])
        there = np.flatnonzero((places == place).all(axis=1))
        elements = rows.elements[there]
        cosines = similarities(embeddings[elements.ravel()], question.embedding)
        row, scale = np.unravel_index(cosines.argmax(), elements.shape)
        view = there[[row]]
        position = points_in_map(rows.points_keyframe[view], rows.keyframes[view], keyframe_poses)[
            0
        ]
        seen_at = float(frames.times[frames.rows_of(rows.frames[there[-1:]])][0])
        probability, element = float(probabilities[i]), int(elements[row, scale])
        found.append(LikelyPlace(position, probability, element, seen_at))
    return found
