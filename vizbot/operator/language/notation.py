"""The notation in which the data of a language writes what people say.

`(go|drive) [over] to {goal}` stands for four ways to ask: `(a|b)` is one of these, `[a|b]` one of
these or none, `{goal}` any words, and `<name>` a part that has a name of its own. A pattern reads a
line, and it makes the sentences that the tests say.
"""

from __future__ import annotations

import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

SLOTS: Mapping[str, str] = {
    "goal": r"(?P<goal>.+?)",
    "number": r"(?P<number>{numbers})",
    "unit": r"(?P<unit>{units})",
    "word": r"[\w']+",
    "rest": r".+",
}
"""What each slot reads; `{numbers}` and `{units}` are those of the language."""

_TOKEN = re.compile(r"[()\[\]|]|\{\w+\}|[^\s()\[\]|{}]+")
_PART = re.compile(r"<(\w+)>")


@dataclass(frozen=True, slots=True)
class Pattern:
    """Ways to say one thing.

    Attributes:
        alternatives: Each a sequence of words, slots in braces, and patterns.
        optional: Whether it may be left out.
    """

    alternatives: tuple[tuple[str | Pattern, ...], ...]
    optional: bool = False

    def regex(self, numbers: Sequence[str] = (), units: Sequence[str] = ()) -> str:
        """What matches a blank and the words, once for each pattern that begins with a blank.

        Of alternatives those of more words are tried first: "go to {goal}" before "go {goal}".

        `numbers` and `units` are words for a number, beside digits, and for a unit of length.
        """
        ways = "|".join(
            "".join(
                _word_regex(piece, numbers, units)
                if isinstance(piece, str)
                else piece.regex(numbers, units)
                for piece in way
            )
            for way in sorted(self.alternatives, key=len, reverse=True)
        )
        return f"(?:{ways}){'?' if self.optional else ''}"

    def first_words(self) -> set[str]:
        """Words and slots that it may begin with; an empty one where it may read none."""
        first = {""} if self.optional else set[str]()
        for way in self.alternatives:
            begins = {""}
            for piece in way:
                begins.remove("")
                begins |= _first_words(piece)
                if "" not in begins:
                    break
            first |= begins
        return first

    def marks(self) -> tuple[set[str], ...]:
        """Sets of words, of each of which one is in all that it reads: a cheap first look."""
        ways = self.alternatives if not self.optional else ()
        firsts = [_first_words(piece) for piece in ways[0]] if len(ways) == 1 else []
        return tuple(first for first in firsts if not any(word[:1] in ("", "{") for word in first))

    def has(self, word: str) -> bool:
        """Whether a word or a slot is in it."""
        pieces = (piece for way in self.alternatives for piece in way)
        return any(piece == word if isinstance(piece, str) else piece.has(word) for piece in pieces)

    def sentence(self, slots: Mapping[str, str], rng: random.Random) -> str:
        """One way to say it, drawn at random: half of the time the first one, the usual one."""
        if self.optional and rng.random() < 0.5:
            return ""
        pieces = [
            (slots[piece[1:-1]] if piece.startswith("{") else piece)
            if isinstance(piece, str)
            else piece.sentence(slots, rng)
            for piece in self._drawn(rng)
        ]
        return " ".join(piece for piece in pieces if piece)

    def _drawn(self, rng: random.Random) -> tuple[str | Pattern, ...]:
        return self.alternatives[0] if rng.random() < 0.5 else rng.choice(self.alternatives)


def read_pattern(text: str, parts: Mapping[str, str]) -> Pattern:
    """The pattern of a text in the notation; `parts` has what each `<name>` in it stands for.

    Raises:
        ValueError: the text is none: a bracket is open, a part or a slot is unknown.
    """
    while (named := _PART.search(text)) is not None:
        if named[1] not in parts:
            raise ValueError(f"{text!r}: there is no part <{named[1]}>")
        text = text.replace(named[0], f"({parts[named[1]]})")
    tokens = _TOKEN.findall(text)
    pattern = _alternatives(tokens, "")
    if tokens:
        raise ValueError(f"{text!r}: {tokens[0]} closes nothing")
    return pattern


def _alternatives(tokens: list[str], end: str) -> Pattern:
    """The pattern at the beginning of the tokens, which are used up to `end`."""
    ways: list[tuple[str | Pattern, ...]] = []
    way: list[str | Pattern] = []
    while tokens and tokens[0] not in (")", "]"):
        token = tokens.pop(0)
        if token == "|":
            ways.append(tuple(way))
            way = []
        elif token in ("(", "["):
            way.append(_alternatives(tokens, ")" if token == "(" else "]"))
        elif token.startswith("{") and token[1:-1] not in SLOTS:
            raise ValueError(f"there is no slot {token}")
        else:
            way.append(token)
    if end and (not tokens or tokens.pop(0) != end):
        raise ValueError(f"a {end} is missing")
    return Pattern((*ways, tuple(way)), optional=end == "]")


def _first_words(piece: str | Pattern) -> set[str]:
    return {piece.casefold()} if isinstance(piece, str) else piece.first_words()


def _word_regex(word: str, numbers: Sequence[str], units: Sequence[str]) -> str:
    if not word.startswith("{"):
        return " " + re.escape(word.casefold())
    slot = SLOTS[word[1:-1]]
    if "{" not in slot:
        return f" {slot}"
    words = {
        "numbers": "|".join([r"-?\d+(?:[.,]\d+)?", *map(re.escape, numbers)]),
        "units": "|".join(map(re.escape, units)) or "(?!)",
    }
    for name, choice in words.items():
        slot = slot.replace(f"{{{name}}}", choice)
    return " " + slot
