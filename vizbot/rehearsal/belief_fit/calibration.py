"""Fits all numbers of the belief to one encoder, by the list of views."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.background.kept_bank import OnProgress
from mapping.clip.fitted.calibration import (
    LIST_OF_VIEWS,
    EncoderCalibration,
    ReliabilityBin,
    encoder_hash,
)
from mapping.clip.patches import embed_frame
from mapping.clip.places.evidence import Weights, fitted_weights
from mapping.clip.scores import Background
from sim_stubs.world.world import World
from sim_stubs.world.world_plan import D435I_COLOUR
from vizbot.config import PerceptionConfig
from vizbot.core.files import user_folder
from vizbot.core.types import ImuSamples, RGBDFrame
from vizbot.rehearsal.belief_fit.cosine_fit import fit_cosines
from vizbot.rehearsal.belief_fit.fit import believed, fitted
from vizbot.rehearsal.belief_fit.places import Places
from vizbot.rehearsal.belief_fit.seen_home import SeenHome, ShownPlaces, seen_in, shown_from
from vizbot.rehearsal.belief_fit.view_list import VIEWS_OF_HOME, ListedHome
from vizbot.rehearsal.belief_fit.views import Views, count_views
from vizbot.rehearsal.config import RehearsalConfig

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

log = logging.getLogger(__name__)

_SAVED_EVERY = 10
"""Views that are taken before they are written to the disk."""
_EDGES = (0.0, 0.01, 0.03, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
"""Bounds of what is believed, in the table of reliability."""
_PERCEPTION = PerceptionConfig()
"""Patches are cut as by default, whatever a user's settings say: the list of views is fixed."""


def views_folder(hashed: str) -> Path:
    """Where finished views of an encoder of this hash are kept until its numbers are fitted.

    It is in `$XDG_CACHE_HOME/vizbot/calibration` (default `~/.cache`).
    """
    cache = user_folder("XDG_CACHE_HOME", ".cache")
    return cache / "calibration" / f"{hashed[:32]}-{LIST_OF_VIEWS}"


def views_left(homes: Sequence[ListedHome], folder: Path) -> int:
    """Number of views of these homes that are not kept yet."""
    return sum(VIEWS_OF_HOME - count_views(folder / each.name) for each in homes)


def seconds_a_view(encoder: ClipEncoder) -> float:
    """How long the encoder takes for the patches of one view, as measured now [s]."""
    shape = D435I_COLOUR.height, D435I_COLOUR.width
    depth = np.full(shape, 2.0, np.float32)
    rgb = np.full((*shape, 3), 128, np.uint8)
    frame = RGBDFrame(0.0, rgb, depth, D435I_COLOUR, ImuSamples.none())
    for _ in range(2):  # the first one also loads what all others have
        began = time.monotonic()
        embed_frame(frame, encoder, _PERCEPTION.clip_mapper)
    return time.monotonic() - began


def calibrate_encoder(
    encoder: ClipEncoder,
    homes: Sequence[ListedHome],
    folder: Path,
    on_view: Callable[[], None],
    on_bank: OnProgress,
) -> EncoderCalibration:
    """Take the views that are not kept yet, and fit the numbers to all.

    Args:
        encoder: Embeds the views.
        homes: Of the list, two at least.
        folder: Keeps finished views, for a run that goes on after this one was interrupted.
        on_view: Called after each view that was taken.
        on_bank: Called while the bank of pictures is embedded.

    Raises:
        ConfigError: a home cannot be read, or the encoder tells nothing apart.
        DeviceError: the machine cannot render, or has too little memory for the encoder.
    """
    background = Background.embedded_by(encoder, on_bank)
    shown = [shown_in(each, encoder, folder, on_view) for each in homes]
    cosines = fit_cosines(shown, encoder)
    seen = [
        seen_in(each, encoder, background, cosines.log_odds, cosines.phrasings) for each in shown
    ]
    weights = fitted_to_walks(seen)
    near, far, join = (
        tuple(each.round(5).tolist()) for each in (weights.near, weights.far, weights.join)
    )
    halves = [
        believed(seen[1 - half :: 2], fitted_to_walks(seen[half::2]), along_the_views)
        for half in (0, 1)
    ]
    reliability, error = reliability_of(*(np.concatenate(of) for of in zip(*halves, strict=True)))
    return EncoderCalibration(
        model_id=encoder.model_id,
        encoder_hash=encoder_hash(encoder),
        views=LIST_OF_VIEWS,
        homes=tuple(each.name for each in homes),
        phrasings=cosines.phrasings,
        scale=cosines.log_odds[0],
        bias=cosines.log_odds[1],
        threshold=cosines.threshold,
        near=near,
        far=far,
        join=join,
        reliability=reliability,
        calibration_error=error,
    )


def fitted_to_walks(homes: Sequence[SeenHome]) -> Weights:
    """The numbers that fit homes seen on a walk each, drawn to those that come along."""
    return fitted(homes, walks=along_the_views, prior=fitted_weights())


def along_the_views(home: ShownPlaces, rng: np.random.Generator) -> Sequence[int]:
    """The walk that a home was seen on, from somewhere in its first half on."""
    count = len(home.stands)
    return range(int(rng.integers(count // 2 + 1)), count)


def shown_in(
    listed: ListedHome,
    encoder: ClipEncoder,
    folder: Path,
    on_view: Callable[[], None] = lambda: None,
) -> ShownPlaces:
    """What the views of a home show, each new one kept in `folder` soon after it was taken."""
    house, body = listed.house(), RehearsalConfig().world
    with World(house, body, seed=listed.seed) as world:
        places = Places.in_world(world)
        views = Views(world, encoder, _PERCEPTION, folder / listed.name)
        stations = listed.stations(places)
        try:
            for stand, heading in stations:
                made = views.made
                views.view(places.xy[stand], stand, heading)
                if views.made > made:
                    on_view()
                    if views.made % _SAVED_EVERY == 0:
                        views.save()
        finally:
            views.save()
        return shown_from(views, places, stations)


def reliability_of(
    probabilities: NDArray[np.float64],
    outcomes: NDArray[np.float64],
    weights: NDArray[np.float64],
) -> tuple[tuple[ReliabilityBin, ...], float]:
    """How well what is believed fits, from what `believed` returns.

    Returns:
        A row for each part of the range of probabilities that has places, and the mean difference
        of what is believed and what is true, by places.
    """
    part = np.clip(np.digitize(probabilities, _EDGES) - 1, 0, len(_EDGES) - 2)
    rows, differences = [], 0.0
    for i in range(len(_EDGES) - 1):
        chosen: NDArray[np.bool_] = part == i
        if not chosen.any():
            continue
        mean, true = (
            float(np.average(each[chosen], weights=weights[chosen]))
            for each in (probabilities, outcomes)
        )
        rows.append(
            ReliabilityBin(believed=round(mean, 5), true=round(true, 5), places=int(chosen.sum()))
        )
        differences += float(weights[chosen].sum()) * abs(mean - true)
    return tuple(rows), round(differences / float(weights.sum()), 5)
