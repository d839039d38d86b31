"""Exploration of a home without a goal, and queries to its map with features of every scale."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from mapping import map_bundle
from mapping.clip.config import ClipMapperConfig
from mapping.clip.likeliest_places import likeliest_places
from mapping.clip.place_rows import PlaceMap
from mapping.clip.placement import halvings
from mapping.clip.retrieval import similarities
from mapping.clip.scores import Query
from mapping.map_bundle import MapBundle
from sim_stubs.scoring.goals import GOALS, goals_of
from sim_stubs.scoring.success import precise
from sim_stubs.world.world import World
from vizbot.bench.episodes.calibration_error import CalibrationError
from vizbot.bench.episodes.episode import BelievedAnswer, Episode, ExplorationResult, QueryResult
from vizbot.bench.episodes.homes import open_benchmark_home
from vizbot.bench.episodes.latency import Latencies, slow_devices
from vizbot.bench.episodes.run import encoder_of, error_line
from vizbot.bench.objectnav import paper_figures
from vizbot.config import Config
from vizbot.core.errors import MapError
from vizbot.core.files import write_whole
from vizbot.core.geometry import transform
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3
from vizbot.mission import explore
from vizbot.perception.sightings import CANDIDATE_SPACING, Sightings
from vizbot.pipeline import Pipeline
from vizbot.rig import Rig

log = logging.getLogger(__name__)

SCALE_SETS = tuple(scales for scales, *_ in paper_figures.SCALES)
"""Scale sets of the paper's ablation."""
_BELIEVED_SCALES = ClipMapperConfig().scales
"""The belief is fitted to these, and takes them from a map that has a finer one, too."""
_EXPLORATION = TypeAdapter(ExplorationResult)


def explore_and_ask(job: tuple[Config, int, Path]) -> tuple[ExplorationResult, list[QueryResult]]:
    """Explore a home, or load the map of an earlier exploration, and query it for all goals.

    Args:
        job: Settings with the largest scale set, seed of the home, and folder of the map.
    """
    config, seed, folder = job
    encoder = encoder_of(config)
    error = CalibrationError.drawn(Episode(seed, ()))
    with open_benchmark_home(seed, config, error) as world:
        T_world_map = world.T_world_base  # the map begins where the base stands
        existing = goals_of(world)
        result_file = _result_file(folder)
        if not folder.exists() or not result_file.exists():
            exploration, bundle = _explored(world, seed, config)
            folder.parent.mkdir(parents=True, exist_ok=True)
            write_whole(result_file, _EXPLORATION.dump_json(exploration))
            map_bundle.save(bundle, folder)
        exploration = _EXPLORATION.validate_json(result_file.read_bytes())
        bundle = map_bundle.with_statistics(map_bundle.load(folder), encoder)
        threshold = config.objectnav.threshold or encoder.threshold
        questions = encoder.embed_texts(GOALS)
        everything = Sightings.from_bundle(
            bundle, np.zeros(len(bundle.elements.frames), np.float32)
        )
        believed = {
            text: _believed(bundle, text, Query(question, encoder.log_odds), world, T_world_map)
            for text, question in zip(GOALS, questions, strict=True)
        }
        answers = []
        for scales in SCALE_SETS:
            asked = elements_of_scales(bundle, scales, config.perception.clip_mapper)
            embeddings = bundle.elements.embeddings[asked]
            # Halvings as on a robot that has no patches of other scales.
            alone = replace(everything.take(asked), halvings=halvings(bundle.elements.boxes[asked]))
            for text, question in zip(GOALS, questions, strict=True):
                sightings = replace(alone, similarities=similarities(embeddings, question))
                query = _Query(text, text in existing, scales, threshold)
                answer = _ask(query, sightings, world, T_world_map, config)
                if scales == _BELIEVED_SCALES:
                    answer = replace(answer, believed=believed[text])
                answers.append(answer)
        return exploration, answers


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


def _result_file(folder: Path) -> Path:
    """The file of the exploration's result, beside the folder of its map."""
    return folder.with_suffix(".json")


def elements_of_scales(
    bundle: MapBundle, scales: Sequence[int], config: ClipMapperConfig
) -> NDArray[np.int64]:
    """Indices of the elements whose patches have one of these scales."""
    sizes = [int(config.patch_size * 2.0**scale) for scale in scales]
    boxes = bundle.elements.boxes
    return np.flatnonzero(np.isin(boxes[:, 2] - boxes[:, 0], sizes))


@dataclass(frozen=True, slots=True)
class _Query:
    """What is asked: a text, whether the home has it, and of which scales the map is."""

    text: str
    exists: bool
    scales: tuple[int, ...]
    threshold: float


def _believed(
    bundle: MapBundle, text: str, question: Query, world: World, T_world_map: SE3
) -> BelievedAnswer:
    """The most probable place for a question."""
    assert bundle.statistics is not None
    likeliest = likeliest_places(
        PlaceMap(bundle.places),
        bundle.keyframes.poses(),
        bundle.elements.embeddings,
        bundle.statistics,
        question,
        count=1,
        spacing=CANDIDATE_SPACING,
    )
    if not likeliest:
        return BelievedAnswer(0.0, False)
    xy = transform(T_world_map, likeliest[0].position[None])[0, :2]
    return BelievedAnswer(round(likeliest[0].probability, 4), precise(world, xy, text))


def _ask(
    query: _Query, sightings: Sightings, world: World, T_world_map: SE3, config: Config
) -> QueryResult:
    [best] = sightings.answers(config.objectnav.agreement, count=1)
    most_similar = int(np.argmax(sightings.similarities))
    points = transform(T_world_map, sightings.points)[:, :2]
    xy = points[best]
    return QueryResult(
        world.seed,
        query.scales,
        query.text,
        query.exists,
        round(float(sightings.similarities[best]), 4),
        query.threshold,
        (round(float(xy[0]), 3), round(float(xy[1]), 3)),
        query.exists and precise(world, xy, query.text),
        query.exists and precise(world, points[most_similar], query.text),
    )
