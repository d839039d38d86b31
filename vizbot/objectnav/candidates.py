"""Places on the map where a goal may be, and similarities to it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.clip.likeliest_places import likeliest_places
from mapping.clip.retrieval import similarities
from mapping.clip.scores import Query
from vizbot.config import AgreementConfig
from vizbot.core.observer import Candidate
from vizbot.objectnav.tasks import Goal
from vizbot.perception.perception import Perception
from vizbot.perception.sightings import CANDIDATE_SPACING, CANDIDATES


def best_places(
    perception: Perception, goal: Goal, ranking: AgreementConfig | None, answer: int | None = None
) -> tuple[Candidate, ...]:
    """The best places for a goal (paper, section III-B), best first.

    Args:
        perception: Holds the CLIP map.
        goal: What is looked for.
        ranking: How views are combined; None ranks each by itself.
        answer: Index of the element that the robot has arrived at: its place comes first.
    """
    points, elements = perception.points(), perception.clip_map.elements
    scores = similarities(elements.embeddings, goal.embedding)
    sightings = perception.sightings(scores)
    chosen = sightings.answers(ranking)
    if answer is not None:
        chosen = sightings.with_first(answer, chosen)
    return tuple(
        Candidate(points[i], float(scores[i]), int(elements.frames[i]), elements.boxes[i])
        for i in chosen
    )


def believed_places(perception: Perception, question: Query) -> tuple[Candidate, ...]:
    """The most probable places for a question, best first; their similarity is the probability."""
    elements = perception.clip_map.elements
    likeliest = likeliest_places(
        perception.places,
        perception.slam.keyframe_poses(),
        elements.embeddings,
        perception.statistics,
        question,
        CANDIDATES,
        CANDIDATE_SPACING,
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


def element_at(perception: Perception, goal: Goal, xy: NDArray[np.float64]) -> int:
    """Index of the element that shows a goal best at a place (2,) in `map` [m], of one at least."""
    away = np.linalg.norm(perception.points()[:, :2] - xy, axis=1)
    around = np.flatnonzero(away <= max(CANDIDATE_SPACING, float(away.min())))
    scores = similarities(perception.clip_map.embeddings[around], goal.embedding)
    return int(around[np.argmax(scores)])


class RunningScores:
    """Similarities of the elements of a growing CLIP map, each computed once for a goal."""

    def __init__(self) -> None:
        self._goal: Goal | None = None
        self._scores = np.zeros(0, np.float32)

    def similarities_to(
        self, goal: Goal | None, embeddings: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Similarities (N,) to a goal; zero without one.

        Args:
            goal: One other than that of the previous call begins anew.
            embeddings: (N, D) unit; they begin with those of the previous call.
        """
        if goal is not self._goal:
            self._goal, self._scores = goal, np.zeros(0, np.float32)
        fresh = embeddings[len(self._scores) :]
        if goal is None:
            scores = np.zeros(len(fresh), np.float32)
        else:
            scores = similarities(fresh, goal.embedding)
        self._scores = np.concatenate([self._scores, scores])
        return self._scores
