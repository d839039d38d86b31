"""The sentences that vizbot understands: from a line of text, typed or heard, to a command.

What people say is data of a language (`languages/en.toml`); here is how it is read. The grammar
looks for "stop" first. Otherwise it drops politeness and fillers, cuts the line into steps at
"then", commas and some of "and", and expects each step to be one of the language's patterns. Words
that are none are no command, so that a robot does not follow what people say to each other. Where
only the robot is addressed, as in everything that is typed, they are a goal.

A sentence that forbids something, or that asks for what no robot of this kind can do, is a
`Decline`. Words in double quotes are taken literally, so that anything can be asked for:
`"go to the kitchen"` with its quotes is a thing of that name, as in
`find "the last exit sign", then come back`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi, radians
from typing import Any

from vizbot.behaviours.short_move import FARTHEST, ShortMove
from vizbot.operator.language.command import (
    Ask,
    Command,
    Decline,
    GoTo,
    Move,
    No,
    Reason,
    Stop,
    WhereIs,
    Yes,
    goals_of,
    join_commands,
)
from vizbot.operator.language.notation import SLOTS, Pattern, read_pattern
from vizbot.operator.language.sentence_kinds import ABOUT, ALONE, FORBIDDABLE, KINDS, TOPICS
from vizbot.operator.language.sentence_writer import SentenceWriter
from vizbot.operator.language.step_splitter import (
    MOST_STEPS,
    Step,
    StepSplitter,
    either,
    plain,
    tidy,
)

_MOST_WORDS = 16
"""Words of a question among which a name is looked for."""
_LEAST_ANGLE = 5
"""A smaller number in words is none of an angle [deg]."""
_TURN, _WAY = pi / 2, 0.5
"""A turn and a way without a number [rad, m]."""

_QUOTE = re.compile(r"[\"\N{LEFT DOUBLE QUOTATION MARK}\N{RIGHT DOUBLE QUOTATION MARK}]")
_LITERAL = re.compile(rf"{_QUOTE.pattern}(.*?){_QUOTE.pattern}")
_MARK = "\N{LATIN LETTER BIDENTAL PERCUSSIVE}"
"""A letter that no language is written with: it stands for what was in quotes."""
_MARKED = re.compile(rf"{_MARK}(\d+){_MARK}")


@dataclass(frozen=True, slots=True)
class SentenceRule:
    """One pattern of a language.

    Attributes:
        kind: What it asks for, one of `KINDS`.
        pattern: How that is said.
        regex: What reads it, after a blank.
    """

    kind: str
    pattern: Pattern
    regex: re.Pattern[str]


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

        Args:
            language: As its file has it.
            is_name: Whether words are the name of a thing or room: "plant" and "water cooler" are,
                which begin like something that no robot can do.
            knows: Whether the robot knows every word of a goal.

        Raises:
            KeyError: it lacks something.
            ValueError: a pattern of it is none.
        """
        words = language["words"]
        self._is_name, self._knows = is_name, knows
        self.examples: tuple[str, ...] = tuple(language["examples"])
        self._numbers = {word.casefold(): value for word, value in language["numbers"].items()}
        self._units = {word.casefold(): value for word, value in language["units"].items()}
        self._parts = {**language["parts"], "going": language["going"]["ways"]}
        self.rules = tuple(
            self._rule(kind, text) for kind in KINDS for text in language["commands"][kind]
        )
        self._turns = [rule for rule in self.rules if rule.kind in ("turn_left", "turn_right")]
        any_words = f" {SLOTS['rest']}"
        self._alone = [
            rule
            for rule in self.rules
            if rule.kind in ALONE and any_words not in rule.regex.pattern
        ]
        self._loose = [
            self._rule(kind, text) for kind, texts in language["loose"].items() for text in texts
        ]
        self._cannot_early, self._cannot = (
            [self._rule("cannot", text) for text in language["cannot"][name]]
            for name in ("early", "ways")
        )
        self._remarks = [self._rule("remark", text) for text in language["remarks"]["ways"]]
        self._no_remark = re.compile(rf"\b(?:{either(language['remarks']['never'])})\b")
        self._denials = [self._rule("no", text) for text in language["remarks"]["denials"]]
        self._correction = re.compile(rf"(?:{either(language['remarks']['corrections'])})\b")
        self._stop = re.compile(
            rf"\b(?:{either(words['stop'])})\b(?! (?:{either(words['stop_names'])})\b)"
        )
        self._now = re.compile(rf"\b(?:{either(words['now'])})\b")
        self._not = re.compile(rf"\b(?:{words['not'].casefold()})\b")
        self._clause = re.compile(rf"\b(?:{words['clause'].casefold()})\b")
        self._pronouns = {(word.casefold(),) for word in words["pronouns"]}
        self._towards = re.compile(rf"^(?:{either(words['towards'])}) ")
        self._articles = re.compile(rf"^(?:(?:{either(words['articles'])})(?: |$))+")
        self._splitter = StepSplitter(language, self._regex)
        self._writer = SentenceWriter(language["sentences"])

    def heard(self, line: str) -> Command | None:
        """The command in a line that was heard; None if there is none.

        Quotes mean nothing here: no speaker says them.
        """
        return self._parse(line.replace(_MARK, " "), ())

    def typed(self, line: str) -> Command | None:
        """The command in a line that was typed to the robot; None if there is none.

        A thing that stands alone is a goal, in the very words that were typed. Words in quotes are
        taken literally.
        """
        marked, literals = self._without_literals(line)
        command = self._parse(marked, literals)
        if command is not None:
            return command
        command = self._parse(marked, literals, bare=True)
        whole = self._articles.sub("", tidy(plain(line)).replace(",", ""))
        if command == GoTo((whole,)) and not _QUOTE.search(line):
            return GoTo((line.strip(" .,;:!?"),))
        return command

    def literals(self, line: str) -> Sequence[str]:
        """The parts of a typed line that stand in quotes."""
        return self._without_literals(line)[1]

    def text(self, command: Command, at_once: bool = False, quoted: Collection[str] = ()) -> str:
        """A sentence with the same meaning, for example "go to kitchen, then sofa, then dock".

        Args:
            command: What it asks for.
            at_once: Whether the running task has to give way.
            quoted: Goals that are to be taken literally. They stand in quotes, like those which
                `typed` would not find again without.
        """
        if at_once:
            return self.urgent(self.text(command, quoted=quoted))
        text = self._writer.text(command, quoted, "{}")
        found_again = self.typed(text) == command and not self.is_urgent(text)
        return text if found_again else self._writer.text(command, quoted, '"{}"')

    def urgent(self, text: str) -> str:
        """The same sentence, for which the running task has to give way."""
        return self._writer.urgent(text)

    def is_urgent(self, line: str) -> bool:
        """Whether a line says that the running task must give way: "right now", "instead"."""
        line, _ = self._without_literals(line)
        steps = self._splitter.steps(self._splitter.polished(line))
        return self._splitter.is_at_once(line) or any(
            self._now.search(step.around) for step in steps
        )

    def without_article(self, goal: str) -> str:
        """A goal without the articles before it."""
        return self._articles.sub("", goal.casefold())

    def _rule(self, kind: str, text: str) -> SentenceRule:
        pattern = read_pattern(text, self._parts)
        return SentenceRule(kind, pattern, re.compile(self._regex(text)))

    def _regex(self, text: str) -> str:
        """The regular expression of a pattern, whose slots have names of their own."""
        pattern = read_pattern(text, self._parts)
        regex = pattern.regex(tuple(self._numbers), tuple(self._units))
        for name in ("goal", "number", "unit"):
            parts = regex.split(f"(?P<{name}>")
            numbered = (f"(?P<{name}_{place}>{part}" for place, part in enumerate(parts[1:]))
            regex = "".join([parts[0], *numbered])
        return regex

    def _without_literals(self, line: str) -> tuple[str, Sequence[str]]:
        """The line with a mark in place of each part in quotes, and these parts.

        A stop alone is no literal: it must not be missed because somebody puts it in quotes.
        """
        literals: list[str] = []

        def mark(found: re.Match[str]) -> str:
            literal = " ".join(found[1].split())
            if not literal or self._stop.fullmatch(tidy(plain(literal))):
                return f" {literal} "
            literals.append(literal)
            return f" {_MARK}{len(literals) - 1}{_MARK} "

        return _LITERAL.sub(mark, line.replace(_MARK, " ")), literals

    def _parse(self, line: str, literals: Sequence[str], *, bare: bool = False) -> Command | None:
        """The command in a line.

        Args:
            line: With marks in place of its literals.
            literals: What each mark stands for.
            bare: A goal needs no words before it.
        """
        if self._stop.search(plain(line).replace(",", " , ")):
            return Stop()
        polished = self._splitter.polished(line)
        words = polished.replace(",", "")
        if (read := next(_readings([words], self._alone), None)) is not None:
            return ALONE[read[0].kind]  # "yes, that one" and "go and charge" are no lists
        command = self._joined(self._splitter.steps(polished), literals, bare=bare)
        if command is None or isinstance(command, Decline):
            beside = self._beside_remarks(polished, literals)
            if beside is not None and not isinstance(beside, Decline | Yes | No):
                return beside
        return command

    def _beside_remarks(self, polished: str, literals: Sequence[str]) -> Command | None:
        """The command in what is left of a line without remarks; None where none is plain."""
        steps = self._splitter.steps(self._without_remarks(polished))
        if steps and self._towards.match(steps[0].words):
            return None  # "I went to the kitchen, then to the sofa"
        return self._joined(steps, literals, bare=False)

    def _without_remarks(self, polished: str) -> str:
        """A line without the clauses that only tell something; empty where none are left out.

        Questions about itself count as such where something else is asked for. Nothing remains of a
        line that takes back what it asks for.
        """
        clauses = polished.split(", ")
        asked, questions = list[str](), list[str]()
        for clause in clauses if len(clauses) <= MOST_STEPS else []:
            read = next(_readings([clause], self.rules), None)
            if read is not None and read[0].kind in TOPICS.values():
                questions.append(clause)
            elif read is not None or next(_readings([clause], self._remarks), None) is None:
                asked.append(clause)
            elif self._takes_back(clause) or (asked and self._not.search(clause)):
                return ""
        remains = asked or questions
        return ", ".join(remains) if len(remains) < len(clauses) else ""

    def _takes_back(self, clause: str) -> bool:
        """Whether a clause tells that what is beside it is not asked for."""
        return self._no_remark.search(clause) is not None or any(_readings([clause], self._denials))

    def _joined(
        self, steps: Sequence[Step], literals: Sequence[str], *, bare: bool
    ) -> Command | None:
        """The command of some steps.

        Args:
            steps: In order. After the first one a goal may stand alone: "the sofa, then the lamp".
            literals: What each mark stands for.
            bare: Whether it may stand alone in the first step, too.
        """
        if not any(step.words for step in steps):  # "hey robot, yes": openings alone
            read = [self._step_command(step, literals, bare=bare) for step in steps]
            told = [command for command in read if command is not None]
            return join_commands([each for each in told if not isinstance(each, Ask)] or told)
        commands: list[Command | None] = []
        for place, step in enumerate(steps):
            denied = commands not in ([], [Stop()]) and any(_readings([step.whole], self._denials))
            if denied and place == len(steps) - 1:
                return Decline(Reason.NOT)
            if denied or self._correction.match(step.whole):
                commands = []  # "the kitchen, no, the study"
            if commands and isinstance(commands[-1], Move) and not step.words:
                turns = _readings([step.whole], self._turns)  # "turn left, then right"
                commands += [self._command(rule.kind, found, ()) for rule, found in turns][:1]
            elif not denied and step.words:  # what only opens a sentence is no step of its own
                command = self._step_command(step, literals, bare=bare or place > 0)
                commands = self._with_pronoun(commands, command)
        return join_commands(commands)

    def _with_pronoun(
        self, commands: list[Command | None], command: Command | None
    ) -> list[Command | None]:
        """The commands and another one, whose "it" is what was named last."""
        named = goals_of(commands[-1])[-1:] if commands else ()
        if not named or goals_of(command)[:1] not in self._pronouns:
            return [*commands, command]
        if isinstance(command, WhereIs) and isinstance(commands[-1], GoTo):
            return [*commands[:-1], WhereIs(*named)]  # "my bag, where is it?"
        if not isinstance(command, GoTo):
            return [*commands, command]
        if isinstance(commands[-1], GoTo):
            return commands
        kept = commands[:-1] if isinstance(commands[-1], WhereIs) else commands
        return [*kept, replace(command, goals=named)]

    def _step_command(self, step: Step, literals: Sequence[str], *, bare: bool) -> Command | None:
        """The command of one step.

        Args:
            step: The step.
            literals: What each mark stands for.
            bare: Whether a goal needs no words before it.
        """
        forbids = self._not.search(step.whole) is not None
        if next(_readings(step.ways, self._cannot_early), None) is not None:
            return Decline(Reason.CANNOT)
        tells = None
        for rule, found in _readings(step.ways, self.rules):
            goal = _slot(found, "goal")
            if self._tells(goal):
                tells = Decline(Reason.CANNOT)  # "go to the kitchen if the door is open"
            elif not forbids or not (rule.kind in FORBIDDABLE or self._not.search(goal)):
                return self._command(rule.kind, found, literals)
        if forbids:
            return Decline(Reason.NOT)
        if (answer := self._loose_command(step.ways, literals)) is not None:
            return answer
        goal = self._goal(step.words, literals)
        if not self._is_name(goal) and next(_readings(step.ways, self._cannot), None) is not None:
            return Decline(Reason.CANNOT)
        if not bare or tells is not None:
            return tells
        if self._tells(step.words):
            return Decline(Reason.STATEMENT)
        goal = self._goal(self._towards.sub("", step.words), literals)
        return GoTo((goal,)) if goal else None

    def _loose_command(self, ways: Sequence[str], literals: Sequence[str]) -> Command | None:
        """What is asked in words that are none of the rules'; it sets nothing off.

        Of several readings the first is taken in whose goal there is a name, and that name.
        """
        unsure = None
        for rule, found in _readings(ways, self._loose):
            goal = _slot(found, "goal")
            if not goal:
                return self._command(rule.kind, found, literals)
            if name := self._name_in(goal):
                return ABOUT[rule.kind](name)
            if unsure is None and not self._tells(goal):
                unsure = self._command(rule.kind, found, literals)
        return unsure

    def _name_in(self, words: str) -> str:
        """The first name among some words, with what belongs to it; empty without one."""
        said = words.split()[:_MOST_WORDS]
        starts = range(1, len(said))
        for start in (0, *sorted(starts, key=lambda at: not self._articles.match(said[at]))):
            for end in range(len(said), start, -1):
                part = " ".join(said[start:end])
                named = self._articles.sub("", part)
                if self._knows(named) and not self._clause.search(named):
                    return "" if self._towards.match(named) else named
        return ""

    def _tells(self, words: str) -> bool:
        """Whether words that stand for a goal have a clause of their own."""
        return self._clause.search(words) is not None and not self._is_name(
            self._articles.sub("", words)
        )

    def _command(self, kind: str, found: re.Match[str], literals: Sequence[str]) -> Command | None:
        """The command that a pattern has read."""
        if kind in ALONE:
            return ALONE[kind]
        if kind in ABOUT:
            goal = self._goal(_slot(found, "goal"), literals)
            return ABOUT[kind](goal) if goal else None
        if kind == "go":
            goal = self._goal(_slot(found, "goal"), literals)
            return GoTo((goal,)) if goal else None
        number, unit = _slot(found, "number"), _slot(found, "unit")
        amount = None if not number else self._number(number) * self._units.get(unit, 1.0)
        if kind == "forward":
            way = _WAY if amount is None else amount
            if not 0.0 < way <= FARTHEST:
                return Decline(Reason.TOO_FAR)
            return Move((ShortMove(forward=way),))
        if number in self._numbers and self._numbers[number] < _LEAST_ANGLE:
            amount = None  # "turn a left"
        turn = _TURN if amount is None else radians(amount)
        if not 0.0 < turn <= 2 * pi + 1e-9:
            return Decline(Reason.TOO_FAR)
        return Move((ShortMove(turn=turn if kind == "turn_left" else -turn),))

    def _number(self, words: str) -> float:
        return self._numbers[words] if words in self._numbers else float(words.replace(",", "."))

    def _goal(self, words: str, literals: Sequence[str]) -> str:
        """A goal without articles, with each part in quotes in the place of its mark."""
        goal = words if (words,) in self._pronouns else self._articles.sub("", words)
        return _MARKED.sub(lambda found: literals[int(found[1])], goal)


def _readings(
    ways: Sequence[str], rules: Iterable[SentenceRule]
) -> Iterator[tuple[SentenceRule, re.Match[str]]]:
    """Each rule that reads a step as it is, then those that read it without its openings."""
    for way in ways:
        for rule in rules:
            if (found := rule.regex.fullmatch(f" {way}")) is not None:
                yield rule, found


def _slot(found: re.Match[str], name: str) -> str:
    """What a slot of a pattern has read; empty where the pattern was read without it."""
    read = (words for key, words in found.groupdict().items() if key.startswith(name) and words)
    return next(read, "")
