"""Synonyms of the vocabulary that the text stage learns, and those that are withheld from it.

A fifth is withheld, drawn by a seed, to examine the look-up of words on them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from training.captions.spoken_phrasing import SEED, WITHHELD_SHARE
from vizbot.core.home_vocabulary import ROOMS, SYNONYMS

_ALL = tuple(
    (word, name) for table in (SYNONYMS, ROOMS) for name, words in table.items() for word in words
)


def _withheld() -> Mapping[str, str]:
    count = round(WITHHELD_SHARE * len(_ALL))
    chosen = np.random.default_rng((SEED, 1)).permutation(len(_ALL))[:count]
    return {_ALL[i][0]: _ALL[i][1] for i in sorted(chosen.tolist())}


WITHHELD_SYNONYMS: Mapping[str, str] = _withheld()
"""Class or room of each withheld synonym."""
TRAINED_SYNONYMS: Mapping[str, str] = {
    word: name for word, name in _ALL if word not in WITHHELD_SYNONYMS
}
"""Class or room of each of the others."""

_WITHHELD_WORDS = re.compile(rf"\b({'|'.join(map(re.escape, WITHHELD_SYNONYMS))})(e?s)?\b")


def has_withheld_synonym(text: str) -> bool:
    """Whether a text has one of the withheld synonyms, also in the plural."""
    return _WITHHELD_WORDS.search(text) is not None
