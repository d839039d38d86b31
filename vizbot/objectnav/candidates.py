"""Places on the map where a goal may be, and similarities to it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.clip.belief import PlaceBelief
from mapping.clip.footprint import PLACE
from mapping.clip.growing_rows import GrowingRows
from mapping.clip.likeliest_places import likeliest_places
from mapping.clip.retrieval import similarities
from mapping.clip.scores import Query
from vizbot.core.observer import Candidate
from vizbot.core.place_scores import UNSEEN, PlaceScores
from vizbot.objectnav.tasks import Goal
from vizbot.perception.perception import Perception
from vizbot.perception.sightings import Sightings


def most_similar_places(
    perception: Perception, goal: Goal, answer: int | None = None
) -> tuple[Candidate, ...]:
    """The places that are most similar to a goal (paper, section III-B), best first.

    Args:
        perception: Holds the CLIP map.
        goal: What is looked for.
        answer: Index of the element that the robot has arrived at: its place comes first.
    """
    elements = perception.clip_map.elements
    sightings = perception.sightings(similarities(elements.embeddings, goal.embedding))
    return tuple(
        Candidate(
            sightings.points[i],
            float(sightings.similarities[i]),
            int(elements.frames[i]),
            elements.boxes[i],
        )
        for i in sightings.answers(answer)
    )


def believed_places(
    perception: Perception,
    belief: PlaceBelief,
    question: Query,
    answer_xy: NDArray[np.float64] | None = None,
) -> tuple[Candidate, ...]:
    """The most probable places for a question, best first.

    Args:
        perception: Holds the CLIP map.
        belief: What is believed of its places.
        question: What is looked for.
        answer_xy: (2,) where the robot has arrived, in `map` [m]: it comes first.
    """
    elements = perception.clip_map.elements
    likeliest = likeliest_places(
        belief,
        perception.places,
        perception.slam.keyframe_poses(),
        elements.embeddings,
        question,
        answer_xy,
    )
    return tuple(
        Candidate(
            place.position,
            place.probability,
            int(elements.frames[place.element]),
            elements.boxes[place.element],
        )
        for place in likeliest
    )


def scores_of(seen: PlaceBelief | Sightings) -> PlaceScores:
    """What a search decides by, as people are shown it."""
    if isinstance(seen, Sightings):
        return PlaceScores.of_points(seen.points, seen.similarities, PLACE)
    values = np.where(seen.seen, seen.probabilities, UNSEEN).astype(np.float32)
    return PlaceScores(seen.low, PLACE, values)


class RunningScores:
    """Similarities of the elements of a growing CLIP map, each computed once for a goal."""

    def __init__(self) -> None:
        self._goal: Goal | None = None
        self._scores = GrowingRows(np.zeros(0, np.float32))

    def similarities_to(self, goal: Goal, embeddings: NDArray[np.float32]) -> NDArray[np.float32]:
        """Similarities (N,) to a goal.

        Args:
            goal: One other than that of the previous call begins anew.
            embeddings: (N, D) unit; they begin with those of the previous call.
        """
        if goal is not self._goal:
            self._goal, self._scores = goal, GrowingRows(np.zeros(0, np.float32))
        fresh = embeddings[len(self._scores) :]
        self._scores.add(similarities(fresh, goal.embedding))
        return self._scores.rows
