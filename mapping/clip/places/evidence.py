"""Evidence: how much one view of a place speaks for a question, as log odds.

The log odds are linear in the scores of the three patches around the place, in its distance, and in
how high the question's own log odds go on a bank of pictures; views from near and from afar have
weights of their own. They were fitted to the truth at places of homes that neither the encoder nor
its threshold had seen (`benchmarks.encoder.fit`): to the embedded encoder alone, and to several at
once for all others.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

NEAR = 2.5
"""Views from within this distance on the plan count as near [m]."""
FARTHEST = 6.0
"""A view from farther away counts as one from this distance [m]."""
PRIOR = 0.05
"""Share of places in the fit that show what is asked for: evidence is relative to it."""
LEAST, MOST = -2.5, 6.0
"""Bounds of the evidence of one view [log odds]."""
LOG_ODDS, STANDARD = (-10.0, 5.0), (-1.0, 9.0)
"""Bounds of both scores: values beyond were hardly ever seen in the fit, and say no more."""
TAILS = -2.0, 2.0
"""Bounds of a question's upper tail, for the same reason [log odds]."""
_OF_PATCHES = (
    "finest patch", "middle patch", "coarsest patch", "better of finest and middle",
    "best of the three", "finest by middle", "middle by coarsest",
)  # fmt: skip
NAMES = (
    *(f"log odds of the encoder, {each}" for each in _OF_PATCHES),
    *(f"z-score, {each}" for each in _OF_PATCHES),
    "distance", "distance by log odds of the coarsest patch",
    "distance by the better log odds of finest and middle", "share of the finest patch",
    "upper tail of the question", "constant",
)  # fmt: skip
"""Names of the features, in their order."""
_WEIGHTS = Path(__file__).with_name("weights")
WEIGHTS_FILE = _WEIGHTS / "known_scale.json"
"""60 numbers, and what they are from; `python -m benchmarks.encoder.fit` makes it."""
UNKNOWN_SCALE_FILE = _WEIGHTS / "unknown_scale.json"
"""The same for encoders without scale and bias, where z-scores stand in for the log odds."""
EMBEDDED_FILE = _WEIGHTS / "embedded.json"
"""The same for the embedded encoder alone."""


def features(
    scores: NDArray[np.float32],
    patches: NDArray[np.integer],
    ranges: NDArray[np.float32],
    shares: NDArray[np.float32],
    tail: float,
) -> NDArray[np.float32]:
    """The features of each view of a place: (R, 20) float32.

    Args:
        scores: (N, 2) of the elements, as of `Query.scores`.
        patches: (R, 3) indices of the elements: finest, middle, coarsest.
        ranges: (R,) distance of the place from the camera on the plan [m].
        shares: (R,) share of the finest patch that shows the place.
        tail: Of the question, as of `Query.tail`.
    """
    columns: list[NDArray[np.float32]] = []
    for kind, bounds in enumerate((LOG_ODDS, STANDARD)):
        fine, middle, coarse = np.clip(scores[patches, kind], *bounds).T
        finer = np.maximum(fine, middle)
        best = np.maximum(finer, coarse)
        columns += [fine, middle, coarse, finer, best, fine * middle, middle * coarse]
    away = np.minimum(ranges, FARTHEST)
    one = np.ones_like(shares)
    high = np.float32(np.clip(tail, *TAILS)) * one
    columns += [away, away * columns[2], away * columns[3], shares, high, one]
    return np.stack(columns, axis=1)


def evidence(
    features: NDArray[np.float32],
    ranges: NDArray[np.float32],
    near: NDArray[np.float64],
    far: NDArray[np.float64],
) -> NDArray[np.float32]:
    """The evidence (R,) of each view of a place, from `LEAST` to `MOST` [log odds].

    Args:
        features: (R, 20) as of `features`.
        ranges: (R,) distance of the place from the camera on the plan [m].
        near: (20,) weights of views from within `NEAR`.
        far: (20,) weights of the others.
    """
    odds = np.where(ranges <= NEAR, features @ near, features @ far)
    prior = np.log(PRIOR / (1.0 - PRIOR))
    return np.asarray(np.clip(odds - prior, LEAST, MOST), np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """The fitted numbers.

    Attributes:
        near: (20,) of the features of a view from near.
        far: (20,) of those of a view from afar.
        join: (20,) of the features of all views of a place (`mapping.clip.places.place_views`).
    """

    near: NDArray[np.float64]
    far: NDArray[np.float64]
    join: NDArray[np.float64]


@cache
def fitted_weights(file: Path = WEIGHTS_FILE) -> Weights:
    """The numbers of a file."""
    kept = json.loads(file.read_text(encoding="utf-8"))
    return Weights(*(np.array(kept[name]) for name in ("near", "far", "join")))


@cache
def shipped_weights(model_id: str, scale_known: bool) -> Weights:
    """The numbers that come along for an encoder, by its id and whether it tells scale and bias."""
    if json.loads(EMBEDDED_FILE.read_text(encoding="utf-8"))["encoders"] == [model_id]:
        return fitted_weights(EMBEDDED_FILE)
    return fitted_weights() if scale_known else fitted_weights(UNKNOWN_SCALE_FILE)
