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
from dataclasses import dataclass
from itertools import chain
from math import degrees, pi, radians
from typing import Any

from vizbot.behaviours.short_move import FARTHEST, ShortMove
from vizbot.operator.language.command import (
    All,
    Ask,
    Cancel,
    ComeBack,
    Command,
    Decline,
    Dock,
    Explore,
    GoOn,
    GoTo,
    HowMany,
    KeepOut,
    Move,
    No,
    Reason,
    Stop,
    Topic,
    WhereIs,
    Yes,
    join_commands,
)
from vizbot.operator.language.notation import Pattern, read_pattern

KINDS = (
    "stop", "no", "yes", "go_on", "explore", "dock", "come_back", "help", "battery", "place",
    "sight", "task", "how_many", "where", "keep_out", "cancel", "turn_left", "turn_right",
    "turn_around", "backwards", "forward", "all", "go",
)  # fmt: skip
"""What a language has patterns for, the first that fits is taken."""
_FORBIDDABLE = {"explore", "dock", "come_back", "where", "how_many", "turn_left", "turn_right",
                "turn_around", "backwards", "forward", "all", "go"}  # fmt: skip
"""Of these a sentence that says "not" means nothing that can be done."""
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

    def __init__(self, language: Mapping[str, Any], is_name: Callable[[str], bool]) -> None:
        """Take over a language.

        Args:
            language: As its file has it.
            is_name: Whether words are the name of a thing or room: "plant" and "water cooler" are,
                which begin like something that no robot can do.

        Raises:
            KeyError: it lacks something.
            ValueError: a pattern of it is none.
        """
        words, self._sentences = language["words"], language["sentences"]
        self._is_name = is_name
        self.examples: tuple[str, ...] = tuple(language["examples"])
        self._numbers = {word.casefold(): value for word, value in language["numbers"].items()}
        self._units = {word.casefold(): value for word, value in language["units"].items()}
        self._parts = {**language["parts"], "going": language["going"]["ways"]}
        self.rules = tuple(
            self._rule(kind, text) for kind in KINDS for text in language["commands"][kind]
        )
        self._loose = [
            self._rule(kind, text) for kind, texts in language["loose"].items() for text in texts
        ]
        self._cannot_early, self._cannot = (
            [self._rule("cannot", text) for text in language["cannot"][name]]
            for name in ("early", "ways")
        )
        self._stop = re.compile(
            rf"\b(?:{_either(words['stop'])})\b(?! (?:{_either(words['stop_names'])})\b)"
        )
        self._spellings = language["spellings"]
        self._misspelt = re.compile(rf"(?<![\w'-])(?:{_either([*self._spellings])})(?![\w'-])")
        self._fillers = re.compile(rf"\b(?:{_either(words['fillers'])})\b")
        self._at_once = re.compile(rf"\b(?:{_either(words['at_once'])})\b")
        self._now = re.compile(rf"\b(?:{_either(words['now'])})\b")
        self._not = re.compile(rf"\b(?:{words['not'].casefold()})\b")
        self._articles = re.compile(rf"^(?:(?:{_either(words['articles'])})(?: |$))+")
        self._opening = re.compile(rf"^{self._regex('<openings>')}(?= |$)")
        self._closing = re.compile(rf"{self._regex('<closings>')}$")
        self._joining = re.compile(rf",\s*(?=(?:{_either(words['subordinate'])})\b)")
        then, before, and_ = (_either(words[name]) for name in ("then", "before_then", "and"))
        sooner = _either(words["sooner"])
        self._sooner = re.compile(rf"(?:\s*,)?\s+(?:{before}) (?:{sooner})\b(?:\s*,)?\s*")
        self._step = re.compile(rf"(?:\s*,)?\s+(?:(?:{before}) )?(?:{then})\b(?:\s*,)?\s*")
        starters = _either(words["list_starters"])
        apart = "".join(rf"(?<!\b{re.escape(word)})" for word in words["one_step_after"])
        self._list = re.compile(
            rf"\s*,\s*(?:{and_}) (?=\S)|\s*,\s*(?!\d)|{apart}\s+(?:{and_}) (?=(?:{starters})\b)"
        )
        units = "|".join(map(re.escape, sorted(self._units, key=len, reverse=True)))
        self._glued_unit = re.compile(rf"\b(\d+(?:[.,]\d+)?)({units})\b")

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
        whole = self._articles.sub("", _tidy(_plain(line)).replace(",", ""))
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
        text = self._sentence(command, quoted, "{}")
        found_again = self.typed(text) == command and not self.is_urgent(text)
        return text if found_again else self._sentence(command, quoted, '"{}"')

    def urgent(self, text: str) -> str:
        """The same sentence, for which the running task has to give way."""
        return str(self._sentences["at_once"].format(text=text))

    def is_urgent(self, line: str) -> bool:
        """Whether a line says that the running task must give way: "right now", "instead"."""
        line, _ = self._without_literals(line)
        around = [around for _, _, around in self._steps(line)]
        return bool(self._at_once.search(_plain(line)) or any(map(self._now.search, around)))

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
            if not literal or self._stop.fullmatch(_tidy(_plain(literal))):
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
        if self._stop.search(_plain(line).replace(",", " , ")):
            return Stop()
        words = self._polished(line).replace(",", "")
        alone = (rule for rule in self.rules if rule.kind in _ALONE)
        if (read := next(_readings([words], alone), None)) is not None:
            return _ALONE[read[0].kind]  # "yes, that one" and "go and charge" are no lists
        steps = self._steps(line)
        if len(steps) > 1:  # what only opens a sentence is no step of its own
            steps = [(whole, words, around) for whole, words, around in steps if words]
        return (
            join_commands(
                [
                    self._step_command(whole, words, literals, bare=bare or index > 0)
                    for index, (whole, words, _) in enumerate(steps)
                ]
            )
            if steps
            else None
        )

    def _steps(self, line: str) -> list[tuple[str, str, str]]:
        """The steps of a line: each whole, its words, which may be none, and those around them."""
        polished = self._polished(line)
        in_order = reversed(self._sooner.split(polished))
        halves = (half for sooner in in_order for half in self._step.split(sooner))
        parts = [part for half in halves for part in self._list.split(half)]
        steps = []
        for whole in (_tidy(part).replace(", ", " ").strip(",") for part in parts):
            rest = self._opened(whole)[-1]
            words = self._closed(rest)
            around = whole.removesuffix(rest) + rest.removeprefix(words)
            steps.append((whole, words, around))
        return steps

    def _opened(self, whole: str) -> list[str]:
        """A step as it is, and what is left of it without one opening after the other."""
        left = [whole]
        while left[-1] and (found := self._opening.match(f" {left[-1]}")) is not None:
            left.append(left[-1][max(found.end() - 1, 0) :].strip())
        return left

    def _closed(self, words: str) -> str:
        while (found := self._closing.search(f" {words}")) is not None:
            words = words[: max(found.start() - 1, 0)]
        return words

    def _step_command(
        self, whole: str, words: str, literals: Sequence[str], *, bare: bool
    ) -> Command | None:
        """The command of one step.

        After the first step a goal may stand alone: "the sofa, then the lamp".

        Args:
            whole: The step.
            words: Without what opens and closes it.
            literals: What each mark stands for.
            bare: Whether a goal needs no words before it.
        """
        forbids = self._not.search(whole) is not None
        ways = [self._glued_unit.sub(r"\1 \2", way) for way in self._opened(whole)]
        ways = list(dict.fromkeys(way for one in ways for way in (self._closed(one), one) if way))
        if next(_readings(ways, self._cannot_early), None) is not None:
            return Decline(Reason.CANNOT)
        for rule, found in chain(_readings(ways, self.rules), _readings(ways[:1], self._loose)):
            if not (forbids and rule.kind in _FORBIDDABLE):
                return self._command(rule.kind, found, literals)
        if forbids:
            return Decline(Reason.NOT)
        goal = self._goal(words, literals)
        if not self._is_name(goal) and next(_readings(ways, self._cannot), None) is not None:
            return Decline(Reason.CANNOT)
        return GoTo((goal,)) if bare and goal else None

    def _command(self, kind: str, found: re.Match[str], literals: Sequence[str]) -> Command | None:
        """The command that a pattern has read."""
        if kind in _ALONE:
            return _ALONE[kind]
        if kind in _ABOUT:
            goal = self._goal(_slot(found, "goal"), literals)
            return _ABOUT[kind](goal) if goal else None
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
        turn = _TURN if amount is None else radians(amount)
        if not 0.0 < turn <= 2 * pi + 1e-9:
            return Decline(Reason.TOO_FAR)
        return Move((ShortMove(turn=turn if kind == "turn_left" else -turn),))

    def _number(self, words: str) -> float:
        return self._numbers[words] if words in self._numbers else float(words.replace(",", "."))

    def _goal(self, words: str, literals: Sequence[str]) -> str:
        """A goal without articles, with each part in quotes in the place of its mark."""
        goal = self._articles.sub("", words)
        return _MARKED.sub(lambda found: literals[int(found[1])], goal)

    def _polished(self, line: str) -> str:
        spelt = self._misspelt.sub(lambda found: self._spellings[found[0]], _plain(line))
        polished = self._at_once.sub(" ", self._fillers.sub(" ", spelt))
        return _tidy(self._joining.sub(" ", polished))

    def _sentence(self, command: Command, quoted: Collection[str], goal_format: str) -> str:
        def named(goal: str) -> str:
            return ('"{}"' if goal in quoted else goal_format).format(goal)

        sentences = self._sentences
        match command:
            case GoTo(goals, after):
                steps = [named(goal) for goal in goals]
                steps += [] if after is None else [self._sentence(after, quoted, goal_format)]
                return str(sentences["go_to"].format(goals=sentences["join"].join(steps)))
            case Explore(after) if after is not None:
                steps = [sentences["explore"], self._sentence(after, quoted, goal_format)]
                return str(sentences["join"].join(steps))
            case Move(moves):
                return str(sentences["join"].join(map(self._move_text, moves)))
            case Ask(topic):
                return str(sentences[_TOPICS[topic]])
            case Decline(reason):
                return str(sentences[reason.value])
        for kind, about in _ABOUT.items():
            if isinstance(command, about):
                return str(sentences[kind].format(goal=named(command.goal)))
        kind = next(kind for kind, alone in _ALONE.items() if alone == command)
        return str(sentences[kind])

    def _move_text(self, move: ShortMove) -> str:
        if move.turn:
            kind = "turn_left" if move.turn > 0.0 else "turn_right"
            return str(self._sentences[kind].format(number=f"{degrees(abs(move.turn)):g}"))
        return str(self._sentences["forward"].format(number=f"{move.forward:g}"))


