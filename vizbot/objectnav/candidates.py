"""Where on the map a goal may be."""

from __future__ import annotations

from mapping.clip.retrieval import similarities
from vizbot.config import AgreementConfig
from vizbot.core.observer import Candidate
from vizbot.objectnav.tasks import Goal
from vizbot.perception.perception import Perception


def best_places(
    perception: Perception, goal: Goal, agreement: AgreementConfig, answer: int | None = None
) -> tuple[Candidate, ...]:
    """The best places (paper, section III-B), best first.

    Args:
        perception: Holds the CLIP map.
        goal: What is looked for.
        agreement: How many views must agree.
        answer: Index of the element that the robot has arrived at: its place comes first.
    """
    points, elements = perception.points(), perception.clip_map.elements
    scores = similarities(elements.embeddings, goal.embedding)
    sightings = perception.sightings(points, scores)
    chosen = sightings.answers(agreement)
    if answer is not None:
        chosen = sightings.behind(answer, chosen)
    return tuple(
        Candidate(points[i], float(scores[i]), int(elements.frames[i]), elements.boxes[i])
        for i in chosen
    )
