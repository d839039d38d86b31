"""The sentences that vizbot understands: from a line of text, typed or heard, to a command.

What people say is data of a language (`languages/en.toml`); here is how it is read. The grammar
looks for "stop" first. Otherwise it drops politeness and fillers, cuts the line into steps at
"then", commas and some of "and", and expects each step to be one of the language's patterns. Words
that are none are no command, so that a robot does not follow what people say to each other. Where
only the robot is addressed, as in everything that is typed, they are a goal.

A line that is not read like this, or is about something unknown, may say more than it asks for:
then the order is looked for among its clauses (`clause_reader`).

A sentence that forbids something, or that asks for what no robot of this kind can do, is a
`Decline`. Words in double quotes are taken literally, so that anything can be asked for:
`"go to the kitchen"` with its quotes is a thing of that name, as in
`find "the last exit sign", then come back`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from vizbot.core.errors import ConfigError
from vizbot.core.normal_text import normal_text, seen_text
from vizbot.operator.language.clause_reader import ClauseReader
from vizbot.operator.language.command import (
    MISSIONS,
    Ask,
    Cancel,
    Command,
    Decline,
    Explore,
    GoOn,
    GoTo,
    Move,
    No,
    Reason,
    Stop,
    WhereIs,
    Yes,
    goals_of,
    join_commands,
    with_goals,
)
from vizbot.operator.language.goal_reader import GoalReader, literal_mark, without_marks
from vizbot.operator.language.numeral import digits_of
from vizbot.operator.language.sentence_kinds import ALONE, SentenceWriter
from vizbot.operator.language.sentence_rules import RuleMaker, readings
from vizbot.operator.language.step_reader import StepReader
from vizbot.operator.language.step_splitter import SentenceStep, StepSplitter, either, plain, tidy
from vizbot.operator.language.wording import Wording

_QUOTE = re.compile(r"[\"\N{LEFT DOUBLE QUOTATION MARK}\N{RIGHT DOUBLE QUOTATION MARK}]")
_LITERAL = re.compile(rf"{_QUOTE.pattern}(.*?){_QUOTE.pattern}")
MOST_WORDS, MOST_LETTERS = 120, 600
"""A longer line is refused before any pattern sees it."""
_KEPT = 64
"""Lines whose commands are kept."""
_STOP_WORDS, _STOP_LETTERS = 3, 60
"""A line that is no longer may be a stop, whatever else waits to be read."""
_REPEATED = re.compile(r"(\W|[^\W\d_])\1{2,}")


class SentenceTooLongError(ConfigError):
    """A line is longer than any sentence that is read."""


@dataclass(frozen=True, slots=True)
class TypedLine:
    """What a typed line says.

    Attributes:
        command: The command in it; None if there is none.
        literals: Its parts in quotes, which are taken literally.
        at_once: Whether it says that the running task must give way: "right now", "instead".
        alone: Whether its goals stand without a command around them.
    """

    command: Command | None
    literals: tuple[str, ...]
    at_once: bool
    alone: bool


class Grammar:
    """Reads the sentences of one language.

    Attributes:
        examples: One sentence for each command: help for people, and a hint for the recogniser.
        rules: All patterns, in the order in which they are tried.
    """

    def __init__(
        self,
        language: Mapping[str, Any],
        is_name: Callable[[str], bool],
        knows: Callable[[str], bool],
    ) -> None:
        """Take over a language.

        `is_name`: words are the name of a thing or room; `knows`: the robot knows every word of a
        goal.

        Raises:
            KeyError: the language lacks something.
            ValueError: a pattern of it is none.
        """
        words = language["words"]
        maker = RuleMaker(language)
        wording = Wording(language)
        self._parse = lru_cache(_KEPT)(self._parsed)  # a line is read in more than one way
        self._goals = GoalReader(language, maker.part, wording, is_name, knows)
        self._reader = StepReader(language, maker, wording, self._goals)
        self._splitter = StepSplitter(language, maker.part)
        self._clauses = ClauseReader(
            language, maker, self._splitter, self._reader, wording, self._goals
        )
        self._writer = SentenceWriter(language["sentences"])
        self.examples: tuple[str, ...] = tuple(language["examples"])
        self.rules = self._reader.rules
        self._alone = [
            rule for rule in self.rules if rule.kind in ALONE and not rule.takes_any_words
        ]
        self._turns = [rule for rule in self.rules if rule.kind in ("turn_left", "turn_right")]
        self._stop = re.compile(
            rf"\b(?:{either(words['stop'])})\b(?! (?:{either(words['stop_names'])})\b)"
        )
        self._now = re.compile(rf"\b(?:{either(words['now'])})\b")

    def heard(self, line: str) -> Command | None:
        """The command in a line that was heard; None if there is none.

        Quotes mean nothing here: no speaker says them. Nobody says a line that is too long, either.
        """
        try:
            require_length(line)
        except SentenceTooLongError:
            return None
        line, unread = digits_of(seen_text(without_marks(line)))
        line = normal_text(line)
        return _readable(self._or_stop(self._parse(line, (), False), line, ()), unread)

    def read(self, line: str) -> TypedLine:
        """What a line says that was typed to the robot.

        A thing that stands alone is a goal, in the very words that were typed. Words in quotes are
        taken literally.

        Raises:
            SentenceTooLongError: the line is longer than `MOST_WORDS` or `MOST_LETTERS`.
        """
        marked, literals, unread, quoted = self._without_literals(line)
        asked, command = self._commands(marked, literals, unread, quoted)
        ordered = self.heard(line) if quoted else self._or_stop(asked, marked, literals)
        return TypedLine(command, literals, self._gives_way(marked), alone=ordered is None)

    def typed(self, line: str) -> Command | None:
        """The command in a typed line, as `read` has it; None if there is none."""
        return self._commands(*self._without_literals(line))[1]

    def _commands(
        self, marked: str, literals: tuple[str, ...], unread: bool, quoted: bool
    ) -> tuple[Command | None, Command | None]:
        """What a typed line asks for: where a goal needs words before it, and where it does not."""
        asked = command = self._parse(marked, literals, False)
        if not self._is_plain(asked, literals):
            bare = self._parse(marked, literals, True)
            command = bare if self._is_plain(bare, literals) or asked is None else asked
            command = self._or_stop(command, marked, literals)
            whole = self._goals.without_article(tidy(plain(marked)).replace(",", ""))
            if command == GoTo((whole,)) and not quoted:
                command = GoTo((marked.strip(" .,;:!?"),))
        return asked, _readable(command, unread)

    def is_stop(self, line: str) -> bool:
        """Whether a line is a stop of a few words; a long line need not be read for that."""
        words = normal_text(line).split()
        if not 0 < len(words) <= _STOP_WORDS:
            return False
        said = _REPEATED.sub(r"\1", " ".join(words))
        return len(said) <= _STOP_LETTERS and isinstance(self.typed(said), Stop)

    def forget(self) -> None:
        """Forget what was read before, as where reading is timed."""
        self._parse.cache_clear()
        self._splitter.forget()
        self._clauses.forget()
        self._reader.forget()

    def literals(self, line: str) -> Sequence[str]:
        """The parts of a typed line that stand in quotes."""
        return self._without_literals(line)[1]

    def text(
        self,
        command: Command,
        at_once: bool = False,
        quoted: Collection[str] = (),
        own: Callable[[str], str] = str,
    ) -> str:
        """A sentence with the same meaning, for example "go to kitchen, then sofa, then dock".

        With `at_once` the running task has to give way. Goals that are `quoted` are taken
        literally: they stand in quotes, like those which `typed` would not find again without.
        `own` is what people call a goal.
        """
        if at_once:
            return self.urgent(self.text(command, quoted=quoted, own=own))
        text = self._writer.text(command, quoted, "{}")
        try:
            found_again = self.typed(text) == command and not self.is_urgent(text)
        except SentenceTooLongError:
            found_again = False
        named = with_goals(command, [*map(own, goals_of(command))])
        return self._writer.text(named, {*map(own, quoted)}, "{}" if found_again else '"{}"')

    def urgent(self, text: str) -> str:
        """The same sentence, for which the running task has to give way."""
        return self._writer.urgent(text)

    def is_urgent(self, line: str) -> bool:
        """Whether a line says that the running task must give way: "right now", "instead"."""
        return self._gives_way(self._without_literals(line)[0])

    def _gives_way(self, marked: str) -> bool:
        steps = self._splitter.steps(self._splitter.polished(marked))
        at_once = self._splitter.is_at_once(marked)
        return at_once or any(self._now.search(step.around) for step in steps)

    def without_article(self, goal: str) -> str:
        """A goal without the articles before it."""
        return self._goals.without_article(goal.casefold())

    def _without_literals(self, line: str) -> tuple[str, tuple[str, ...], bool, bool]:
        """The line with a mark in place of each part in quotes, these parts, and two doubts.

        It is normal text, with its numbers in digits; the doubts are whether one cannot be read,
        and whether there are quotes in it.

        A stop alone is no literal: it must not be missed because somebody puts it in quotes.
        """
        literals: list[str] = []

        def mark(found: re.Match[str]) -> str:
            literal = " ".join(normal_text(found[1]).split())
            if not literal or self._stop.fullmatch(tidy(plain(literal))):
                return f" {literal} "
            literals.append(literal)
            return f" {literal_mark(len(literals) - 1)} "

        require_length(line)
        marked, unread = digits_of(_LITERAL.sub(mark, seen_text(without_marks(line))))
        return normal_text(marked), tuple(literals), unread, bool(_QUOTE.search(line))

    def _parsed(self, line: str, literals: tuple[str, ...], bare: bool) -> Command | None:
        """The command in a line with marks for its literals; `bare`: a goal may stand alone."""
        if self._stop.search(plain(line).replace(",", " , ")):
            return Stop()
        polished = self._splitter.polished(line)
        words = polished.replace(",", "")
        if (read := next(readings([words], self._alone), None)) is not None:
            return ALONE[read[0].kind]  # "yes, that one" and "go and charge" are no lists
        command = self._joined(self._splitter.steps(polished), literals, bare=bare)
        if self._is_plain(command, literals):
            return command
        asking = self._splitter.polished(line, asking=True)
        polite = self._splitter.is_polite(line)
        asked, named = self._clauses.asked(asking, literals, bare=bare, polite=polite)
        if not (asked or bare) and isinstance(command, GoTo):
            return Decline(Reason.STATEMENT)  # "go to the sofa nah just kidding"
        steps = self._splitter.steps(asked) if asked not in ("", polished) else []
        if steps and not bare and self._goals.is_towards(steps[0].words):
            return command  # "I went to the kitchen, then to the sofa"
        beside = self._joined(steps, literals, bare=bare, named=named)
        found = self._is_plain(beside, literals) and not isinstance(beside, Yes | No)
        unknown = not bare and isinstance(beside, GoTo | WhereIs)  # "find the gloob, I need it"
        return beside if found or unknown else command

    def _or_stop(
        self, command: Command | None, line: str, literals: Sequence[str]
    ) -> Command | None:
        """The command of a line; a stop where it is none and begins with one.

        "Watch out, the cat!" is a warning, whatever the rest of it says.
        """
        if self._is_plain(command, literals):
            return command
        first = self._splitter.steps(self._splitter.polished(line))[:1]
        warns = any(self._reader.command(step, literals) == Stop() for step in first)
        return Stop() if warns else command

    def _is_plain(self, command: Command | None, literals: Sequence[str]) -> bool:
        """Whether a command is one that the robot can do as it stands."""
        if isinstance(command, Decline | None):
            return False
        goals = (goal for goal in goals_of(command) if not self._goals.is_pronoun(goal))
        return all(goal in literals or self._goals.knows(goal) for goal in goals)

    def _joined(
        self,
        steps: Sequence[SentenceStep],
        literals: Sequence[str],
        *,
        bare: bool,
        named: str = "",
    ) -> Command | None:
        """The command of some steps.

        Args:
            steps: In order. After the first one a goal may stand alone: "the sofa, then the lamp".
            literals: What each mark stands for.
            bare: Whether it may stand alone in the first step, too.
            named: What "it" is in the first step; empty without any.
        """
        if not any(step.words for step in steps):  # "hey robot, yes": openings alone
            read = [self._reader.command(step, literals, bare=bare) for step in steps]
            told = [command for command in read if command is not None]
            return join_commands([each for each in told if not isinstance(each, Ask)] or told)
        commands: list[Command | None] = []
        moved = False
        for place, step in enumerate(steps):
            denied = commands not in ([], [Stop()]) and self._clauses.denies(step.whole)
            if denied and place == len(steps) - 1:
                return Decline(Reason.NOT)
            moved = moved or isinstance(commands[-1] if commands else None, Move)
            if denied or self._clauses.corrects(step.whole):
                commands = []  # "the kitchen, no, the study"
            if self._clauses.is_marker(step.whole) and place < len(steps) - 1:
                continue  # "scratch that, the study"
            if place < len(steps) - 1 and self._clauses.only_leaves(step):
                continue  # "leave the bed and go to the sofa instead"
            if self._splitter.waits(step) and not isinstance([None, *commands][-1], MISSIONS):
                return Decline(Reason.TERMS)  # "turn around once you are there"
            goes = commands and isinstance(commands[-1], GoTo)
            if goes and self._clauses.only_looks(step):
                continue  # "go to the door and see who is there"
            if moved and not step.words:
                turns = readings([step.whole], self._turns)  # "turn left, then right"
                commands += [self._reader.read(rule, found) for rule, found in turns][:1]
            elif not denied and step.words:  # what only opens a sentence is no step of its own
                command = self._reader.command(step, literals, bare=bare or place > 0)
                commands = self._with_pronoun(commands, command, literals, named)
        if isinstance(commands[0] if commands else None, Yes | No) and any(
            isinstance(command, MISSIONS) for command in commands[1:]
        ):
            commands = commands[1:]  # "that is wrong, go to the sofa"
        if commands[:1] == [No()] or any(isinstance(each, MISSIONS) for each in commands):
            commands = [command for command in commands if command != GoOn()]
        return join_commands(commands)

    def _with_pronoun(
        self,
        commands: list[Command | None],
        command: Command | None,
        literals: Sequence[str],
        told: str,
    ) -> list[Command | None]:
        """The commands and another one, whose "it" is what was named last."""
        named = goals_of(commands[-1])[-1:] if commands else ()
        last = commands[-1] if commands else None
        if isinstance(last, GoTo) and isinstance(command, GoTo):
            refined = self._goals.refined(command.goals[0], last.goals[-1])
            if refined is not None:
                return [*commands[:-1], replace(last, goals=(*last.goals[:-1], refined))]
        if commands and command == commands[-1] and not set(goals_of(command)) & set(literals):
            return commands
        if isinstance(last, WhereIs) and isinstance(command, GoTo) and command.goals[:1] == named:
            return [*commands[:-1], command]  # "where is my bag, find my bag"
        if not any(map(self._goals.is_pronoun, goals_of(command)[:1])):
            return [*commands, command]
        if not commands and told and isinstance(command, GoTo | WhereIs):
            return [with_goals(command, (told, *goals_of(command)[1:]))]
        if not named:
            return [*commands, command]
        if isinstance(command, WhereIs) and isinstance(commands[-1], GoTo | WhereIs):
            return [*commands[:-1], WhereIs(*named)]  # "my bag, where is it?"
        if not isinstance(command, GoTo):
            return [*commands, command]
        if isinstance(commands[-1], GoTo):
            return commands
        kept = commands[:-1] if isinstance(commands[-1], WhereIs) else commands
        return [*kept, replace(command, goals=named)]


def require_length(line: str) -> None:
    """Raise a `SentenceTooLongError` for a line that is too long to be read."""
    words = normal_text(line).split()
    letters = sum(map(len, words)) + len(words) - 1
    if len(words) > MOST_WORDS or letters > MOST_LETTERS:
        raise SentenceTooLongError(
            f"{len(words)} words, {letters} characters are too long for a sentence; say it in"
            f" {MOST_WORDS} words and {MOST_LETTERS} characters, or in several sentences"
        )


def _readable(command: Command | None, unread: bool) -> Command | None:
    """A command, unless it moves by a number that cannot be read: then it is asked back."""
    part: Command | None = command
    while isinstance(part, GoTo | Explore | Cancel):
        part = part.after
    return Decline(Reason.NUMBER) if unread and isinstance(part, Move) else command
