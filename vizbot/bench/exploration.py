"""A home is explored once without a goal; its map with features of every scale is asked."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapping import map_bundle
from mapping.clip_mapper import ClipMapperConfig
from mapping.map_bundle import MapBundle
from mapping.retrieval import similarities
from sim_stubs.goals import GOALS, goals_of
from sim_stubs.judge import precise
from sim_stubs.world import World
from vizbot.bench import paper
from vizbot.bench.episodes import QueryResult
from vizbot.bench.runs import encoder_of
from vizbot.bench.worlds import open_home
from vizbot.config import Config
from vizbot.core.geometry import transform
from vizbot.mission import explore
from vizbot.pipeline import Pipeline
from vizbot.rig import Rig

SCALE_SETS = tuple(scales for scales, *_ in paper.SCALES)
"""All rows of the paper's ablation."""


def explore_and_ask(job: tuple[Config, int, Path]) -> list[QueryResult]:
    """Explore a home, or take the map of an earlier exploration, and ask for all goals.

    Args:
        job: Settings, the largest scale set among them; seed of the home; where the map is kept.
    """
    config, seed, folder = job
    encoder = encoder_of(config)
    with ExitStack() as opened:
        world = opened.enter_context(open_home(seed, config))
        T_world_map = world.T_world_base  # the map begins where the base stands
        exist = goals_of(world)
        if not folder.exists():
            rig = opened.enter_context(Rig(config, "sim", "sim", world))
            pipeline = Pipeline(rig.devices, encoder, config, [])
            explore(pipeline, rig.devices, config.objectnav.max_exploration_steps)
            pipeline.finish()
            bundle = pipeline.bundle()
            assert bundle is not None
            folder.parent.mkdir(parents=True, exist_ok=True)
            map_bundle.save(bundle, folder)
        bundle = map_bundle.load(folder)
        points = transform(T_world_map, bundle.element_points())[:, :2]
        threshold = config.objectnav.threshold or encoder.threshold
        questions = encoder.embed_texts(GOALS)
        return [
            _ask(world, text, text in exist, question, scales, bundle, points, config, threshold)
            for scales in SCALE_SETS
            for text, question in zip(GOALS, questions, strict=True)
        ]


def of_scales(
    bundle: MapBundle, scales: Sequence[int], config: ClipMapperConfig
) -> NDArray[np.int64]:
    """Indices of the elements whose patches have one of these scales."""
    sizes = [int(config.patch_size * 2.0**scale) for scale in scales]
    boxes = bundle.elements.boxes
    return np.flatnonzero(np.isin(boxes[:, 2] - boxes[:, 0], sizes))


def _ask(
    world: World,
    text: str,
    exists: bool,
    question: NDArray[np.float32],
    scales: tuple[int, ...],
    bundle: MapBundle,
    points: NDArray[np.float64],
    config: Config,
    threshold: float,
) -> QueryResult:
    asked = of_scales(bundle, scales, config.perception.clip_mapper)
    scores = similarities(bundle.elements.embeddings[asked], question)
    best = int(np.argmax(scores))
    xy = points[asked[best]]
    return QueryResult(
        world.seed,
        scales,
        text,
        exists,
        round(float(scores[best]), 4),
        threshold,
        (round(float(xy[0]), 3), round(float(xy[1]), 3)),
        exists and precise(world, xy, text),
    )
