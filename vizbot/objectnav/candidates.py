"""Places on the map where a goal is believed to be."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import PlaceBelief
from mapping.clip.places.footprint import PLACE
from mapping.clip.places.likeliest_places import likeliest_places
from mapping.clip.scores import Query
from vizbot.core.observer import Candidate
from vizbot.core.place_scores import UNSEEN, PlaceScores
from vizbot.objectnav.tasks import Goal

if TYPE_CHECKING:  # a search may be made without a camera
    from vizbot.perception.perception import Perception

NOTHING_SEEN = PlaceBelief(
    np.zeros(2, np.int64),
    np.zeros((0, 0)),
    np.zeros((0, 0), np.float32),
    np.zeros((0, 0), np.bool_),
    np.zeros((0, 0, 2)),
    np.zeros((0, 0), np.float32),
)


def question_of(goal: Goal) -> Query:
    """The question by which places are believed to be a goal."""
    asked = goal.embedding if goal.asked is None else goal.asked
    return Query(asked, goal.log_odds, goal.rivals, goal.weights)


def believed_places(
    goal: Goal,
    perception: Perception,
    belief: PlaceBelief,
    answer_xy: NDArray[np.float64] | None = None,
) -> tuple[Candidate, ...]:
    """The likeliest places for a goal: `answer_xy` (2,) [m], where it arrived, then the best."""
    elements = perception.clip_map.elements
    likeliest = likeliest_places(
        belief,
        perception.places,
        perception.slam.keyframe_poses(),
        elements.embeddings,
        question_of(goal),
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


def scores_of(belief: PlaceBelief) -> PlaceScores:
    """The probabilities of places in the form that people are shown."""
    values = np.where(belief.seen, belief.probabilities, UNSEEN).astype(np.float32)
    return PlaceScores(belief.low, PLACE, values)
