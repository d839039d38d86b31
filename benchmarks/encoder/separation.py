"""How well the similarities of an encoder separate patches that show a thing from all others."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.scores import expected_calibration_error
from training.evaluation import CLEARLY, ENOUGH, area_under_curve
from vizbot.core.files import write_whole

FALSE_SHARE = 0.01
"""Share of the patches without a thing that are taken for it, where recall is measured."""
LEAST_WITHOUT = 100
"""Patches without a thing that there have to be, so that a hundredth of them is one."""


@dataclass(frozen=True, slots=True, eq=False)
class AskedPatches:
    """Patches that were asked for things by name, P patches and C names.

    Attributes:
        similarities: (P, C) float32, cosines of patch and name.
        shown: (P, C) float32, how clearly each thing is shown, 0 to 1; NaN where it is disputable.
        edges: (P,) int64, edge of each patch in its picture [px].
        models: (P,) model of the thing that takes up most of each patch; empty for none.
    """

    similarities: NDArray[np.float32]
    shown: NDArray[np.float32]
    edges: NDArray[np.int64]
    models: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.edges)

    @classmethod
    def load(cls, file: Path) -> AskedPatches:
        """Read what `save` wrote."""
        with np.load(file, allow_pickle=False) as arrays:
            return cls(*(arrays[field.name] for field in fields(cls)))

    def save(self, file: Path) -> None:
        """Write a file, whole or not at all."""
        content = io.BytesIO()
        np.savez(content, **{field.name: getattr(self, field.name) for field in fields(self)})
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, content.getvalue())

    @classmethod
    def joined(cls, several: Sequence[AskedPatches]) -> AskedPatches:
        """All patches of `several`, one after another."""
        return cls(
            np.concatenate([each.similarities for each in several]),
            np.concatenate([each.shown for each in several]),
            np.concatenate([each.edges for each in several]),
            np.concatenate([each.models for each in several]),
        )


@dataclass(frozen=True, slots=True)
class Separation:
    """How well one name is told from everything else.

    Attributes:
        clear: Number of patches that show the thing clearly.
        auc: Probability that one of those is more similar to the name than a patch without it.
        recall: Share of those above the similarity that `FALSE_SHARE` of the others exceed.
        above_even: Share of those that the encoder takes for the thing, by its own threshold.
    """

    clear: int
    auc: float
    recall: float
    above_even: float


def separations(
    asked: AskedPatches,
    names: Sequence[str],
    threshold: float,
    chosen: NDArray[np.bool_] | None = None,
) -> dict[str, Separation]:
    """How well each name is told apart that enough patches show clearly, and enough do not show.

    Args:
        asked: The patches.
        names: The names (C,) that they were asked for.
        threshold: Similarity above which the encoder takes a patch for what it is asked for.
        chosen: (P,) the patches with a thing that count; all by default. Those without it are the
            same for every choice, so that two choices can be compared.
    """
    found = {}
    for name, similarity, shown in zip(names, asked.similarities.T, asked.shown.T, strict=True):
        clear = shown >= CLEARLY
        clear = clear if chosen is None else clear & chosen
        with_it, without = similarity[clear], similarity[shown == 0]
        if len(with_it) >= ENOUGH and len(without) >= LEAST_WITHOUT:
            bar = np.sort(without)[-1 - int(FALSE_SHARE * len(without))]
            found[name] = Separation(
                len(with_it),
                area_under_curve(with_it, without),
                float((with_it > bar).mean()),
                float((with_it > threshold).mean()),
            )
    return found


def reliability(asked: AskedPatches, log_odds: tuple[float, float]) -> float | None:
    """How far the encoder's own probabilities are from the truth (expected calibration error).

    Disputable patches are left out. `log_odds` are scale and bias, as of `TextEncoder.log_odds`.
    """
    known = ~np.isnan(asked.shown)
    odds = log_odds[0] * asked.similarities[known] + log_odds[1]
    probabilities = 1.0 / (1.0 + np.exp(-np.clip(odds, -30.0, 30.0)))
    return expected_calibration_error(
        list(zip(probabilities.tolist(), (asked.shown[known] > 0).tolist(), strict=True))
    )


def mean_over_names(found: Mapping[str, Separation], of: str) -> float | None:
    """Mean of one figure over names, rare ones as much as common ones; None without any."""
    return float(np.mean([getattr(each, of) for each in found.values()])) if found else None
