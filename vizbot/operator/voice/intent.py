"""Finds the intent behind what was heard: goals that sound like something that can be found.

Words that are near nothing that is known stay as they are, since CLIP may be asked for anything.
Words that are near something, but not near enough, leave a doubt for a person to settle.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from vizbot.core.home_vocabulary import ROOMS, SYNONYMS
from vizbot.operator.language.command import (
    Command,
    Decline,
    No,
    Reason,
    Stop,
    Yes,
    drives,
    goals_of,
    step_count,
    with_goals,
)
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.language.lexicon import singulars
from vizbot.operator.voice.sentence_bank import NEAR, plain_words, similarity

SURE = 0.76
"""Likeness from which a phrase is taken for what was meant. Chosen on the even half of the phrases
of `tests/helpers/spoken.py`, like all values below."""
MARGIN = 0.04
"""A runner-up this close leaves a doubt."""
SLACK = 0.5
"""How much worse than the best free hypothesis another may be, in the mean of its tokens."""
LOSS = 3.2
"""How much worse than the best free hypothesis a sentence about known things may fit the sound."""
LOSS_OF_UNKNOWN = 1.75
"""The same where that hypothesis asks for something that is near nothing known."""
LOSS_OF_STOP = 1.5
"""The same where another free hypothesis is a stop."""
CERTAIN = -1.5
"""Mean logarithm of a hypothesis below which nothing was heard well."""
NEARLY = 0.5
"""How much worse than the best free hypothesis a sentence about known things may fit and still be
heard well where no good free hypothesis says the same: of 25 sentences for building that fitted
worse and would have driven 15 were right."""
PLAIN = -0.5
"""Mean logarithm of the best free hypothesis from which a plain command about something is believed
at once: of 14 such among 80 of the sentences for building all were right."""
OTHER_WORDS = {
    word: name for table in (SYNONYMS, ROOMS) for name, words in table.items() for word in words
}
"""What other words for a thing or room mean: they are known, however they sound."""


_MARKS = re.compile(r"[^\w' -]")


@dataclass(frozen=True, slots=True)
class ResolvedGoal:
    """A goal as it is meant.

    Attributes:
        heard: The words as they were heard.
        goal: What to look for: a phrase of the vocabulary, or `heard` where it is near none or
            there is a doubt.
        candidate: What may be meant instead and is asked back; None without a doubt.
    """

    heard: str
    goal: str
    candidate: str | None = None


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A sentence that may have been said.

    Attributes:
        score: Mean logarithm of its tokens' probabilities.
    """

    text: str
    score: float


@dataclass(frozen=True, slots=True)
class Utterance:
    """What somebody said.

    Attributes:
        text: Its words; empty if nobody spoke.
        command: The command, with its goals as they are meant; None if it is none.
        resolved: The goals, each with what was heard and what is meant.
        at_once: Whether the running task has to give way.
        sure: Whether it was heard well; what drives and was not is asked back.
        language: That it was said in.
    """

    text: str
    command: Command | None
    resolved: tuple[ResolvedGoal, ...] = ()
    at_once: bool = False
    sure: bool = True
    language: Language = field(default=ENGLISH, repr=False)

    @property
    def question(self) -> str | None:
        """What to ask back before anything is done; None without a doubt."""
        candidates = (meant.candidate for meant in self.resolved)
        if (candidate := next(filter(None, candidates), None)) is not None:
            return self.language.say("did_you_mean", goal=candidate)
        if self.command is None or self.sure or not self.drives:
            return None
        return self.language.say("did_you_say", text=self.language.grammar.text(self.command))

    @property
    def asks(self) -> bool:
        """Whether it is a command, and none that is refused."""
        return self.command is not None and not isinstance(self.command, Decline)

    @property
    def drives(self) -> bool:
        """Whether the robot drives for it."""
        return self.command is not None and drives(self.command)

    @property
    def obeys(self) -> bool:
        """Whether it asks for anything but a stop."""
        return self.command is not None and not isinstance(self.command, Stop)


def confirmed(utterance: Utterance) -> Utterance:
    """The same utterance once a person has said yes to its question: candidates are meant."""
    resolved = tuple(
        replace(meant, goal=meant.candidate or meant.goal, candidate=None)
        for meant in utterance.resolved
    )
    command = utterance.command
    if command is not None and resolved:
        command = with_goals(command, [meant.goal.casefold() for meant in resolved])
    return replace(utterance, command=command, resolved=resolved, sure=True)


