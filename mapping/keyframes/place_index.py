"""An index of keyframes by their binary descriptors, to find those that look like an image.

Locality-sensitive hashing by bit sampling (Indyk and Motwani 1998): each table reads some fixed
bits of a descriptor as a word; descriptors of one corner differ in few bits, so they share the
words of some tables. Keyframes that share many rare words with an image come first. It needs no
training and no vocabulary file.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.config import PlaceIndexConfig
from mapping.odometry.features import Features

_DESCRIPTOR_BITS = 256


class PlaceIndex:
    """The words of all keyframes, and how many keyframes have each."""

    def __init__(self, config: PlaceIndexConfig) -> None:
        self._config = config
        rng = np.random.default_rng(0)
        self._sampled = np.stack(
            [rng.permutation(_DESCRIPTOR_BITS)[: config.bits] for _ in range(config.tables)]
        )
        size = config.tables << config.bits
        self._frequency = np.zeros(size, np.int32)
        self._words: list[NDArray[np.int32]] = []
        self._keyframes: list[int] = []
        self._all: tuple[NDArray[np.int32], NDArray[np.int32]] | None = None

    def add(self, keyframe: int, features: Features) -> None:
        """Add the words of a keyframe."""
        words = self._words_of(features)
        self._frequency[words] += 1
        self._words.append(words)
        self._keyframes.append(keyframe)
        self._all = None

    def most_similar(self, features: Features, count: int) -> list[tuple[int, float]]:
        """The `count` keyframes that look most like an image, the best first, each with its score.

        A word counts less, the more keyframes have it (inverse document frequency). Scores are
        normalised by the number of words, so that rich keyframes have no advantage.
        """
        if not self._keyframes:
            return []
        if self._all is None:
            counts = [len(words) for words in self._words]
            owner_of = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
            self._all = np.concatenate(self._words), owner_of
        words, owners = self._all
        queried = self._words_of(features)
        rarity = np.zeros(len(self._frequency), np.float32)
        rarity[queried] = np.log((1 + len(self._words)) / (1 + self._frequency[queried]))
        shared = np.bincount(owners, weights=rarity[words], minlength=len(self._words))
        sizes = np.array([max(len(w), 1) for w in self._words])
        scores = shared / np.sqrt(sizes * max(len(queried), 1))
        best = np.argsort(-scores, kind="stable")[:count]
        return [(self._keyframes[i], float(scores[i])) for i in best.tolist()]

    def _words_of(self, features: Features) -> NDArray[np.int32]:
        """Distinct words (M,), sorted; those of table t start at t << bits."""
        if len(features.pixels) == 0:
            return np.zeros(0, np.int32)
        bits = np.unpackbits(features.descriptors.view(np.uint8), axis=1)
        weights = 1 << np.arange(self._config.bits)
        words = bits[:, self._sampled] @ weights + (
            np.arange(self._config.tables) << self._config.bits
        )
        return np.unique(words).astype(np.int32)
