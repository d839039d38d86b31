"""What was meant by what was heard: goals that sound like something that can be found.

Two phrases are compared by their letters and by their sounds (metaphone: consonants by how they are
spoken, vowels left out). Words that are near nothing stay as they are, since CLIP may be asked for
anything; near, but not near enough, leaves a doubt that a person can settle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from jellyfish import jaro_winkler_similarity, levenshtein_distance, metaphone

from vizbot.operator.grammar import All, Command, GoTo, WhereIs

SURE = 0.80
"""Likeness from which a phrase is taken for what was meant; chosen on the even half of the phrases
of `tests/spoken.py`, like the two below."""
NEAR = 0.66
"""Likeness from which it is worth asking back."""
MARGIN = 0.04
"""A runner-up this close leaves a doubt."""
_SOUND = 0.6
"""How much sounds count beside letters."""
_PLURALS = (("shelves", "shelf"), ("ies", "y"), ("ches", "ch"), ("xes", "x"), ("s", ""))


@dataclass(frozen=True, slots=True)
class Meaning:
    """A goal as it is meant.

    Attributes:
        heard: The words as they were heard.
        goal: What to look for: a phrase of the vocabulary, or `heard` where it is near none or
            there is a doubt.
        candidate: What may be meant instead and should be asked back; None: there is no doubt.
    """

    heard: str
    goal: str
    candidate: str | None = None

    @property
    def question(self) -> str | None:
        """What to ask back; None if there is no doubt."""
        return None if self.candidate is None else f'did you mean "{self.candidate}"?'


def resolve(heard: str, vocabulary: Sequence[str]) -> Meaning:
    """What was meant by a heard goal.

    Args:
        heard: Words of a goal, without an article.
        vocabulary: Phrases that can be found; where it is empty, what is heard is meant.
    """
    by_words = {_plain(phrase): phrase for phrase in vocabulary}
    spellings = _spellings(_plain(heard))
    for spelling in spellings:
        if spelling in by_words:
            return Meaning(heard, by_words[spelling])
    likeness = {
        phrase: max(similarity(spelling, words) for spelling in spellings)
        for words, phrase in by_words.items()
    }
    ranked = sorted(likeness, key=lambda phrase: -likeness[phrase])
    if not ranked or likeness[ranked[0]] < NEAR:
        return Meaning(heard, heard)
    best = likeness[ranked[0]]
    runner_up = likeness[ranked[1]] if len(ranked) > 1 else 0.0
    if best >= SURE and best - runner_up >= MARGIN:
        return Meaning(heard, ranked[0])
    return Meaning(heard, heard, ranked[0])


def resolve_command(
    command: Command, vocabulary: Sequence[str]
) -> tuple[Command, tuple[Meaning, ...]]:
    """The command with its goals resolved, and how each goal was taken; none for "stop" and such."""
    if isinstance(command, GoTo):
        meanings = tuple(resolve(goal, vocabulary) for goal in command.goals)
        return replace(command, goals=tuple(meaning.goal for meaning in meanings)), meanings
    if isinstance(command, WhereIs | All):
        meaning = resolve(command.goal, vocabulary)
        return replace(command, goal=meaning.goal), (meaning,)
    return command, ()


def similarity(a: str, b: str) -> float:
    """How alike two phrases are by letters and sounds, 0 to 1."""
    letters = (jaro_winkler_similarity(a, b) + _nearness(a, b)) / 2
    return _SOUND * _nearness(_sounds(a), _sounds(b)) + (1.0 - _SOUND) * letters


def _nearness(a: str, b: str) -> float:
    return 1.0 - levenshtein_distance(a, b) / max(len(a), len(b), 1)


def _sounds(words: str) -> str:
    """Without the gaps, since "book shelf" sounds like "bookshelf"."""
    return metaphone(words.replace("'", "")).replace(" ", "")


def _plain(words: str) -> str:
    return " ".join(words.casefold().replace("-", " ").split())


def _spellings(words: str) -> list[str]:
    """The words and, where they may be a plural, one of them."""
    first, of, rest = words.partition(" of ")
    singular = [
        first.removesuffix(end) + ends + of + rest for end, ends in _PLURALS if first.endswith(end)
    ]
    return [words, *singular]
