"""Sentences that ask for something known, built piece by piece for a beam search.

They are written as Whisper writes: a capital first, a mark at the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto


class Stage(Enum):
    """What comes next in a sentence."""

    OPENING = auto()
    VERB = auto()
    ARTICLE = auto()
    GOAL = auto()
    GOALS = auto()
    REST = auto()
    SECOND_GOAL = auto()
    LAST = auto()
    DONE = auto()


@dataclass(frozen=True, slots=True)
class Sentence:
    """The beginning of a sentence.

    Attributes:
        text: As far as it goes.
        stage: What comes next.
        score: How well it fits the sound, less how likely it is in any case [log].
        piece: What was added last; a goal as it stands in the vocabulary.
        ending: What its mark will be.
        first: Its first goal, which is not asked for twice.
        handicap: How much of the score is taken away from its fit.
    """

    text: str = ""
    stage: Stage = Stage.OPENING
    score: float = 0.0
    piece: str = ""
    ending: str = "."
    first: str = ""
    handicap: float = 0.0


_OPENINGS = (
    "", "please", "can you", "could you", "would you", "could you please", "i want you to",
    "i'd like you to",
)  # fmt: skip
_TO_GO = (
    "go to", "drive to", "head to", "find", "find me", "look for", "search for", "take me to",
    "bring me to", "lead me to", "show me", "show us",
)  # fmt: skip
_TO_ASK = ("where is", "where's", "where are", "have you seen", "can you see")
_TO_ASK_POLITELY = ("tell me where", "show me where", "do you know where")
_WHOLE = (
    "come back", "come back to me", "come back here", "come here", "come home", "go back",
    "go back to the start", "return", "return to the start", "dock", "dock yourself", "go home",
    "charge yourself", "recharge", "go home to charge", "go to your dock",
    "go to your charger", "go to your charging station", "return to your dock", "stop",
)  # fmt: skip
_JOINS = tuple(
    f"{then} {step} the".replace("  ", " ")
    for then in (", then", " and then")
    for step in ("", "to", "go to", "find", "take me to")
)
_PLURALS = (("shelf", "shelves"), ("y", "ies"), ("ch", "ches"), ("sh", "shes"), ("s", "s"))
_VERBS = (
    *((verb, Stage.ARTICLE, ".") for verb in _TO_GO),
    *((verb, Stage.ARTICLE, "?") for verb in _TO_ASK),
    *((verb, Stage.ARTICLE, " is.") for verb in _TO_ASK_POLITELY),
    *((f"{words}.", Stage.DONE, "") for words in _WHOLE),
)
"""From `command_grammar`: one or two sentences for each way to ask that it obeys."""


def continued(sentence: Sentence, goals: Sequence[str]) -> list[Sentence]:
    """What it may become with one piece more.

    Args:
        sentence: One that is not done.
        goals: That may be asked for.
    """
    match sentence.stage:
        case Stage.OPENING:
            return [_with(sentence, words, Stage.VERB) for words in _OPENINGS]
        case Stage.VERB:
            return [
                replace(_with(sentence, verb, stage), ending=ending)
                for verb, stage, ending in _VERBS
            ]
        case Stage.ARTICLE:
            one = [_with(sentence, article, Stage.GOAL) for article in ("the", "my", "a")]
            return [*one, *_of_all(sentence)]
        case Stage.GOAL:
            return [replace(_with(sentence, goal, Stage.REST), first=goal) for goal in goals]
        case Stage.GOALS:
            return [_with(sentence, goal, Stage.LAST, plural_phrase(goal)) for goal in goals]
        case Stage.REST:
            joins = _JOINS if sentence.ending == "." else ()
            return [*_ended(sentence), *(_glued(sentence, j, Stage.SECOND_GOAL) for j in joins)]
        case Stage.SECOND_GOAL:
            others = [goal for goal in goals if goal != sentence.first]
            return [_with(sentence, goal, Stage.LAST) for goal in others]
    return _ended(sentence)


def plural_phrase(goal: str) -> str:
    """Several of a kind, for example "chests of drawers"."""
    first, of, rest = goal.partition(" of ")
    for end, ends in _PLURALS:
        if first.endswith(end):
            return first.removesuffix(end) + ends + of + rest
    return first + "s" + of + rest


def _with(sentence: Sentence, piece: str, stage: Stage, words: str | None = None) -> Sentence:
    text = f"{sentence.text} {piece if words is None else words}".strip()
    return replace(sentence, text=text[:1].upper() + text[1:], stage=stage, piece=piece)


def _glued(sentence: Sentence, piece: str, stage: Stage) -> Sentence:
    return replace(sentence, text=sentence.text + piece, stage=stage, piece=piece)


def _of_all(sentence: Sentence) -> list[Sentence]:
    return [_with(sentence, "all the", Stage.GOALS)] if sentence.ending == "." else []


def _ended(sentence: Sentence) -> list[Sentence]:
    return [_glued(sentence, sentence.ending, Stage.DONE)]
