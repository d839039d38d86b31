"""Exploration of a home without a goal, and queries to its map with features of every scale."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from benchmarks.episodes.calibration_error import CalibrationError
from benchmarks.episodes.episode import (
    BelievedAnswer,
    EncoderScale,
    Episode,
    ExplorationResult,
    QueryResult,
)
from benchmarks.episodes.homes import open_benchmark_home
from benchmarks.episodes.latency import Latencies, slow_devices
from benchmarks.episodes.other_encoders import OtherEncoder
from benchmarks.episodes.run import encoder_of, error_line
from benchmarks.objectnav import paper_figures
from mapping import map_bundle
from mapping.clip.config import ClipMapperConfig
from mapping.clip.places.likeliest_places import LikelyPlace, belief_of_map, likeliest_places
from mapping.clip.places.place_rows import PlaceMap, PlaceRows
from mapping.clip.retrieval import similarities
from mapping.clip.scores import Query
from mapping.map_bundle import MapBundle
from sim_stubs.scoring.success import GOALS, goals_of, precise
from sim_stubs.world.world import World
from vizbot.config import Config
from vizbot.core.errors import MapError
from vizbot.core.files import write_whole
from vizbot.core.geometry import transform
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3
from vizbot.mission import explore
from vizbot.objectnav.candidates import question_of
from vizbot.objectnav.tasks import goal_of
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

log = logging.getLogger(__name__)

SCALE_SETS = tuple(scales for scales, *_ in paper_figures.SCALES)
"""Scale sets of the paper's ablation."""
_EXPLORATION = TypeAdapter(ExplorationResult)


@dataclass(frozen=True, slots=True)
class HomeToAsk:
    """A home that is explored and asked.

    Attributes:
        config: Settings of the robot, with the largest scale set.
        home: Seed of the home.
        folder: Of its map.
        encoder_scale: Whose cosines the encoder has that the map is asked with; None for its own.
    """

    config: Config
    home: int
    folder: Path
    encoder_scale: EncoderScale | None = None


def explore_and_ask(job: HomeToAsk) -> tuple[ExplorationResult, list[QueryResult]]:
    """Explore a home, or load the map of an earlier exploration, and query it for all goals."""
    config, seed, folder = job.config, job.home, job.folder
    encoder: ClipEncoder = encoder_of(config)
    error = CalibrationError.drawn(Episode(seed, ()))
    with open_benchmark_home(seed, config, error) as world:
        T_world_map = world.T_world_base  # the map begins where the base stands
        existing = goals_of(world)
        exploration, bundle = explored_map(world, seed, config, folder)
        if job.encoder_scale is not None:
            encoder = OtherEncoder(encoder, job.encoder_scale)
            bundle = encoder.map_of(bundle)
        goals = [goal_of(encoder, text) for text in GOALS]
        answers = []
        for scales in SCALE_SETS:
            asked = _OfScales.of_map(bundle, scales, config)
            for goal in goals:
                query = _Query(goal.text, question_of(goal), goal.text in existing)
                answers.append(_ask(query, asked, bundle, world, T_world_map))
        return exploration, answers


def explored_map(
    world: World, seed: int, config: Config, folder: Path
) -> tuple[ExplorationResult, MapBundle]:
    """How the exploration of a home ended, and its map, which the folder keeps for next time."""
    result_file = folder.with_suffix(".json")  # beside the folder of its map
    if not folder.exists() or not result_file.exists():
        exploration, bundle = _explored(world, seed, config)
        folder.parent.mkdir(parents=True, exist_ok=True)
        write_whole(result_file, _EXPLORATION.dump_json(exploration))
        map_bundle.save(bundle, folder)
    exploration = _EXPLORATION.validate_json(result_file.read_bytes())
    return exploration, map_bundle.with_background(map_bundle.load(folder), encoder_of(config))


