"""Reads the goals that people name: things and rooms among the words that stand beside them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

from vizbot.operator.language.step_splitter import either
from vizbot.operator.language.wording import Wording

_MOST_WORDS = 16
"""Words of a question among which a name is looked for."""
_KEPT = 1024
"""Words whose goals are kept."""
_LONGEST_GOAL = 80
"""Letters of a step among which a goal ends."""
_LONGEST_NAME = 4
"""Words of a name that is looked for among others."""

_MARK = "\N{LATIN LETTER BIDENTAL PERCUSSIVE}"
"""A letter that no language is written with: it stands for what is taken literally."""
_MARKED = re.compile(rf"{_MARK}(\d+){_MARK}")


def without_marks(line: str) -> str:
    """A line without the letter that marks are made of."""
    return line.replace(_MARK, " ")


def literal_mark(number: int) -> str:
    """What stands in a step for a literal."""
    return f"{_MARK}{number}{_MARK}"


class GoalReader:
    """Reads the goals of one language.

    Attributes:
        is_name: Whether words are the name of a thing or room, and nothing besides: "plant" and
            "water cooler" are, which begin like something that no robot can do.
        knows: Whether the robot knows every word of a goal.
        before_tail: The known goal that words begin with, the rest of which only tells something,
            "kitchen so that I can film you"; empty without one, as for "kitchen when I say so".
            With `bare`, no order stands before the words.
    """

    def __init__(
        self,
        language: Mapping[str, Any],
        part: Callable[[str], str],
        wording: Wording,
        is_name: Callable[[str], bool],
        knows: Callable[[str], bool],
    ) -> None:
        words = language["words"]
        self.before_tail = lru_cache(_KEPT)(self._before_tail)  # many rules read the same goal
        self.is_name, self.knows = is_name, knows
        self._wording = wording
        self._pronouns = {word.casefold() for word in words["pronouns"]}
        self._ones = {word.casefold() for word in words["ones"]}
        self._persons = re.compile(rf"(?:{either(words['persons'])})\b")
        self._motions = re.compile(rf"\b(?:{either(words['motions'])})\b")
        self._towards = re.compile(rf"^(?:{either(words['towards'])}) ")
        self._reaching = re.compile(rf"(?:{either(words['reaching'])}) ")
        # Python 3.11.2, Debian's, makes "rmchair" of "the armchair" by "++" in place of "(?>".
        self._articles = re.compile(rf"^(?>(?:(?:{either(words['articles'])})(?: |$))+)")
        self._tail = re.compile(rf"{part('tails')}(?= |$)")
        self._bare_tail = re.compile(rf"{part('bare_tails')}(?= |$)")
        endless = (*words["directions"], *words["subordinate"], *language["remarks"]["unfinished"])
        self._endless = {word.casefold() for word in endless}

    def goal(self, words: str, literals: Sequence[str] = ()) -> str:
        """A goal without articles, with each literal in the place of its mark."""
        goal = words if self.is_pronoun(words) else self.without_article(words)
        return _MARKED.sub(lambda found: literals[int(found[1])], goal)

    def is_pronoun(self, goal: str) -> bool:
        """Whether a goal stands for what was named before."""
        return goal in self._pronouns

    def is_none(self, goal: str) -> bool:
        """Whether a goal that is not known names no thing at all: "me", "bit to the left"."""
        none = self._persons.match(goal) or self._motions.search(goal)
        return none is not None and not self.mentions(goal)

    def is_towards(self, words: str) -> bool:
        """Whether words begin with what stands before a place, like "to"."""
        return self._towards.match(words) is not None

    def without_towards(self, words: str) -> str:
        """Words without what stands before a place."""
        return self._towards.sub("", words)

    def without_article(self, words: str) -> str:
        """Words without the articles before them."""
        return self._articles.sub("", words)

    def refined(self, goal: str, named: str) -> str | None:
        """A goal that says more of the one named before it, as one; None where it does not.

        After "the chair" "the red one" is a "red chair".
        """
        more, _, last = goal.rpartition(" ")
        return f"{more} {named}" if more and last in self._ones else None

    def tells(self, words: str) -> bool:
        """Whether words that stand for a goal have a clause of their own."""
        return self._wording.has_clause(words) and not self.is_name(self.without_article(words))

    def mentions(self, words: str) -> bool:
        """Whether there is a name of a thing or room among some words."""
        said, ends = words.split(), range(1, _LONGEST_NAME + 1)
        phrases = {" ".join(said[at : at + end]) for at in range(len(said)) for end in ends}
        return any(map(self.is_name, phrases))

    def reached(self, words: str) -> str:
        """The known goal up to which words ask to drive, "until the balcony"; empty without one."""
        if (found := self._reaching.match(words)) is None:
            return ""
        goal = self.without_article(words[found.end() :])
        return goal if self._is_whole(goal) else ""

    def first_name(self, words: str) -> str:
        """The first name among some words, with what belongs to it; empty without one.

        It begins with the words, or after an article, or else anywhere.
        """
        said = words.split()[:_MOST_WORDS]
        starts = range(1, len(said))
        for start in (0, *sorted(starts, key=lambda at: not self._articles.match(said[at]))):
            for end in range(len(said), start, -1):
                name = self.without_article(" ".join(said[start:end]))
                if self._is_whole(name):
                    return "" if self.is_towards(name) else name
        return ""

    def forget(self) -> None:
        """Forget the goals that are kept, as where reading is timed."""
        self.before_tail.cache_clear()

    def _before_tail(self, words: str, bare: bool = False) -> str:
        tails = self._bare_tail if bare else self._tail
        for found in tails.finditer(words[:_LONGEST_GOAL]):
            goal, tail = self.without_article(words[: found.start()]), words[found.start() :]
            alone = " " not in found[0].strip()
            if alone and self._wording.begins_order(words[found.end() :].strip()):
                return ""  # "I lost my keys so go to the sofa"
            if self._is_whole(goal):
                terms = self._wording.sets_terms(tail.strip(), aside=not bare)
                return "" if terms or self._wording.forbids(tail) else goal
        said = words[:_LONGEST_GOAL].split()
        for end in range(len(said) - 1, 0, -1):
            goal, rest = self.without_article(" ".join(said[:end])), " ".join(said[end:])
            if self._wording.leaves(rest) and not self.mentions(rest) and self._is_whole(goal):
                return goal
        return ""

    def _is_whole(self, goal: str) -> bool:
        """Whether the robot knows a goal that tells nothing and does not end before it should."""
        said = goal.split()
        ends = said[-1:] and said[-1] not in self._endless
        if not ends and not self.is_name(" ".join(said[-2:])):  # a "trash can" ends
            return False
        known = self.knows(goal) and said[-1] not in self._ones
        return known and not self._wording.has_clause(goal)
