"""Fits what an encoder's cosines mean to what its patches truly show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.evidence import PRIOR
from vizbot.core.errors import ConfigError
from vizbot.rehearsal.belief_fit.fit import logistic
from vizbot.rehearsal.belief_fit.places import are_true
from vizbot.rehearsal.belief_fit.seen_home import ShownPlaces

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import TextEncoder

CLEAR = 0.3
"""A patch shows a goal clearly where this share of the places that it shows are the goal's; with
none it does not show it, and between the two it says nothing."""
_LEAST_SLOPE = 0.05
"""Log odds that a standard deviation of the cosines must be worth."""
RIGHT, _LEAST_PAIRS = 0.9, 20
"""Share of the patches above the threshold that show the goal, of at least so many."""


def fit_cosines(
    homes: Sequence[ShownPlaces], encoder: TextEncoder
) -> tuple[tuple[float, float], float]:
    """Scale and bias that make log odds of a cosine, and the threshold of the method `paper`.

    The log odds are those of a patch that shows a goal as often as evidence is measured from
    (`mapping.clip.evidence.PRIOR`). The threshold is the least cosine above which `RIGHT` of the
    patches show the goal, and even odds where no cosine is.

    Raises:
        ConfigError: cosines of what is shown are not higher than others.
    """
    parts = [_patches(home, encoder) for home in homes]
    cosines, outcomes, weights = (np.concatenate(each) for each in zip(*parts, strict=True))
    mean, spread = cosines.mean(), max(cosines.std(), 1e-9)
    inputs = np.stack([(cosines - mean) / spread, np.ones_like(cosines)], axis=1)
    slope, level = logistic(inputs, outcomes, weights).tolist()
    scale, bias = slope / spread, level - slope * mean / spread
    if not slope > _LEAST_SLOPE:
        raise ConfigError(
            f"{encoder.model_id} does not tell what its pictures show: nothing can be fitted to"
            " it, and nothing was written; take another encoder"
        )
    order = np.argsort(-cosines)
    right = np.cumsum(outcomes[order]) / np.arange(1, len(order) + 1)
    enough = np.flatnonzero(right >= RIGHT).max(initial=0)
    least = cosines[order[enough]] if enough >= _LEAST_PAIRS else -bias / scale
    return (float(scale), float(bias)), float(np.clip(least, -0.999, 0.999))


def _patches(
    home: ShownPlaces, encoder: TextEncoder
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Cosines of patches with goals, whether they show them, and weights of these pairs.

    Every goal counts the same.
    """
    count = len(home.embeddings)
    shown = np.bincount(home.patches.ravel(), minlength=count)
    goals = list(home.true)
    cosines = home.embeddings @ encoder.embed_texts(goals).T
    found: list[tuple[NDArray[np.float64], ...]] = []
    for column, goal in enumerate(goals):
        there = are_true(home.places, *home.true[goal])
        hits = np.bincount(home.patches.ravel(), np.repeat(there, 3), minlength=count)
        shares = hits / np.maximum(shown, 1)
        parts = (
            ((shares >= CLEAR) & (shown > 0), 1.0, PRIOR),
            (
                (hits == 0) & (shown > 0),
                0.0,
                1.0 - PRIOR,
            ),
        )
        if not all(chosen.any() for chosen, _, _ in parts):
            continue
        for chosen, outcome, share in parts:
            number = int(chosen.sum())
            found.append(
                (
                    cosines[chosen, column].astype(np.float64),
                    np.full(number, outcome),
                    np.full(number, share / number),
                )
            )
    if not found:
        nothing = np.zeros(0)
        return nothing, nothing, nothing
    of_cosines, outcomes, weights = (np.concatenate(each) for each in zip(*found, strict=True))
    return of_cosines, outcomes, weights
