"""The patterns of a language as rules that read what people say."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

from vizbot.operator.language.notation import Pattern, read_pattern
from vizbot.operator.language.step_splitter import by_word

_KEPT = 4096
"""First words whose rules are kept."""


@dataclass(frozen=True, eq=False)
class SentenceRule:
    """One pattern of a language.

    Attributes:
        kind: What it asks for.
        pattern: How that is said.
        maker: Makes the regular expression of the pattern.
    """

    kind: str
    pattern: Pattern
    maker: RuleMaker

    @property
    def takes_any_words(self) -> bool:
        """Whether some of its words may be any."""
        return self.pattern.has("{rest}")

    def begins(self, word: str) -> bool:
        """Whether it may read words that begin with this one."""
        return not self._first_words or word in self._first_words

    def fits(self, words: frozenset[str]) -> bool:
        """Whether it may read such words, with one of which it begins, at a first look."""
        return not any(mark.isdisjoint(words) for mark in self._marks)

    def read(self, words: str) -> re.Match[str] | None:
        """What it reads in some words; None where it does not read all of them."""
        return self._regex.fullmatch(f" {words}")

    @cached_property
    def _first_words(self) -> set[str]:
        """Words with one of which it begins; empty where that may be any word."""
        first = self.pattern.first_words()
        return set() if any(word[:1] in ("", "{") for word in first) else first

    @cached_property
    def _marks(self) -> Sequence[set[str]]:
        return self.pattern.marks()

    @cached_property
    def _regex(self) -> re.Pattern[str]:
        """Reads it after a blank; made when it is first needed: few rules are, for a sentence."""
        return re.compile(self.maker.regex(self.pattern))


class RuleMaker:
    """Makes the rules of one language, and reads the numbers in what they have read."""

    def __init__(self, language: Mapping[str, Any]) -> None:
        self._numbers = {word: float(n) for word, n in by_word(language["numbers"]).items()}
        self._units = {word: float(n) for word, n in by_word(language["units"]).items()}
        self._parts = {**language["parts"], "going": language["going"]["ways"]}

    def rules(self, patterns: Mapping[str, Sequence[str]]) -> tuple[SentenceRule, ...]:
        """The rules of some patterns.

        Raises:
            ValueError: one is none.
        """
        read = (
            (kind, read_pattern(text, self._parts))
            for kind, texts in patterns.items()
            for text in texts
        )
        return tuple(SentenceRule(kind, each, self) for kind, each in read)

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

        A number in words below `least` is none: "turn a left" is about no degree.
        """
        number, unit = slot(found, "number"), slot(found, "unit")
        if not number or self._numbers.get(number, least) < least:
            return None
        in_words = self._numbers.get(number)
        value = float(number.replace(",", ".")) if in_words is None else in_words
        return value * self._units.get(unit, 1.0)


def readings(
    ways: Sequence[str], rules: Iterable[SentenceRule]
) -> Iterator[tuple[SentenceRule, re.Match[str]]]:
    """Each rule that reads the first way to read a step, then those that read another one."""
    rules = tuple(rules)
    for way in ways:
        first, words = way.partition(" ")[0], frozenset(way.split(" "))
        for rule in _beginning(rules, first):
            if rule.fits(words) and (found := rule.read(way)) is not None:
                yield rule, found


@lru_cache(_KEPT)
def _beginning(rules: tuple[SentenceRule, ...], word: str) -> tuple[SentenceRule, ...]:
    return tuple(rule for rule in rules if rule.begins(word))


def is_read(way: str, rules: Iterable[SentenceRule]) -> bool:
    """Whether a rule reads some words."""
    return next(readings([way], rules), None) is not None


def slot(found: re.Match[str], name: str) -> str:
    """What a slot of a pattern has read; empty where the pattern was read without it."""
    read = (words for key, words in found.groupdict().items() if key.startswith(name) and words)
    return next(read, "")