def choose_utterance(
    free: Sequence[Hypothesis],
    known: Sequence[Hypothesis],
    vocabulary: Sequence[str],
    wake: str | None = None,
    found: Sequence[str] = (),
    language: Language = ENGLISH,
) -> Utterance:
    """The utterance that is most likely meant.

    Args:
        free: Hypotheses of any words, best first.
        known: Sentences that ask for known things, best first; their scores compare with those of
            the free hypotheses.
        vocabulary: Phrases that can be found.
        wake: What a command must begin with, except "stop", "yes" and "no"; None: nothing.
        found: Phrases of the vocabulary that the running map finds.
        language: That is spoken.

    Returns:
        A stop if it is the best free hypothesis, or another one where nothing known fits well; what
        forbids something if it is the best free hypothesis, and nothing known fits better, or about
        as well and does not drive; else the
        sentence about known things that fits the sound well enough, unless a free hypothesis asks
        for more and all of that is known; else the first free hypothesis that is a command, if
        possible about known things; else the words of the best hypothesis. It is not sure where
        nothing known fits the sound, where it fits badly and no good free hypothesis says the same,
        where one of these forbids something, or where the best one is a command that asks for less,
        or fits the sound best and names another thing that is known.
    """
    if not free:
        return Utterance("", None)
    top = free[0].score

    def read(hypotheses: Sequence[Hypothesis], loss: float) -> list[Utterance]:
        return [
            _read(each, vocabulary, wake, found, language, top)
            for each in hypotheses
            if each.score >= top - loss
        ]

    heard = read(free, SLACK)
    best = heard[0]
    stop = next((utterance for utterance in heard if isinstance(utterance.command, Stop)), None)
    fits_better = bool(known) and known[0].score > top
    if stop is best:
        return best
    if best.command == Decline(Reason.NOT) and not fits_better:
        harmless = [each for each in read(known[:1], SLACK) if each.asks and not each.drives]
        return next(iter(harmless), best)
    loss = LOSS_OF_UNKNOWN if _is_unknown(best, vocabulary) else LOSS
    loss = loss if stop is None else LOSS_OF_STOP
    fitting = read(known, loss)
    if stop is not None and not fitting:
        return stop
    obeyed = [utterance for utterance in (*fitting, *heard) if utterance.asks]
    certain = [utterance for utterance in obeyed if _is_known(utterance, vocabulary)]
    chosen = next(iter([*certain, *obeyed]), best)
    fuller = next((each for each in heard if each in certain and _is_fuller(each, chosen)), chosen)
    if best in certain and not best.resolved:
        fuller = best
    alone = all(each.command != fuller.command for each in (*heard, *read(known, NEARLY)))
    forbidden = any(each.command == Decline(Reason.NOT) for each in heard)
    nothing_fits = bool(known) and not fitting and fuller is not best
    disputed = not fits_better and _names_another(best.text, fuller, vocabulary)
    cut_short = fuller is not chosen and fuller is not best and best in certain
    if alone or forbidden or nothing_fits or disputed or cut_short:
        fuller = replace(fuller, sure=False)
    return replace(fuller, at_once=best.at_once)  # no sentence about what is known says so


def plain_utterance(
    free: Sequence[Hypothesis],
    vocabulary: Sequence[str],
    wake: str | None = None,
    language: Language = ENGLISH,
) -> Utterance | None:
    """The utterance of the best free hypothesis where it leaves nothing to search for.

    Returns:
        None unless it is a command that names no goal, or was heard well and names its goals in
        words that are known.
    """
    if not free:
        return None
    heard = _read(free[0], vocabulary, wake, (), language, free[0].score)
    if not heard.resolved:  # nobody hears "turn left" by chance
        return heard if heard.asks and not _stop_among(free, language) else None
    if free[0].score < PLAIN:
        return None
    named = all(_certain(meant, vocabulary) and _is_literal(meant) for meant in heard.resolved)
    return heard if heard.asks and named else None


def _stop_among(free: Sequence[Hypothesis], language: Language) -> bool:
    """Whether one of the good free hypotheses is a stop, and the best one is none."""
    good = [each for each in free if each.score >= free[0].score - SLACK]
    stops = [isinstance(language.grammar.heard(each.text), Stop) for each in good]
    return any(stops) and not stops[0]


