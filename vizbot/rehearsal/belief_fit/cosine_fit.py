"""Fits what an encoder's cosines mean to what its patches truly show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.fitted.phrasings import BARE, ENSEMBLE, embed_phrased
from mapping.clip.places.evidence import PRIOR
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


@dataclass(frozen=True, slots=True)
class CosineFit:
    """What an encoder's cosines mean.

    Attributes:
        phrasings: Sentences that together stand for a goal.
        log_odds: Scale and bias that make log odds of a cosine with those.
        threshold: Of a cosine with the bare words, for the method `paper`.
    """

    phrasings: tuple[str, ...]
    log_odds: tuple[float, float]
    threshold: float


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Patches with goals: their cosines, whether the patch shows the goal, and their weights."""

    cosines: NDArray[np.float64]
    outcomes: NDArray[np.float64]
    weights: NDArray[np.float64]

    @classmethod
    def joined(cls, several: Sequence[_Pairs]) -> _Pairs:
        """Those of several homes."""
        names = "cosines", "outcomes", "weights"
        return cls(*(np.concatenate([getattr(each, name) for each in several]) for name in names))

    def log_odds(self) -> tuple[float, float]:
        """Scale and bias that fit them best."""
        mean, spread = self.cosines.mean(), max(self.cosines.std(), 1e-9)
        inputs = np.stack([(self.cosines - mean) / spread, np.ones_like(self.cosines)], axis=1)
        slope, level = logistic(inputs, self.outcomes, self.weights).tolist()
        return float(slope / spread), float(level - slope * mean / spread)

    def loss(self, log_odds: tuple[float, float]) -> float:
        """Mean log loss of these scale and bias."""
        odds = log_odds[0] * self.cosines + log_odds[1]
        losses = np.logaddexp(0.0, np.where(self.outcomes == 1.0, -odds, odds))
        return float(np.average(losses, weights=self.weights))

    def threshold(self, log_odds: tuple[float, float]) -> float:
        """The least cosine above which `RIGHT` of them show the goal; even odds where none is."""
        order = np.argsort(-self.cosines)
        right = np.cumsum(self.outcomes[order]) / np.arange(1, len(order) + 1)
        enough = np.flatnonzero(right >= RIGHT).max(initial=0)
        even = -log_odds[1] / log_odds[0]
        return float(
            np.clip(self.cosines[order[enough]] if enough >= _LEAST_PAIRS else even, -0.999, 0.999)
        )


def fit_cosines(homes: Sequence[ShownPlaces], encoder: TextEncoder) -> CosineFit:
    """Scale and bias that make log odds of a cosine, the threshold, and the phrasings.

    The log odds are those of a patch that shows a goal as often as evidence is measured from
    (`mapping.clip.places.evidence.PRIOR`). The ensemble of phrasings is taken where it lowers the
    log loss in each half of the homes, fitted in the other one.

    Raises:
        ConfigError: cosines of what is shown are not higher than others.
    """
    bare, phrased = (
        [_pairs(home, encoder, phrasings) for home in homes] for phrasings in (BARE, ENSEMBLE)
    )
    of_words = _Pairs.joined(bare)
    log_odds = of_words.log_odds()
    if not log_odds[0] * of_words.cosines.std() > _LEAST_SLOPE:
        raise ConfigError(
            f"{encoder.model_id} does not tell what its pictures show: nothing can be fitted to"
            " it, and nothing was written; take another encoder"
        )
    threshold = of_words.threshold(log_odds)
    losses = zip(_held_out_losses(bare), _held_out_losses(phrased), strict=True)
    if all(of_phrased < of_bare for of_bare, of_phrased in losses):
        return CosineFit(ENSEMBLE, _Pairs.joined(phrased).log_odds(), threshold)
    return CosineFit(BARE, log_odds, threshold)


def _held_out_losses(pairs: Sequence[_Pairs]) -> list[float]:
    """The log loss in each half of the homes of what fits the other one."""
    halves = [_Pairs.joined(pairs[half::2]) for half in (0, 1)]
    if not all(len(half.cosines) for half in halves):
        return [0.0, 0.0]  # too little to choose by
    return [halves[1 - i].loss(halves[i].log_odds()) for i in (0, 1)]


def _pairs(home: ShownPlaces, encoder: TextEncoder, phrasings: Sequence[str]) -> _Pairs:
    """The patches of a home with its goals. Every goal counts the same."""
    count = len(home.embeddings)
    shown = np.bincount(home.patches.ravel(), minlength=count)
    goals = list(home.true)
    cosines = home.embeddings @ embed_phrased(encoder, goals, phrasings).T
    found = [_Pairs(*np.zeros((3, 0)))]
    for column, goal in enumerate(goals):
        there = are_true(home.places, *home.true[goal])
        hits = np.bincount(home.patches.ravel(), np.repeat(there, 3), minlength=count)
        shares = hits / np.maximum(shown, 1)
        parts = (
            ((shares >= CLEAR) & (shown > 0), 1.0, PRIOR),
            ((hits == 0) & (shown > 0), 0.0, 1.0 - PRIOR),
        )
        if not all(chosen.any() for chosen, _, _ in parts):
            continue
        for chosen, outcome, share in parts:
            number = int(chosen.sum())
            found.append(
                _Pairs(
                    cosines[chosen, column].astype(np.float64),
                    np.full(number, outcome),
                    np.full(number, share / number),
                )
            )
    return _Pairs.joined(found)
