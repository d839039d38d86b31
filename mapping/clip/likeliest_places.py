"""The places of a map that most probably show what is asked for, and what shows each of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.clip.belief import Belief
from mapping.clip.place_rows import PlaceMap
from mapping.clip.retrieval import best, similarities
from mapping.clip.scores import Query
from mapping.clip.weights import fitted_weights
from mapping.keyframes.anchors import points_in_map
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class LikelyPlace:
    """A place that may show what is asked for.

    Attributes:
        position: (3,) of what a view shows there, in `map` [m].
        probability: That it is what is asked for.
        element: Row of the map's element that shows it best.
    """

    position: NDArray[np.float64]
    probability: float
    element: int


def likeliest_places(
    views: PlaceMap,
    keyframe_poses: Mapping[int, SE3],
    embeddings: NDArray[np.float32],
    statistics: NDArray[np.float32],
    question: Query,
    count: int,
    spacing: float,
) -> list[LikelyPlace]:
    """The likeliest places of a map, the likeliest first.

    Args:
        views: The views of places.
        keyframe_poses: T_map_cam of every keyframe.
        embeddings: (N, D) of the map's elements.
        statistics: (N, 2) of them, as of `Background.statistics`.
        question: What is asked for.
        count: How many at most.
        spacing: Least distance on the plan between any two of them [m].
    """
    rows, places = views.rows, views.places(keyframe_poses)
    belief = Belief(question, fitted_weights()).update(
        embeddings, statistics, rows, places, views.moved
    )
    row_of, column_of = np.nonzero(belief.seen)
    probabilities = belief.probabilities[row_of, column_of].astype(np.float32)
    found = []
    for i in best(probabilities, belief.xy(row_of, column_of), count, spacing).tolist():
        place = belief.low + np.array([column_of[i], row_of[i]])
        there = np.flatnonzero((places == place).all(axis=1))
        elements = rows.elements[there]
        cosines = similarities(embeddings[elements.ravel()], question.embedding)
        row, scale = np.unravel_index(cosines.argmax(), elements.shape)
        chosen = there[[row]]
        position = points_in_map(
            rows.points_keyframe[chosen], rows.keyframes[chosen], keyframe_poses
        )[0]
        found.append(LikelyPlace(position, float(probabilities[i]), int(elements[row, scale])))
    return found