def _is_literal(meant: ResolvedGoal) -> bool:
    """Whether a goal was found by its words, not by how they sound."""
    spellings = singulars(plain_words(meant.heard))
    return plain_words(meant.goal) in spellings or OTHER_WORDS.get(meant.heard) == meant.goal


def _read(
    hypothesis: Hypothesis,
    vocabulary: Sequence[str],
    wake: str | None,
    found: Sequence[str],
    language: Language,
    top: float,
) -> Utterance:
    words, grammar = hypothesis.text, language.grammar
    command = grammar.heard(words)
    if wake is not None and not isinstance(command, Stop | Yes | No):
        words = after_wake(hypothesis.text, wake) or ""
        command = grammar.heard(words)
        if command in (
            Decline(Reason.CANNOT),
            Decline(Reason.STATEMENT),
            Decline(Reason.TERMS),
        ):  # people talk to each other, too
            command = None
    at_once, sure = grammar.is_urgent(words), top >= CERTAIN or hypothesis.score >= PLAIN
    if command is None:
        return Utterance(hypothesis.text, None, at_once=at_once, sure=sure, language=language)
    meant = resolve_command(command, vocabulary, found)
    return Utterance(hypothesis.text, *meant, at_once, sure, language)


def _names_another(text: str, utterance: Utterance, vocabulary: Sequence[str]) -> bool:
    """Whether a thing that is known stands in a text, and is none that an utterance asks for."""
    words = f" {plain_words(_MARKS.sub(' ', text))} "
    meant = " ".join(goal for each in utterance.resolved for goal in (each.heard, each.goal))
    return any(
        f" {plain_words(thing)} " in words and thing not in meant.casefold() for thing in vocabulary
    )


def _is_fuller(one: Utterance, other: Utterance) -> bool:
    """Whether one asks for more than the other."""
    if one.command is None or other.command is None:
        return one.command is not None
    return step_count(one.command) > step_count(other.command)


def _is_known(utterance: Utterance, vocabulary: Sequence[str]) -> bool:
    """Whether every goal is of the vocabulary, without a doubt."""
    return all(_certain(meant, vocabulary) for meant in utterance.resolved)


def _is_unknown(utterance: Utterance, vocabulary: Sequence[str]) -> bool:
    """Whether a goal is near nothing of the vocabulary."""
    return any(
        meant.candidate is None and meant.goal not in vocabulary for meant in utterance.resolved
    )


def after_wake(text: str, wake: str) -> str | None:
    """What follows the wake phrase, or what sounds like it; None if the text has another start."""
    words = "".join(letter if letter.isalnum() else " " for letter in text).split()
    count = len(wake.split())
    if similarity(" ".join(words[:count]).casefold(), plain_words(wake)) < NEAR:
        return None
    rest = text
    for _ in range(count):
        rest = rest.lstrip(" ,.!?-").partition(" ")[2]
    return rest


def resolve_goal(heard: str, vocabulary: Sequence[str], found: Sequence[str] = ()) -> ResolvedGoal:
    """The goal that is meant by what was heard.

    Args:
        heard: Words of a goal, without an article.
        vocabulary: Phrases that can be asked for; where it is empty, what is heard is meant.
        found: Those of them that the running map finds: what sounds like one of these is meant
            before what sounds like any other.
    """
    by_words = {plain_words(phrase): phrase for phrase in vocabulary}
    spellings = singulars(plain_words(heard))
    for spelling in spellings:
        if spelling in by_words:
            return ResolvedGoal(heard, by_words[spelling])
    for spelling in spellings:
        if OTHER_WORDS.get(spelling) in vocabulary:
            return ResolvedGoal(heard, OTHER_WORDS[spelling])
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


def _certain(meant: ResolvedGoal, vocabulary: Sequence[str]) -> bool:
    """Whether it is a phrase of the vocabulary, without a doubt."""
    return meant.candidate is None and meant.goal in vocabulary


def resolve_command(
    command: Command, vocabulary: Sequence[str], found: Sequence[str] = ()
) -> tuple[Command, tuple[ResolvedGoal, ...]]:
    """The command with its goals resolved, and these goals."""
    resolved = tuple(resolve_goal(goal, vocabulary, found) for goal in goals_of(command))
    return with_goals(command, [meant.goal.casefold() for meant in resolved]), resolved
