"""What was meant by what was heard: goals that sound like something that can be found.

Two phrases are compared by their letters and by their sounds (metaphone: consonants by how they are
spoken, vowels left out). Words that are near nothing stay as they are, since CLIP may be asked for
anything; near, but not near enough, leaves a doubt that a person can settle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from jellyfish import jaro_winkler_similarity, levenshtein_distance, metaphone

from vizbot.operator.language.command import All, Command, GoTo, Stop, WhereIs
from vizbot.operator.language.command_grammar import is_urgent, parse_command

SURE = 0.76
"""Likeness from which a phrase is taken for what was meant; chosen on the even half of the phrases
of `tests/helpers/spoken.py`, like all below."""
NEAR = 0.66
"""Likeness from which it is worth asking back."""
MARGIN = 0.04
"""A runner-up this close leaves a doubt."""
SLACK = 0.5
"""How much worse than the best free guess another may be, in the mean of its tokens."""
LOSS = 3.2
"""How much worse than the best free guess a sentence about what is known may fit the sound."""
LOSS_OF_UNKNOWN = 1.75
"""The same where that guess asks for something that is near nothing known."""
LOSS_OF_STOP = 1.5
"""The same where another free guess is a stop."""
_SOUND = 0.6
"""How much sounds count beside letters."""
_PLURALS = (("shelves", "shelf"), ("ies", "y"), ("ches", "ch"), ("xes", "x"), ("s", ""))


@dataclass(frozen=True, slots=True)
class ResolvedGoal:
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


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """What may have been said.

    Attributes:
        text: Words.
        score: Mean logarithm of its tokens' probabilities.
    """

    text: str
    score: float


@dataclass(frozen=True, slots=True)
class Utterance:
    """What was said.

    Attributes:
        text: Words; empty if nobody spoke.
        command: With its goals as they are meant; None: nothing that is obeyed.
        resolved: How each goal was taken.
        at_once: It must not wait for what is running.
    """

    text: str
    command: Command | None
    resolved: tuple[ResolvedGoal, ...] = ()
    at_once: bool = False

    @property
    def question(self) -> str | None:
        """What to ask back before anything is done; None if there is no doubt."""
        return next((meaning.question for meaning in self.resolved if meaning.question), None)

    @property
    def obeys(self) -> bool:
        """Whether it asks for something else than a stop."""
        return self.command is not None and not isinstance(self.command, Stop)


def confirmed(heard: Utterance) -> Utterance:
    """The same when a person has said yes to its question: candidates are meant."""
    resolved = tuple(
        replace(meaning, goal=meaning.candidate or meaning.goal, candidate=None)
        for meaning in heard.resolved
    )
    command = heard.command
    if isinstance(command, GoTo):
        command = replace(command, goals=tuple(meaning.goal for meaning in resolved))
    elif isinstance(command, WhereIs | All):
        command = replace(command, goal=resolved[0].goal)
    return replace(heard, command=command, resolved=resolved)


def choose_utterance(
    free: Sequence[Hypothesis],
    known: Sequence[Hypothesis],
    vocabulary: Sequence[str],
    wake: str | None = None,
    found: Sequence[str] = (),
) -> Utterance:
    """The command among guesses.

    Args:
        free: Guesses made of any words, best first.
        known: Sentences that ask for what is known, best first; their scores compare with those of
            the free guesses.
        vocabulary: Phrases that can be found.
        wake: What a command must begin with, except "stop"; None: nothing.
        found: Phrases of the vocabulary that the running map finds.

    Returns:
        A stop if it is the best free guess, or another one where nothing known fits well; else the
        sentence about what is known that fits the sound well enough; else the first free guess
        that is a command, if possible about what is known; else the words of the best guess.
    """
    if not free:
        return Utterance("", None)
    top = free[0].score
    read = [_read(g, vocabulary, wake, found) for g in free if g.score >= top - SLACK]
    best = read[0]
    stop = next((heard for heard in read if isinstance(heard.command, Stop)), None)
    if stop is best:
        return best
    loss = LOSS_OF_UNKNOWN if _is_unknown(best, vocabulary) else LOSS
    loss = loss if stop is None else LOSS_OF_STOP
    fitting = [_read(g, vocabulary, wake, found) for g in known if g.score >= top - loss]
    if stop is not None and not fitting:
        return stop
    obeyed = [heard for heard in (*fitting, *read) if heard.command is not None]
    certain = [heard for heard in obeyed if _is_known(heard, vocabulary)]
    chosen = next(iter([*certain, *obeyed]), best)
    return replace(chosen, at_once=best.at_once)  # no sentence about what is known says so


def _read(
    hypothesis: Hypothesis, vocabulary: Sequence[str], wake: str | None, found: Sequence[str]
) -> Utterance:
    words = hypothesis.text
    command = parse_command(words)
    if wake is not None and not isinstance(command, Stop):
        words = after_wake(hypothesis.text, wake) or ""
        command = parse_command(words)
    if command is None:
        return Utterance(hypothesis.text, None, at_once=is_urgent(words))
    return Utterance(
        hypothesis.text, *resolve_command(command, vocabulary, found), is_urgent(words)
    )


def _is_known(heard: Utterance, vocabulary: Sequence[str]) -> bool:
    """Whether every goal is of the vocabulary, without a doubt."""
    return all(_certain(meaning, vocabulary) for meaning in heard.resolved)


def _is_unknown(heard: Utterance, vocabulary: Sequence[str]) -> bool:
    """Whether a goal is near nothing of the vocabulary."""
    return any(
        meaning.candidate is None and meaning.goal not in vocabulary for meaning in heard.resolved
    )


def after_wake(text: str, wake: str) -> str | None:
    """What follows the wake phrase, or what sounds like it; None if the text has another start."""
    words = "".join(letter if letter.isalnum() else " " for letter in text).split()
    count = len(wake.split())
    if similarity(" ".join(words[:count]).casefold(), _plain(wake)) < NEAR:
        return None
    rest = text
    for _ in range(count):
        rest = rest.lstrip(" ,.!?-").partition(" ")[2]
    return rest


def resolve_goal(heard: str, vocabulary: Sequence[str], found: Sequence[str] = ()) -> ResolvedGoal:
    """What was meant by a heard goal.

    Args:
        heard: Words of a goal, without an article.
        vocabulary: Phrases that can be asked for; where it is empty, what is heard is meant.
        found: Those of them that the running map finds: what sounds like one of these is meant
            before what sounds like any other.
    """
    by_words = {_plain(phrase): phrase for phrase in vocabulary}
    spellings = _spellings(_plain(heard))
    for spelling in spellings:
        if spelling in by_words:
            return ResolvedGoal(heard, by_words[spelling])
    likeness = {
        phrase: max(similarity(spelling, words) for spelling in spellings)
        for words, phrase in by_words.items()
    }
    here = _nearest(heard, {phrase: likeness[phrase] for phrase in found if phrase in likeness})
    return here if _certain(here, vocabulary) else _nearest(heard, likeness)


def _nearest(heard: str, likeness: Mapping[str, float]) -> ResolvedGoal:
    """The phrase that is most alike, where one is alike enough."""
    ranked = sorted(likeness, key=lambda phrase: -likeness[phrase])
    if not ranked or likeness[ranked[0]] < NEAR:
        return ResolvedGoal(heard, heard)
    best = likeness[ranked[0]]
    runner_up = likeness[ranked[1]] if len(ranked) > 1 else 0.0
    if best >= SURE and best - runner_up >= MARGIN:
        return ResolvedGoal(heard, ranked[0])
    return ResolvedGoal(heard, heard, ranked[0])


def _certain(meaning: ResolvedGoal, vocabulary: Sequence[str]) -> bool:
    """Whether it is of the vocabulary, without a doubt."""
    return meaning.candidate is None and meaning.goal in vocabulary


def resolve_command(
    command: Command, vocabulary: Sequence[str], found: Sequence[str] = ()
) -> tuple[Command, tuple[ResolvedGoal, ...]]:
    """The command with its goals resolved, and how each of them was taken."""
    if isinstance(command, GoTo):
        resolved = tuple(resolve_goal(goal, vocabulary, found) for goal in command.goals)
        return replace(command, goals=tuple(meaning.goal for meaning in resolved)), resolved
    if isinstance(command, WhereIs | All):
        meaning = resolve_goal(command.goal, vocabulary, found)
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
