"""Answers to the question where something is on a map, for people and for programs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.likeliest_places import likeliest_places
from mapping.clip.place_rows import PlaceMap
from mapping.clip.retrieval import best, similarities
from mapping.clip.scores import Query
from mapping.map_bundle import MapBundle
from vizbot.config import AgreementConfig
from vizbot.core.geometry import invert
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3
from vizbot.objectnav.tasks import Goal
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.perception.sightings import CANDIDATE_SPACING, CANDIDATES, Sightings

_APART = 1.0
"""Places closer to each other are counted as one [m]."""
_REACH = 1.5
"""Places of one area are at most this far from another one of it [m]."""
_AROUND = 0.4
"""An area reaches so far beyond its places [m]."""


@dataclass(frozen=True, slots=True)
class FoundPlace:
    """A place that may match the question.

    Attributes:
        position: x, y, z in `map` [m].
        similarity: Cosine between question and place, -1 to 1; by the method `belief` the
            probability that the place is what is asked for.
        frame: Number of the frame that saw it.
        box: Where in that frame: left, top, right, bottom [px].
    """

    position: tuple[float, float, float]
    similarity: float
    frame: int
    box: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Answer:
    """What a map answers to a question.

    Attributes:
        text: The question.
        outcome: `LOCATED` where the best place is similar enough, else `NOT_FOUND`.
        threshold: What the best place's similarity has to exceed.
        places: Best first.
        note: How the encoder understands the question, in one line; None where it needs no saying.
    """

    text: str
    outcome: Outcome
    threshold: float
    places: tuple[FoundPlace, ...]
    note: str | None = None


def summary(answer: Answer, T_map_base: SE3 | None, language: Language = ENGLISH) -> str:
    """An answer in one line: the place as seen from the robot, and how the words are understood.

    Args:
        answer: What the map answers.
        T_map_base: Pose of the robot; None where it is lost.
        language: To say it in.
    """
    where = _where(answer, T_map_base, language)
    return where + (f" ({answer.note})" if answer.note else "")


def _where(answer: Answer, T_map_base: SE3 | None, language: Language) -> str:
    if answer.outcome is not Outcome.LOCATED:
        return language.say("where_none", goal=answer.text)
    x, y, _ = answer.places[0].position
    if T_map_base is None:
        return language.say("where_lost", goal=answer.text)
    ahead, left = (invert(T_map_base) @ (x, y, 0.0, 1.0))[:2]
    directions = language.answers["directions"].split("|")  # counterclockwise
    direction = directions[round(math.atan2(left, ahead) / (math.pi / 4)) % 8]
    distance = math.hypot(ahead, left)
    return language.say("where", goal=answer.text, distance=distance, direction=direction)


def find_places(bundle: MapBundle, goal: Goal, ranking: AgreementConfig | None) -> Answer:
    """Look up a question on a map (paper, section III-B).

    Args:
        bundle: The map.
        goal: The question, by the map's encoder.
        ranking: How many views must agree on a place; None ranks each by itself.
    """
    scores = similarities(bundle.elements.embeddings, goal.embedding)
    sightings = Sightings.from_bundle(bundle, scores)
    chosen = [i for i in sightings.answers(ranking) if scores[i] > 0.0]
    places = [_found(bundle, sightings.points[i], float(scores[i]), i) for i in chosen]
    located = bool(chosen and scores[chosen[0]] > goal.threshold)
    outcome = Outcome.LOCATED if located else Outcome.NOT_FOUND
    return Answer(goal.text, outcome, goal.threshold, tuple(places), goal.note)


def find_believed_places(bundle: MapBundle, goal: Goal, question: Query, least: float) -> Answer:
    """Look up a question on a map by the probabilities of its places.

    Args:
        bundle: The map, with statistics.
        goal: The question, by the map's encoder.
        question: The same with the log odds of the encoder.
        least: Probability that the best place has to exceed.
    """
    assert bundle.statistics is not None
    likeliest = likeliest_places(
        PlaceMap(bundle.places),
        bundle.keyframes.poses(),
        bundle.elements.embeddings,
        bundle.statistics,
        question,
        CANDIDATES,
        CANDIDATE_SPACING,
    )
    located = bool(likeliest and likeliest[0].probability > least)
    outcome = Outcome.LOCATED if located else Outcome.NOT_FOUND
    places = (
        _found(bundle, place.position, place.probability, place.element) for place in likeliest
    )
    return Answer(goal.text, outcome, least, tuple(places), goal.note)


def _found(
    bundle: MapBundle, position: NDArray[np.float64], score: float, element: int
) -> FoundPlace:
    """A place with the picture of the element that shows it."""
    x, y, z = (round(float(value), 3) for value in position)
    box = tuple(int(edge) for edge in bundle.elements.boxes[element])
    return FoundPlace((x, y, z), round(score, 4), int(bundle.elements.frames[element]), box)


def count_places(bundle: MapBundle, goal: Goal, agreement: AgreementConfig) -> int:
    """How many places of a map look like a goal; those within a metre of each other are one."""
    alike, agreed = _alike(bundle, goal, agreement)
    return len(best(agreed, alike, len(alike), _APART))


def area_of(
    bundle: MapBundle, goal: Goal, agreement: AgreementConfig
) -> NDArray[np.float32] | None:
    """The area round the places of a map that look most like a room.

    Returns:
        Corners (N, 2) x, y in `map` [m]; None where no place looks like it.
    """
    alike, agreed = _alike(bundle, goal, agreement)
    if len(alike) == 0:
        return None
    xy = alike[:, :2]
    grown = np.zeros(len(xy), np.bool_)
    grown[int(np.argmax(agreed))] = True
    for _ in range(len(xy)):  # from the best place on to those in reach of one that belongs to it
        away = np.linalg.norm(xy[:, None] - xy[grown][None], axis=2).min(axis=1)
        if np.array_equal(within := away <= _REACH, grown):
            break
        grown = within
    corners = np.array(
        [(-_AROUND, -_AROUND), (-_AROUND, _AROUND), (_AROUND, -_AROUND), (_AROUND, _AROUND)]
    )
    around = (xy[grown][:, None] + corners).reshape(-1, 2)
    hull = cv2.convexHull(around.astype(np.float32))
    return np.asarray(hull[:, 0], np.float32)


def _alike(
    bundle: MapBundle, goal: Goal, agreement: AgreementConfig
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Points (N, 3) of the elements that several views take for a goal, and how surely (N,)."""
    scores = similarities(bundle.elements.embeddings, goal.embedding)
    sightings = Sightings.from_bundle(bundle, scores)
    agreed = sightings.agreed(agreement, goal.threshold)
    chosen = agreed > goal.threshold
    return sightings.points[chosen], agreed[chosen]
