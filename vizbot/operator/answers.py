"""Where on a map is what somebody asks for, in figures that a person or a program reads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.map_bundle import MapBundle
from mapping.retrieval import similarities
from vizbot.config import AgreementConfig
from vizbot.core.observation import Outcome
from vizbot.sightings import Sightings


@dataclass(frozen=True, slots=True)
class Place:
    """A place that may be what was asked for.

    Attributes:
        position: x, y, z in `map` [m].
        similarity: Cosine between question and place, -1 to 1.
        frame: Number of the frame that saw it.
        box: Where in that frame: left, top, right, bottom [px].
    """

    position: tuple[float, float, float]
    similarity: float
    frame: int
    box: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Answer:
    """What a map says.

    Attributes:
        text: The question.
        outcome: `LOCATED` where the best place is similar enough, else `NOT_FOUND`.
        threshold: Similarity above which it is.
        places: Best first.
    """

    text: str
    outcome: Outcome
    threshold: float
    places: tuple[Place, ...]


def look_up(
    bundle: MapBundle,
    text: str,
    embedding: NDArray[np.float32],
    threshold: float,
    agreement: AgreementConfig,
) -> Answer:
    """Ask a map (paper, section III-B).

    Args:
        bundle: The map.
        text: The question.
        embedding: (D,) of the question, unit length, by the map's encoder.
        threshold: Of that encoder.
        agreement: How many views must agree.
    """
    scores = similarities(bundle.elements.embeddings, embedding)
    sightings = Sightings.of(bundle, scores)
    chosen = [i for i in sightings.answers(agreement) if scores[i] > 0.0]
    places = []
    for i in chosen:
        x, y, z = (round(float(value), 3) for value in sightings.points[i])
        box = tuple(int(edge) for edge in bundle.elements.boxes[i])
        similarity = round(float(scores[i]), 4)
        places.append(Place((x, y, z), similarity, int(bundle.elements.frames[i]), box))
    located = bool(chosen and scores[chosen[0]] > threshold)
    outcome = Outcome.LOCATED if located else Outcome.NOT_FOUND
    return Answer(text, outcome, threshold, tuple(places))
