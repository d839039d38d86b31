"""Texts of a step of the text stage, each with the text whose embedding it shall have."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from training.captions import phrasing
from training.captions.captions import (
    NAMES,
    Caption,
    draw_captions,
    draw_colours,
    draw_contrasts,
    draw_negatives,
    plain_noun,
)
from training.captions.facts import FACTS, Fact, Facts
from training.captions.held_out_pairs import is_withheld
from training.captions.spoken_phrasing import (
    TRAINED_ADJECTIVES,
    TRAINED_SPOKEN,
    TRAINED_SYNONYMS,
    has_withheld_synonym,
    spoken,
)
from training.captions.unrelated_words import CAPTION_WORDS, HELD_OUT_WORDS
from vizbot.core.home_vocabulary import COLOURS, MATERIALS, ROOMS, THINGS

Random = np.random.Generator

_WAYS = (*TRAINED_SPOKEN, *phrasing.GO, *phrasing.THERE, *phrasing.PHOTO)
_SINGULAR = tuple(way for way in _WAYS if "{many}" not in way)
_PLURAL = tuple(way for way in _WAYS if "{many}" in way)
UNKNOWN = 0.3
"""Share of the phrasings with a word that nobody knows in place of one of their own."""
_BY_FAMILY = {
    family: np.array([i for i, fact in enumerate(FACTS) if fact.family == family])
    for family in ("thing", "colour", "material", "count", "relation", "room")
}
_SHOWN = {"thing": 3, "colour": 2, "material": 1, "count": 1, "relation": 1, "room": 1}
"""Facts of each kind that an imagined patch shows."""


@dataclass(frozen=True, slots=True)
class TextPair:
    """A text to learn.

    Attributes:
        text: What a person may say.
        model: The text that the first stage embeds; the embedding is the one to learn.
    """

    text: str
    model: str


def draw_kept(rng: Random, n: int) -> list[TextPair]:
    """Captions of the first stage for `n` imagined patches, contrasts and negatives, and `n` names.

    They shall keep their embeddings.
    """
    facts = imagined_facts(rng, n)
    captions = [caption for i in range(n) for caption in draw_captions(facts, i, rng, 1)]
    for i in range(0, n, 2):
        captions += draw_contrasts(facts, i, rng, 1)
    for i in range(0, n, 8):
        captions += draw_colours(facts, i, rng)
    captions += draw_negatives(rng, n // 2)
    captions += [Caption(name, (name,)) for name in rng.choice(NAMES, n, replace=False)]
    texts = [caption.text for caption in captions if not has_withheld_synonym(caption.text)]
    return [TextPair(text, text) for text in texts]


def imagined_facts(rng: Random, n: int) -> Facts:
    """Facts of `n` patches that show some of everything."""
    rows = [
        np.unique(np.concatenate([rng.choice(_BY_FAMILY[f], k) for f, k in _SHOWN.items()]))
        for _ in range(n)
    ]
    indices = np.concatenate(rows).astype(np.int32)
    starts = np.concatenate([[0], np.cumsum([len(row) for row in rows])])
    return Facts(starts, indices, np.ones(len(indices), np.float32))


def draw_spoken(rng: Random, n: int) -> list[TextPair]:
    """At most `n` spoken phrasings, to be embedded like the plain phrase; none is withheld."""
    pairs = [_spoken_fact(rng) for _ in range(n)]
    return [pair for pair in pairs if pair is not None]


def draw_unrelated(rng: Random, n: int) -> list[TextPair]:
    """`n` spoken phrasings of what no picture shows, to be embedded like the bare word."""
    return [_phrased(word, word, rng, _WAYS) for word in (_unrelated(rng) for _ in range(n))]


def trained_words() -> frozenset[str]:
    """Words of all phrasings of both stages, without those of their nouns."""
    related = (way for ways in phrasing.RELATED.values() for way in ways)
    counted = (way for ways in phrasing.COUNTED.values() for way in ways)
    ways = (*_WAYS, *phrasing.ROOM, *phrasing.WITH_COLOUR, *phrasing.WITH_MATERIAL)
    text = " ".join((*ways, *related, *counted, *TRAINED_ADJECTIVES))
    return frozenset(re.findall(r"[a-z][a-z'-]*", re.sub(r"{\w*}", "", text)))


def _spoken_fact(rng: Random) -> TextPair | None:
    kind = rng.random()
    name = _any(NAMES, rng)
    facts: tuple[str, ...] = ()
    words, ways = name, _WAYS
    if kind < 0.2:
        words = _any(tuple(TRAINED_SYNONYMS), rng)
        name = TRAINED_SYNONYMS[words]
    elif kind < 0.4:
        words = name = f"{_any(tuple(COLOURS), rng)} {_any(THINGS, rng)}"
    elif kind < 0.45:
        words = name = f"{_any(tuple(MATERIALS.values()), rng)} {_any(THINGS, rng)}"
    elif kind < 0.5:
        words = name = f"{_any(THINGS, rng)} in the {_any(tuple(ROOMS), rng)}"
        ways = _SINGULAR
    elif kind < 0.68:
        ways = _PLURAL
    elif kind < 0.74:
        fact: Fact = FACTS[int(rng.choice(_BY_FAMILY["relation"]))]
        words = name = plain_noun(fact).words
        facts, ways = (fact.key,), _SINGULAR
    pair = _phrased(words, name, rng, ways)
    if is_withheld(pair.text, facts) or has_withheld_synonym(pair.text):
        return None
    return pair


def _phrased(words: str, model: str, rng: Random, ways: Sequence[str]) -> TextPair:
    if rng.random() < 0.35:
        words = f"{_any(TRAINED_ADJECTIVES, rng)} {words}"
        ways = ways if rng.random() < 0.5 else phrasing.PLAIN
    way = _any(ways, rng)
    if rng.random() < UNKNOWN:
        way = _with_unknown_word(way, rng)
    return TextPair(spoken(way, words), model)


def _with_unknown_word(way: str, rng: Random) -> str:
    """A phrasing with a spliced word in place of one of its words, or before the noun."""
    words = way.split()
    own = [i for i, word in enumerate(words) if "{" not in word]
    if not own or rng.random() < 0.2:
        return f"{_any(('a', 'the', 'my'), rng)} {spliced_word(rng)} {{bare}}"
    words[own[int(rng.random() * len(own))]] = spliced_word(rng)
    return " ".join(words)


def spliced_word(rng: Random) -> str:
    """The beginning of one unrelated word and the end of another; English in look, not in sense."""
    first, last = _any(CAPTION_WORDS, rng), _any(CAPTION_WORDS, rng)
    word = first[: (len(first) + 1) // 2] + last[len(last) // 2 :]
    return spliced_word(rng) if word in HELD_OUT_WORDS else word


def _unrelated(rng: Random) -> str:
    kind = rng.random()
    if kind < 0.3:
        return spliced_word(rng)
    word = _any(CAPTION_WORDS, rng)
    return f"{word} {_any(CAPTION_WORDS, rng)}" if kind < 0.4 else word


def _any(choices: Sequence[str], rng: Random) -> str:
    return choices[int(rng.random() * len(choices))]
