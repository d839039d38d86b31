"""Sentences that the patterns of a grammar make, and which of them sound like what was heard.

Whisper spells what it does not expect by its sound: "Scene the whole house", "Hand to the start".
"""

from __future__ import annotations

import random
import re
from collections.abc import Sequence
from dataclasses import dataclass

from vizbot.operator.language.command_grammar import Grammar
from vizbot.operator.voice.likeness import NEAR, nearness, plain_words, similarity, sounds

_DRAWN = 200
"""Sentences that are drawn of each pattern."""
_ROUGHLY = 60
"""Sentences that are most alike by their sounds alone, which are looked at closer."""
_MOST_WORDS = 9
_FREE_SLOTS = ("{rest}", "{word}")
"""What reads any words: no sentence is made of a pattern with one of these."""
_THING = "xx"
"""Stands for a thing in the sentences that are compared."""


_MARKS = re.compile(r"[^\w' -]")


@dataclass(frozen=True, slots=True)
class _Entry:
    text: str
    sounds: str


class SentenceBank:
    """The sentences of one grammar, whole ones and ones about a thing."""

    def __init__(self, grammar: Grammar) -> None:
        """Draw them, the same ones each time."""
        rng = random.Random(0)
        drawn: dict[str, None] = {}
        for rule in grammar.rules:
            for _ in range(_DRAWN):
                slots = {
                    "goal": "the {goal}",
                    "number": rng.choice(_numbers(rule.kind)),
                    "unit": "metres",
                    "word": "{word}",
                    "rest": "{rest}",
                }
                drawn[rule.pattern.sentence(slots, rng)] = None
        made = [text for text in drawn if text and not any(slot in text for slot in _FREE_SLOTS)]
        self._whole = [_Entry(text, sounds(text)) for text in made if "{goal}" not in text]
        about = (text.replace("{goal}", _THING) for text in made if "{goal}" in text)
        self._about = [_Entry(text, sounds(text)) for text in about]

    def nearest(self, heard: str, vocabulary: Sequence[str], most: int) -> list[str]:
        """Sentences that sound like what was heard, the most alike first.

        Args:
            heard: A sentence.
            vocabulary: Things that may be in it.
            most: How many at most.
        """
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
        near = [text for text in ranked if likeness[text] >= NEAR][:most]
        return [_written(text.replace(_THING, thing), heard) for text in near]


def _numbers(kind: str) -> Sequence[str]:
    return ("one", "two") if kind == "forward" else ("ten", "thirty", "forty-five", "ninety")


def _written(text: str, heard: str) -> str:
    """A sentence as Whisper writes it, with the mark at the end of what was heard."""
    mark = heard[-1] if heard[-1:] in ".!?" else "."
    return f"{text[:1].upper()}{text[1:]}{mark}"