_ABOUT: Mapping[str, type[All | WhereIs | HowMany | Cancel | KeepOut]] = {
    "all": All,
    "where": WhereIs,
    "how_many": HowMany,
    "cancel": Cancel,
    "keep_out": KeepOut,
}
"""Kinds that name one thing."""
_TOPICS: Mapping[Topic, str] = {
    Topic.HELP: "help",
    Topic.BATTERY: "battery",
    Topic.PLACE: "place",
    Topic.SIGHT: "sight",
    Topic.TASK: "task",
}
_ALONE: Mapping[str, Command] = {
    "stop": Stop(),
    "no": No(),
    "yes": Yes(),
    "go_on": GoOn(),
    "explore": Explore(),
    "dock": Dock(),
    "come_back": ComeBack(),
    "turn_around": Move((ShortMove(turn=pi),)),
    "backwards": Decline(Reason.BACKWARDS),
    **{kind: Ask(topic) for topic, kind in _TOPICS.items()},
}
"""Kinds that need no further words."""


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


def _either(words: Sequence[str]) -> str:
    """A regular expression for one of these, the longest first."""
    ordered = sorted((word.casefold() for word in words), key=len, reverse=True)
    return "|".join(map(re.escape, ordered))


def _plain(line: str) -> str:
    """Small letters, digits, apostrophes and hyphens; commas where a sentence has a pause."""
    line = line.casefold().replace("\N{RIGHT SINGLE QUOTATION MARK}", "'")
    line = re.sub(r"[,;:.!?…]+(?=\s|$)", ",", line)
    return re.sub(r"[^\w',.-]+|(?<!\d)\.|\.(?!\d)", " ", line)


def _tidy(words: str) -> str:
    return re.sub(r"\s*,[\s,]*(?!\d)", ", ", " ".join(words.split())).strip(", -")
