"""Questions to the map of a home, for what it has and for what it has not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.episodes.calibration_error import CalibrationError
from benchmarks.episodes.episode import EncoderScale, Episode
from benchmarks.episodes.exploration import explored_map
from benchmarks.episodes.homes import house_of, open_benchmark_home
from benchmarks.episodes.other_encoders import OtherEncoder
from benchmarks.episodes.run import encoder_of
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.start_pose import things_named
from sim_stubs.scoring.success import goals_of, precise
from vizbot.config import Config
from vizbot.core.geometry import transform
from vizbot.core.observer import Outcome
from vizbot.objectnav.tasks import goal_of
from vizbot.operator.session.place_answers import find_places

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder


@dataclass(frozen=True, slots=True)
class ThingAnswer:
    """What a map answers to a question for one thing.

    Attributes:
        home: Seed of the explored home.
        text: The question.
        kind: "present"; "elsewhere" of what other homes have and this one has not; "nowhere".
        located: Whether the map says that it is there.
        score: Of the best place; 0 where the map shows none.
        correct: Whether that lies within half a metre of an instance, or inside the room asked for.
    """

    home: int
    text: str
    kind: str
    located: bool
    score: float
    correct: bool


@dataclass(frozen=True, slots=True)
class HomeQuestions:
    """What one home is asked.

    Attributes:
        config: Settings of the robot, with the largest scale set.
        encoder_scale: Whose cosines the encoder has; None for its own.
        home: Seed of the home.
        folder: Of its map, which is explored where it is missing.
        nowhere: Things in no home at all.
        elsewhere: Things of homes; those that this one has are not asked for.
        count: Number of questions for absent things, half of each kind, and for present ones, at
            most.
    """

    config: Config
    encoder_scale: EncoderScale | None
    home: int
    folder: Path
    nowhere: tuple[str, ...]
    elsewhere: tuple[str, ...]
    count: int


def ask_home(job: HomeQuestions) -> list[ThingAnswer]:
    """The answers of a home's map."""
    error = CalibrationError.drawn(Episode(job.home, ()))
    with open_benchmark_home(job.home, job.config, error) as world:
        T_world_map = world.T_world_base  # the map begins where the base stands
        present = goals_of(world)
        _, bundle = explored_map(world, job.home, job.config, job.folder)
        rng = np.random.default_rng(job.home)
        lacking = _lacking(world.house, job.elsewhere)
        questions = {
            "present": _drawn(present, job.count, rng),
            "elsewhere": _drawn(lacking, job.count - job.count // 2, rng),
            "nowhere": _drawn(job.nowhere, job.count // 2, rng),
        }
        encoder: ClipEncoder = encoder_of(job.config)
        if job.encoder_scale is not None:
            encoder = OtherEncoder(encoder, job.encoder_scale)
            bundle = encoder.map_of(bundle)
        answers = []
        for kind, texts in questions.items():
            for text in texts:
                answer = find_places(bundle, goal_of(encoder, text), job.config.objectnav)
                located, correct, score = answer.outcome is Outcome.LOCATED, False, 0.0
                if answer.places:
                    best = answer.places[0]
                    xy = transform(T_world_map, np.array([best.position]))[0, :2]
                    correct = kind == "present" and precise(world, xy, text)
                    score = best.score
                answers.append(ThingAnswer(job.home, text, kind, located, score, correct))
        return answers


def absent_episodes(
    home: int, nowhere: Sequence[str], elsewhere: Sequence[str], count: int
) -> list[Episode]:
    """Searches in a home for things that are not in it.

    Args:
        home: Seed of the home.
        nowhere: Things in no home at all.
        elsewhere: Things of homes; those that this one has are not searched for.
        count: Number of searches, half of them, rounded up, for the latter.
    """
    rng = np.random.default_rng(home)
    lacking = _lacking(house_of(home), elsewhere)
    texts = _drawn(lacking, count - count // 2, rng) + _drawn(nowhere, count // 2, rng)
    return [Episode(home, (text,)) for text in texts]


def _lacking(house: House, texts: Sequence[str]) -> list[str]:
    """Those of the texts that name nothing in a house."""
    return [text for text in texts if not any(things_named(house, text))]


def _drawn(texts: Sequence[str], count: int, rng: np.random.Generator) -> list[str]:
    """So many of the texts at most, in their order."""
    chosen = rng.permutation(len(texts))[:count]
    return [texts[i] for i in sorted(chosen)]
