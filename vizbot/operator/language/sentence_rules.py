"""The patterns of a language as rules that read what people say."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from vizbot.operator.language.notation import SLOTS, Pattern, read_pattern


@dataclass(frozen=True, slots=True)
class SentenceRule:
    """One pattern of a language.

    Attributes:
        kind: What it asks for.
        pattern: How that is said.
        regex: The regular expression that reads it, after a blank.
    """

    kind: str
    pattern: Pattern
    regex: str

    @property
    def takes_any_words(self) -> bool:
        """Whether some of its words may be any."""
        return f" {SLOTS['rest']}" in self.regex

    def read(self, words: str) -> re.Match[str] | None:
        """What it reads in some words; None where it does not read all of them."""
        return _compiled(self.regex).fullmatch(f" {words}")


class RuleMaker:
    """Makes the rules of one language, and reads the numbers in what they have read."""

    def __init__(self, language: Mapping[str, Any]) -> None:
        """Take over a language, as its file has it.

        Raises:
            KeyError: it lacks something.
        """
        numbers, units = language["numbers"], language["units"]
        self._numbers = {word.casefold(): float(value) for word, value in numbers.items()}
        self._units = {word.casefold(): float(value) for word, value in units.items()}
        self._parts = {**language["parts"], "going": language["going"]["ways"]}

    def rules(self, patterns: Mapping[str, Sequence[str]]) -> tuple[SentenceRule, ...]:
        """The rules of some patterns.

        Args:
            patterns: In the notation, for each kind.

        Raises:
            ValueError: one is none.
        """
        read = (
            (kind, read_pattern(text, self._parts))
            for kind, texts in patterns.items()
            for text in texts
        )
        return tuple(SentenceRule(kind, each, self.regex(each)) for kind, each in read)

    def part(self, name: str) -> str:
        """The regular expression of a part of patterns that has a name.

        Raises:
            KeyError: there is none of that name.
            ValueError: it is no pattern.
        """
        return self.regex(read_pattern(self._parts[name], self._parts))

    def regex(self, pattern: Pattern) -> str:
        """The regular expression of a pattern, whose slots have names of their own."""
        regex = pattern.regex(tuple(self._numbers), tuple(self._units))
        for name in ("goal", "number", "unit"):
            parts = regex.split(f"(?P<{name}>")
            numbered = (f"(?P<{name}_{place}>{part}" for place, part in enumerate(parts[1:]))
            regex = "".join([parts[0], *numbered])
        return regex

    def amount(self, found: re.Match[str], least: float = 0.0) -> float | None:
        """The number that a rule has read, in the base of its unit; None where it read none.

        Args:
            found: What it has read.
            least: A smaller number in words is none: "turn a left" is about no degree.
        """
        number, unit = slot(found, "number"), slot(found, "unit")
        if not number or self._numbers.get(number, least) < least:
            return None
        in_words = self._numbers.get(number)
        value = float(number.replace(",", ".")) if in_words is None else in_words
        return value * self._units.get(unit, 1.0)


@cache
def _compiled(regex: str) -> re.Pattern[str]:
    """Compiled where it is first needed: most commands read no sentence."""
    return re.compile(regex)


def readings(
    ways: Sequence[str], rules: Iterable[SentenceRule]
) -> Iterator[tuple[SentenceRule, re.Match[str]]]:
    """Each rule that reads the first way to read a step, then those that read another one."""
    for way in ways:
        for rule in rules:
            if (found := rule.read(way)) is not None:
                yield rule, found


def is_read(way: str, rules: Iterable[SentenceRule]) -> bool:
    """Whether a rule reads some words."""
    return next(readings([way], rules), None) is not None


def slot(found: re.Match[str], name: str) -> str:
    """What a slot of a pattern has read; empty where the pattern was read without it."""
    read = (words for key, words in found.groupdict().items() if key.startswith(name) and words)
    return next(read, "")
