"""What words are for: to forbid, to set terms, to order, or for nothing at all."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from vizbot.operator.language.step_splitter import by_word, either


class Wording:
    """Tells the kinds of words of one language."""

    def __init__(self, language: Mapping[str, Any]) -> None:
        words, remarks, cannot = language["words"], language["remarks"], language["cannot"]
        verbs = either(language["imperatives"])
        idle = f"{either(words['idle'])}|{words['adverb']}"
        courteous = f"{idle}|{either(words['courtesy'])}"
        self._not = re.compile(rf"\b(?:{words['not'].casefold()})\b")
        self._harmless = re.compile(rf"\b(?:{either(remarks['harmless'])})\b")
        self._terms = re.compile(rf"\b(?:{either(remarks['never'])})\b")
        told = either([*remarks["finite"], *remarks["asides"]])
        joints = either([*words["and"], *words["before_then"]])
        self._aside = re.compile(
            rf"(?:(?:{joints}) )?(?!.*\b(?:{either(words['addressed'])})\b.)"
            rf"(?!(?:{either(by_word(language['numbers']))}) )"
            rf"(?:{either(remarks['subjects'])})\b.* (?:{told})\b"
        )
        beside = {*remarks["never"]} - {*remarks["asides"]}
        self._terms_beside = re.compile(rf"\b(?:{either(beside)})\b")
        self._clause = re.compile(rf"\b(?:{words['clause'].casefold()})\b")
        self._order = re.compile(rf"\b(?:{verbs}|{cannot['verbs']})\b")
        self._idle = re.compile(rf"(?>(?:(?> (?:{idle})(?= |$)))+)")
        self._courteous = re.compile(rf"(?>(?:(?> (?:{courteous})(?= |$)))+)")

    def forbids(self, words: str) -> bool:
        """Whether words say what must not be done."""
        return self._not.search(self._harmless.sub(" ", words)) is not None

    def sets_terms(self, words: str, *, aside: bool = False) -> bool:
        """Whether words report, wish, or set a condition or a time, beside what they tell.

        Args:
            words: They are said.
            aside: Whether they stand beside an order. Then a wish or a time is none of the
                order's where they tell of others than the robot: "we have to leave at noon".
        """
        aside = aside and not self.forbids(words) and self._aside.match(words) is not None
        terms = self._terms_beside if aside else self._terms
        return terms.search(self._harmless.sub(" ", words)) is not None

    def has_clause(self, words: str) -> bool:
        """Whether there is a word in them that no name of a thing has."""
        return self._clause.search(words) is not None

    def has_order(self, words: str) -> bool:
        """Whether there is the verb of an order in them, also of one that cannot be obeyed."""
        return self._order.search(words) is not None

    def begins_order(self, words: str) -> bool:
        """Whether they begin with such a verb."""
        return self._order.match(words) is not None

    def is_idle(self, words: str) -> bool:
        """Whether words are of courtesy alone, or say nothing at all."""
        return self._courteous.fullmatch(f" {words}") is not None and not self.begins_order(words)

    def leaves(self, rest: str) -> bool:
        """Whether words behind a thing leave it what it is: "quickly", "now that I see it"."""
        found = self._idle.match(f" {rest}")
        if found is None or found.end() == len(rest) + 1:
            return found is not None
        return not any(
            says(rest)
            for says in (self.sets_terms, self.forbids, self.has_clause, self.has_order)
        )  # fmt: skip
