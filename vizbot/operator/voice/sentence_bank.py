"""Sentences that the patterns of a grammar make, and which of them sound like what was heard.

Whisper spells what it does not expect by its sound: "Scene the whole house", "Hand to the start".
How alike two phrases are goes by their letters and by their sounds, those of metaphone: consonants
by how they are spoken, vowels left out.
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from jellyfish import jaro_winkler_similarity, levenshtein_distance, metaphone

from vizbot.operator.language.command_grammar import Grammar
from vizbot.operator.language.notation import SLOTS, Pattern
from vizbot.operator.language.phrase_grammar import Phrasing

_MOST = 400
"""Sentences of each pattern: all that it makes, or as many that are drawn."""
_OF_MANY = ("all", "how_many")
"""Kinds of pattern that name several of a kind: there are no sentences of them."""
_ALIKE = 0.5
"""Likeness from which a sentence is worth a comparison with the sound."""
_ROUGHLY = 60
"""Sentences that are most alike by their sounds alone, which are looked at closer."""
_MOST_WORDS = 9
_THING = "xx"
"""Stands for a thing in the sentences that are compared."""
_MARKS = re.compile(r"[^\w' -]")


@dataclass(frozen=True, slots=True)
class _Entry:
    text: str
    sounds: str


class SentenceBank:
    """The sentences of one grammar, whole ones and ones about a thing.

    It has none with a number or with words that may be any.
    """

    def __init__(self, grammar: Grammar, phrasing: Phrasing) -> None:
        """Draw them, the same ones each time."""
        rng = random.Random(0)
        thing = f"{phrasing.article} {_THING}".strip()
        slots = {name: f"{{{name}}}" for name in SLOTS} | {"goal": thing}
        drawn = dict[str, None]()
        for rule in grammar.rules:
            if rule.kind in _OF_MANY:
                continue
            if _count(rule.pattern) <= _MOST:
                drawn |= dict.fromkeys(_sentences(rule.pattern, slots))
            else:
                drawn |= {rule.pattern.sentence(slots, rng): None for _ in range(_MOST)}
        entries = [_Entry(text, sounds(text)) for text in drawn if text and "{" not in text]
        self._whole = [entry for entry in entries if _THING not in entry.text]
        self._about = [entry for entry in entries if _THING in entry.text]
        self._phrasing = phrasing

    def nearest(self, heard: str, vocabulary: Sequence[str], most: int) -> list[str]:
        """Sentences that sound like what was heard, the most alike first."""
        words = plain_words(_MARKS.sub(" ", heard))
        thing = max((name for name in vocabulary if f" {name}" in f" {words}"), key=len, default="")
        asked = words.replace(thing, _THING, 1) if thing else words
        if not asked or len(asked.split()) > _MOST_WORDS:
            return []
        entries, heard_sounds = self._about if thing else self._whole, sounds(asked)
        rough = sorted(
            entries,
            key=lambda entry: -nearness(entry.sounds, heard_sounds),
        )[:_ROUGHLY]
        likeness = {entry.text: similarity(entry.text, asked) for entry in rough}
        ranked = sorted(likeness, key=lambda text: -likeness[text])
        near = [text for text in ranked if likeness[text] >= _ALIKE][:most]
        return [_written(text.replace(_THING, thing), heard) for text in near]

    def mission(self, heard: str, vocabulary: Sequence[str]) -> str | None:
        """The mission of two or three things that sounds like what was heard; None for no such one.

        Each thing must have been heard as it is written; what stands around them may be spelt by
        its sound, as in "Go to the lamp. In the sofa, and den to the sink, and dog."
        """
        words = plain_words(_MARKS.sub(" ", heard))
        names = map(re.escape, sorted(vocabulary, key=len, reverse=True))
        named = re.compile(rf"\b(?:{'|'.join(names)})\b")
        around, things = named.split(words), named.findall(words)
        if len(things) not in (2, 3) or self._phrasing.apart & {*" ".join(around).split()}:
            return None
        lead = _most_alike(around[0], self._phrasing.leads, NEAR)
        joins = [_most_alike(each, self._phrasing.joins, _ALIKE) for each in around[1:-1]]
        end = _most_alike(around[-1], self._phrasing.ends, _ALIKE) if around[-1].strip() else "."
        if lead is None or end is None or None in joins:
            return None
        rest = "".join(f"{join} {thing}" for join, thing in zip(joins, things[1:], strict=True))
        return f"{lead[:1].upper()}{lead[1:]} {things[0]}{rest}{end}"


def _most_alike(heard: str, texts: Sequence[str], least: float) -> str | None:
    """That of some texts which sounds most like what was heard; None where none is alike enough."""
    words = plain_words(heard)
    likeness = {text: similarity(plain_words(_MARKS.sub(" ", text)), words) for text in texts}
    best = max(likeness, key=likeness.__getitem__)
    return best if likeness[best] >= least else None


def _count(pattern: Pattern) -> int:
    """How many sentences a pattern makes."""
    ways = (
        prod(_count(piece) for piece in way if isinstance(piece, Pattern))
        for way in pattern.alternatives
    )
    return sum(ways) + pattern.optional


def _sentences(pattern: Pattern, slots: Mapping[str, str]) -> Iterator[str]:
    """All sentences that a pattern makes."""
    if pattern.optional:
        yield ""
    for way in pattern.alternatives:
        pieces = (
            [slots[piece[1:-1]] if piece.startswith("{") else piece]
            if isinstance(piece, str)
            else [*_sentences(piece, slots)]
            for piece in way
        )
        for chosen in product(*pieces):
            yield " ".join(filter(None, chosen))


def _written(text: str, heard: str) -> str:
    """A sentence as Whisper writes it, with the mark at the end of what was heard."""
    mark = heard[-1] if heard[-1:] in ".!?" else "."
    return f"{text[:1].upper()}{text[1:]}{mark}"


NEAR = 0.66
"""Likeness from which the robot asks back."""
_SOUND = 0.6
"""Weight of the sounds, beside that of the letters."""


def similarity(a: str, b: str) -> float:
    """How alike two phrases are by letters and sounds, 0 to 1."""
    letters = (jaro_winkler_similarity(a, b) + nearness(a, b)) / 2
    return _SOUND * nearness(sounds(a), sounds(b)) + (1.0 - _SOUND) * letters


def nearness(a: str, b: str) -> float:
    """Share of letters that need no change to make one of the other, 0 to 1."""
    return 1.0 - levenshtein_distance(a, b) / max(len(a), len(b), 1)


def sounds(words: str) -> str:
    """The sounds of words, without the gaps: "book shelf" sounds like "bookshelf"."""
    return metaphone(words.replace("'", "")).replace(" ", "")


def plain_words(words: str) -> str:
    """Words in small letters, without hyphens and more than one blank between them."""
    return " ".join(words.casefold().replace("-", " ").split())
