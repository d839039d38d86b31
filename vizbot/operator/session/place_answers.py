"""Answers to the question where something is on a map, for people and for programs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import PlaceBelief
from mapping.clip.places.footprint import PLACE
from mapping.clip.places.likeliest_places import belief_of_map, likeliest_places
from mapping.clip.retrieval import best, similarities
from mapping.clip.scores import Query
from mapping.map_bundle import MapBundle
from vizbot.config import ObjectNavConfig
from vizbot.core.geometry import invert
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3
from vizbot.objectnav.candidates import question_of
from vizbot.objectnav.tasks import Goal
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.perception.sightings import Sightings

_APART = 1.0
"""Places closer to each other are counted as one [m]."""
_LONG_AGO = timedelta(hours=1)
"""An answer says when its place was last seen where that was longer ago."""
_REACH = 1.5
"""Places of one area are at most this far from another one of it [m]."""


@dataclass(frozen=True, slots=True)
class FoundPlace:
    """A place that may match the question.

    Attributes:
        position: x, y, z in `map` [m].
        score: Probability that the place is what is asked for; by the method `paper` the cosine
            between question and place, -1 to 1.
        frame: Number of the frame that saw it.
        box: Box of the place in that frame: left, top, right, bottom [px].
        seen_at: When the place was last seen: date and time in UTC, as of ISO 8601.
    """

    position: tuple[float, float, float]
    score: float
    frame: int
    box: tuple[int, ...]
    seen_at: str


@dataclass(frozen=True, slots=True)
class Answer:
    """What a map answers to a question.

    Attributes:
        outcome: `LOCATED` where the best place's score is enough, else `NOT_FOUND`.
        threshold: Score that a place has to exceed.
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

    The pose is None where the robot is lost.
    """
    where = _where(answer, T_map_base, language)
    if answer.outcome is Outcome.LOCATED:
        seen_at = datetime.fromisoformat(answer.places[0].seen_at)
        if datetime.now(UTC) - seen_at > _LONG_AGO:
            where = language.say("where_then", where=where, when=local_time(seen_at))
    return where + (f" ({answer.note})" if answer.note else "")


def local_time(moment: datetime) -> str:
    """Date and time for people, where they are."""
    return moment.astimezone().strftime("%Y-%m-%d %H:%M")


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


def least_score(goal: Goal, config: ObjectNavConfig) -> float:
    """What the score of a place has to exceed to answer a question."""
    return goal.threshold if config.method == "paper" else config.answer_probability


def find_places(bundle: MapBundle, goal: Goal, config: ObjectNavConfig) -> Answer:
    """Look up a question on a map (paper, section III-B).

    `bundle` has statistics, but for the method `paper`.
    """
    if config.method == "paper":
        places = _most_similar(bundle, goal)
    else:
        places = _likeliest(bundle, question_of(goal))
    least = least_score(goal, config)
    located = bool(places and places[0].score > least)
    outcome = Outcome.LOCATED if located else Outcome.NOT_FOUND
    return Answer(goal.text, outcome, least, tuple(places), goal.note)


def _most_similar(bundle: MapBundle, goal: Goal) -> list[FoundPlace]:
    """The places of the most similar elements."""
    scores = similarities(bundle.elements.embeddings, goal.embedding)
    sightings = Sightings.from_bundle(bundle, scores)
    frames = bundle.frames
    times = frames.times[frames.rows_of(bundle.elements.frames)]
    return [
        _found(bundle, sightings.points[i], float(scores[i]), i, float(times[i]))
        for i in sightings.answers()
        if scores[i] > 0.0
    ]


def _likeliest(bundle: MapBundle, question: Query) -> list[FoundPlace]:
    """The most probable places."""
    likeliest = likeliest_places(
        belief_in(bundle, question),
        bundle.place_map(),
        bundle.keyframes.poses(),
        bundle.elements.embeddings,
        question,
    )
    return [
        _found(bundle, each.position, each.probability, each.element, each.seen_at)
        for each in likeliest
    ]


def belief_in(bundle: MapBundle, question: Query) -> PlaceBelief:
    """The probability that each place of a map with its background is what is asked for."""
    assert bundle.statistics is not None
    return belief_of_map(
        bundle.place_map(),
        bundle.keyframes.poses(),
        bundle.elements.embeddings,
        bundle.statistics,
        bundle.pictures,
        question,
    )


def _found(
    bundle: MapBundle, position: NDArray[np.float64], score: float, element: int, time: float
) -> FoundPlace:
    """A place with the picture of the element that shows it; it was seen last at `time` [s]."""
    x, y, z = (round(float(value), 3) for value in position)
    box = tuple(int(edge) for edge in bundle.elements.boxes[element])
    frame = int(bundle.elements.frames[element])
    seen_at = datetime.fromtimestamp(time, UTC).isoformat(timespec="seconds")
    return FoundPlace((x, y, z), round(score, 4), frame, box, seen_at)


def count_places(bundle: MapBundle, question: Query, least: float) -> int:
    """How many places of a map are more probably than `least` what is asked for.

    Those within a metre of each other are one.
    """
    places_xy, probabilities = _believed(bundle, question, least)
    return len(best(probabilities, places_xy, len(places_xy), _APART))


def area_of(bundle: MapBundle, question: Query, least: float) -> NDArray[np.float32] | None:
    """The area round the places of a map that are most probably a room.

    `bundle` has statistics; the probability of a place has to exceed `least`.

    Returns:
        Corners (N, 2) x, y in `map` [m]; None where no place is likely enough.
    """
    places_xy, probabilities = _believed(bundle, question, least)
    if len(places_xy) == 0:
        return None
    grown = np.zeros(len(places_xy), np.bool_)
    grown[int(np.argmax(probabilities))] = True
    for _ in range(len(places_xy)):  # from the best place on to those in reach of one of its own
        away = np.linalg.norm(places_xy[:, None] - places_xy[grown][None], axis=2).min(axis=1)
        if np.array_equal(within := away <= _REACH, grown):
            break
        grown = within
    edge = PLACE / 2
    corners = np.array([(-edge, -edge), (-edge, edge), (edge, -edge), (edge, edge)])
    around = (places_xy[grown][:, None] + corners).reshape(-1, 2)
    hull = cv2.convexHull(around.astype(np.float32))
    return np.asarray(hull[:, 0], np.float32)


def _believed(
    bundle: MapBundle, question: Query, least: float
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Places (N, 2) in `map` [m] that are more probable than `least`, and how probable (N,)."""
    belief = belief_in(bundle, question)
    chosen = np.nonzero(belief.probabilities > least)
    return belief.xy(*chosen), belief.probabilities[chosen].astype(np.float32)