def _explored(world: World, seed: int, config: Config) -> tuple[ExplorationResult, MapBundle]:
    """The result of an exploration and its map, which is kept even after an error."""
    with Rig(config, "sim", "sim", world) as rig:
        devices = slow_devices(rig.devices, Latencies.kept(), config, seed)
        pipeline = Pipeline(devices, encoder_of(config), config, [])
        try:
            outcome, reason = explore(pipeline, devices, config.objectnav.max_exploration_steps)
        except Exception as error:
            log.exception("exploring home %d", seed)
            outcome, reason = Outcome.GAVE_UP, error_line(error)
        pipeline.finish()
        bundle = pipeline.bundle()
    if bundle is None:
        raise MapError(f"home {seed} has no map: {reason}")
    explored = outcome is Outcome.EXPLORED
    return ExplorationResult(seed, explored, reason, pipeline.steps), bundle


def elements_of_scales(
    bundle: MapBundle, scales: Sequence[int], config: ClipMapperConfig
) -> NDArray[np.int64]:
    """Indices of the elements whose patches have one of these scales."""
    sizes = [int(config.patch_size * 2.0**scale) for scale in scales]
    boxes = bundle.elements.boxes
    return np.flatnonzero(np.isin(boxes[:, 2] - boxes[:, 0], sizes))


def rows_of_scales(
    bundle: MapBundle, scales: Sequence[int], config: ClipMapperConfig
) -> PlaceRows | None:
    """Views of places as a map with patches of these scales alone has them.

    Of a map with more than three scales the views hold the coarsest three; None where none of
    these is among them.
    """
    columns = sorted(config.scales)[-3:]
    kept = [columns.index(scale) for scale in sorted(scales) if scale in columns]
    if not kept:
        return None
    of_scales = [kept[0], kept[len(kept) // 2], kept[-1]]
    return replace(bundle.places, elements=bundle.places.elements[:, of_scales])


@dataclass(frozen=True, slots=True)
class _Query:
    """What is asked: a text, the same for the belief, and whether the home has it."""

    text: str
    question: Query
    exists: bool


@dataclass(frozen=True, slots=True, eq=False)
class _OfScales:
    """What counts of a map that is asked with some scales, and how probable an answer has to be."""

    scales: tuple[int, ...]
    elements: NDArray[np.int64]
    rows: PlaceRows | None
    least: float

    @classmethod
    def of_map(cls, bundle: MapBundle, scales: tuple[int, ...], config: Config) -> _OfScales:
        mapper = config.perception.clip_mapper
        elements = elements_of_scales(bundle, scales, mapper)
        return cls(
            scales,
            elements,
            rows_of_scales(bundle, scales, mapper),
            config.objectnav.answer_probability,
        )


def _ask(
    query: _Query, asked: _OfScales, bundle: MapBundle, world: World, T_world_map: SE3
) -> QueryResult:
    """The answer of a map."""
    embeddings, rows = bundle.elements.embeddings[asked.elements], asked.rows
    cosines = similarities(embeddings, query.question.embedding)
    most_similar = int(np.argmax(cosines))
    similar_xy = transform(T_world_map, bundle.element_points()[asked.elements[[most_similar]]])[
        0, :2
    ]
    by_paper = query.exists and precise(world, similar_xy, query.text)
    xy, believed = similar_xy, None
    if rows is not None and (likeliest := _likeliest(bundle, rows, query.question)) is not None:
        xy = transform(T_world_map, likeliest.position[None])[0, :2]
        right = query.exists and precise(world, xy, query.text)
        believed = BelievedAnswer(round(likeliest.probability, 4), right)
    return QueryResult(
        world.seed,
        asked.scales,
        query.text,
        query.exists,
        round(float(cosines[most_similar]), 4),
        asked.least,
        (round(float(xy[0]), 3), round(float(xy[1]), 3)),
        by_paper if believed is None else believed.correct,
        by_paper,
        believed,
    )


def _likeliest(bundle: MapBundle, rows: PlaceRows, question: Query) -> LikelyPlace | None:
    """The most probable place for a question; None where the map shows no place."""
    assert bundle.statistics is not None
    places = PlaceMap(bundle.intrinsics, rows, bundle.frames)
    poses, embeddings = bundle.keyframes.poses(), bundle.elements.embeddings
    belief = belief_of_map(places, poses, embeddings, bundle.statistics, bundle.pictures, question)
    likeliest = likeliest_places(belief, places, poses, embeddings, question)
    return likeliest[0] if likeliest else None
