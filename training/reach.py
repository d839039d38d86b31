"""How many patches a text reaches at the threshold, of those that the bare name reaches.

The question is put for each phrasing by itself, with the threshold that a search decides by. There
are no candidates to choose from, so nothing is right by chance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.clip.encoder import ClipEncoder
from training.captions.facts import FACT_INDEX, Facts
from training.captions.spoken_phrasing import spoken

CLEARLY = 0.6
"""Least strength of the class of a patch."""
ENOUGH = 10
"""Patches that a bare name has to reach, for its class to take part."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedPatches:
    """The patches that bare names reach.

    Attributes:
        embeddings: Embeddings (P, D) of the patches that show a class clearly and that its bare
            name reaches, by the class; classes with `ENOUGH` of them.
        shares: Share of the patches that show a class clearly that its bare name reaches, by the
            class; all classes with `ENOUGH` clear patches.
    """

    embeddings: Mapping[str, NDArray[np.float32]]
    shares: Mapping[str, float]

    @staticmethod
    def from_names(
        embeddings: NDArray[np.float32], facts: Facts, encoder: ClipEncoder, names: Sequence[str]
    ) -> NamedPatches:
        """Ask for each of `names` bare, on patches with `embeddings` (N, D) and `facts`."""
        truth = np.nan_to_num(facts.columns(np.array([FACT_INDEX[name] for name in names])))
        reached, shares = {}, {}
        for name, column, text in zip(names, truth.T, encoder.embed_texts(names), strict=True):
            clear = embeddings[column >= CLEARLY]
            those = clear[clear @ text > encoder.threshold]
            if len(clear) >= ENOUGH:
                shares[name] = len(those) / len(clear)
            if len(those) >= ENOUGH:
                reached[name] = those
        return NamedPatches(reached, shares)

    def reach_of(self, texts: Mapping[str, str], encoder: ClipEncoder) -> float:
        """Part of the patches that `texts`, by the class, reach, too; mean of the classes."""
        asked = {name: text for name, text in texts.items() if name in self.embeddings}
        rows = encoder.embed_texts(list(asked.values()))
        parts = [
            float((self.embeddings[name] @ row > encoder.threshold).mean())
            for name, row in zip(asked, rows, strict=True)
        ]
        return float(np.mean(parts)) if parts else np.nan

    def reach_of_phrasing(self, way: str, encoder: ClipEncoder) -> float:
        """`reach_of` a phrasing of all classes."""
        return self.reach_of({name: spoken(way, name) for name in self.embeddings}, encoder)
