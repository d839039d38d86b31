"""The pool of training patches, drawn so that rare things come up often."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from training.captions.facts import FACTS, Facts
from training.views import LabelledPatches

LARGE = (380, 190)
"""Least edges of the largest patches and of those of medium size [px]."""


class PatchPool:
    """All patches of the rendered homes, drawn so that rare things come up often."""

    def __init__(self, files: Sequence[Path]) -> None:
        """Read all `files` into memory."""
        several = [LabelledPatches.load(path) for path in files]
        edges_of_file = [views.edges for views in several]
        self.facts = Facts.joined([views.facts for views in several])
        first = several[0].pixels
        self.pixels = np.empty((len(self.facts), *first.shape[1:]), first.dtype)
        end = len(self.facts)
        while several:  # there is hardly memory for all pixels twice
            pixels = several.pop().pixels
            self.pixels[end - len(pixels) : end] = pixels
            end -= len(pixels)
        edges = np.concatenate(edges_of_file)
        self._cumulative = np.cumsum(_weights(self.facts, edges))

    def __len__(self) -> int:
        return len(self.pixels)

    def draw(self, rng: np.random.Generator, count: int) -> NDArray[np.int64]:
        """Indices (count,) of patches."""
        at = rng.random(count) * self._cumulative[-1]
        return np.asarray(np.searchsorted(self._cumulative, at))


def _weights(facts: Facts, edges: NDArray[np.int32]) -> NDArray[np.float64]:
    """Weight of each patch: the rarer the things that it shows, the higher.

    A large patch that shows nothing, a bare wall, is drawn as often as others are on average: the
    robot sees many, and they are what it takes for something.
    """
    by_name = np.array([fact.family in ("thing", "room") for fact in FACTS])
    strengths = np.where(by_name[facts.indices], np.nan_to_num(facts.strengths), 0.0)
    shown = np.bincount(facts.indices, strengths, minlength=len(FACTS))
    share = strengths / np.maximum(shown[facts.indices], 30.0) ** 0.7
    rows = np.repeat(np.arange(len(facts)), np.diff(facts.starts))
    weights = np.bincount(rows, share, minlength=len(facts))
    bare = np.select([edges >= LARGE[0], edges >= LARGE[1]], [1.0, 0.3], 0.1)
    return np.asarray(weights + bare * weights.mean())
