"""Sentences that ask for something known, built piece by piece for a beam search.

They are written as Whisper writes: a capital first, a mark at the end. What they are made of is
data of a language: one or two sentences for each way to ask that its grammar reads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto
from itertools import product
from typing import Any

_MOST_GOALS = 3


class Stage(Enum):
    """What comes next in a sentence."""

    OPENING = auto()
    VERB = auto()
    ARTICLE = auto()
    GOAL = auto()
    GOALS = auto()
    REST = auto()
    NEXT_GOAL = auto()
    LAST = auto()
    DONE = auto()


@dataclass(frozen=True, slots=True)
class Sentence:
    """The beginning of a sentence.

    Attributes:
        text: Its words so far.
        stage: What comes next.
        score: How well it fits the sound, less how likely it is in any case [log].
        piece: What was added last; a goal as it stands in the vocabulary.
        ending: What its mark will be.
        joins: Whether something else may be asked for in it, after its goal.
        goals: Its goals so far, none of which is asked for twice.
        handicap: How much of the score is taken away from its fit.
    """

    text: str = ""
    stage: Stage = Stage.OPENING
    score: float = 0.0
    piece: str = ""
    ending: str = "."
    joins: bool = False
    goals: tuple[str, ...] = ()
    handicap: float = 0.0

    @property
    def goes_on(self) -> bool:
        """Whether it might have gone on after its last goal, and does not."""
        return self.joins and self.piece == self.ending


class Phrasing:
    """How the sentences of a language begin, go on and end.

    Attributes:
        joins: What joins another goal, each with its article.
        ends: What may be asked for at the end, each with its mark.
        apart: Words between two goals by which they are no mission in this order.
    """

    def __init__(self, spoken: Mapping[str, Any]) -> None:
        self._openings, self._articles = spoken["openings"], spoken["articles"]
        self.joins, self.ends = spoken["joins"], spoken["ends"]
        self.apart = frozenset(spoken["apart"])
        self._go = spoken["go"]
        self._all, self._plurals = spoken["all"], spoken["plurals"]
        self._before, self._before_many = spoken["before"], spoken["before_many"]
        self._verbs = [
            *((verb, Stage.ARTICLE, ".", True) for verb in self._go),
            *((verb, Stage.ARTICLE, ending, False) for verb, ending in spoken["one"]),
            *((verb, Stage.GOALS, ending, False) for verb, ending in spoken["many"]),
            *((words, Stage.DONE, "", False) for words in spoken["whole"]),
        ]

    def continued(self, sentence: Sentence, goals: Sequence[str]) -> list[Sentence]:
        """All sentences that a sentence may become with one piece more."""
        match sentence.stage:
            case Stage.OPENING:
                return [_with(sentence, words, Stage.VERB) for words in self._openings]
            case Stage.VERB:
                return [
                    replace(_with(sentence, verb, stage), ending=ending, joins=joins)
                    for verb, stage, ending, joins in self._verbs
                ]
            case Stage.ARTICLE:
                one = [_with(sentence, article, Stage.GOAL) for article in self._articles]
                return [*one, *self._of_all(sentence)]
            case Stage.GOAL | Stage.NEXT_GOAL:
                return [
                    replace(_with(sentence, goal, Stage.REST), goals=(*sentence.goals, goal))
                    for goal in goals
                    if goal not in sentence.goals
                ]
            case Stage.GOALS:
                return [_with(sentence, goal, Stage.LAST, self.plural(goal)) for goal in goals]
            case Stage.REST:
                return [*_ended(sentence), *self._joined(sentence)]
        return _ended(sentence)

    def plural(self, goal: str) -> str:
        """The plural of a phrase, for example "chests of drawers"."""
        first, of, rest = goal.partition(" of ")
        for end, ends in self._plurals:
            if first.endswith(end):
                return f"{first.removesuffix(end)}{ends}{of}{rest}"
        return goal

    @property
    def article(self) -> str:
        """What usually stands before a thing."""
        return str(self._articles[0])

    @property
    def leads(self) -> list[str]:
        """What stands before the first thing of a mission."""
        leads = product(self._openings, self._go, self._articles)
        return [" ".join(filter(None, each)) for each in leads]

    def further(self, text: str) -> list[str]:
        """A whole sentence about a goal with each thing that may be asked for at its end."""
        return [f"{text.rstrip('.!?')}{end}" for end in self.ends]

    def before(self, *, many: bool) -> str:
        """What stands before a goal where nothing but the goal matters."""
        return str(self._before_many if many else self._before)

    def _of_all(self, sentence: Sentence) -> list[Sentence]:
        if not sentence.joins:
            return []
        return [replace(_with(sentence, words, Stage.GOALS), joins=False) for words in self._all]

    def _joined(self, sentence: Sentence) -> list[Sentence]:
        """With another goal, or with what to do at the end."""
        if not sentence.joins:
            return []
        joins = self.joins if len(sentence.goals) < _MOST_GOALS else ()
        return [
            *(_glued(sentence, join, Stage.NEXT_GOAL) for join in joins),
            *(_glued(sentence, end, Stage.DONE) for end in self.ends),
        ]


def _with(sentence: Sentence, piece: str, stage: Stage, words: str | None = None) -> Sentence:
    text = f"{sentence.text} {piece if words is None else words}".strip()
    return replace(sentence, text=text[:1].upper() + text[1:], stage=stage, piece=piece)


def _glued(sentence: Sentence, piece: str, stage: Stage) -> Sentence:
    return replace(sentence, text=sentence.text + piece, stage=stage, piece=piece)


def _ended(sentence: Sentence) -> list[Sentence]:
    return [_glued(sentence, sentence.ending, Stage.DONE)]
