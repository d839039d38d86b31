"""Reads one step of what people say: from its words to a command."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import pi, radians
from typing import Any

from vizbot.objectnav.tasks import FARTHEST, ShortMove
from vizbot.operator.language.command import Ask, Command, Decline, GoTo, Move, Reason, goals_of
from vizbot.operator.language.goal_reader import GoalReader
from vizbot.operator.language.sentence_kinds import ABOUT, ALONE, FORBIDDABLE, KINDS, LOOSE
from vizbot.operator.language.sentence_rules import RuleMaker, SentenceRule, readings, slot
from vizbot.operator.language.step_splitter import SentenceStep, either
from vizbot.operator.language.wording import Wording

_LONGEST_UNKNOWN = 3
"""More words without any name are no thing that somebody looks for."""
_KEPT = 1024
"""Steps whose commands are kept."""
_LEAST_ANGLE = 5.0
"""A smaller number in words is none of an angle [deg]."""
_TURN, _WAY = pi / 2, 0.5
"""A turn and a way without a number [rad, m]."""


class StepReader:
    """Reads the steps of one language.

    Attributes:
        rules: Its patterns, in the order in which they are tried.
    """

    def __init__(
        self, language: Mapping[str, Any], maker: RuleMaker, wording: Wording, goals: GoalReader
    ) -> None:
        cannot = language["cannot"]
        able = f"({cannot['verbs']}) [{{rest}}]"
        self._maker, self._wording, self._goals = maker, wording, goals
        self._commands = lru_cache(_KEPT)(
            self._command
        )  # a sentence's steps are read over and over
        self.rules = maker.rules({kind: language["commands"][kind] for kind in KINDS})
        self._loose = maker.rules(language["loose"])
        self._cannot_early = maker.rules({"cannot": cannot["early"]})
        self._cannot = maker.rules({"cannot": [able, *cannot["ways"]]})
        self._subject = re.compile(rf"\b(?:{either(language['remarks']['subjects'])}) \w")

    def command(
        self, step: SentenceStep, literals: Sequence[str] = (), *, bare: bool = False
    ) -> Command | None:
        """The command of one step; None if it is none. With `bare`, a goal may stand alone."""
        return self._commands(step, tuple(literals), bare)

    def forget(self) -> None:
        """Forget the steps whose commands are kept, as where reading is timed."""
        self._commands.cache_clear()
        self._goals.forget()

    def _command(self, step: SentenceStep, literals: tuple[str, ...], bare: bool) -> Command | None:
        forbids = self._wording.forbids(step.whole)
        if next(readings(step.ways, self._cannot_early), None) is not None:
            return Decline(Reason.CANNOT)
        tells = unsure = strange = None
        empty = orders = False
        for rule, found in readings(step.ways, self.rules):
            goal = slot(found, "goal")
            known = self._goals.knows(self._goals.goal(goal, literals))
            if goal and not (known or forbids) and (name := self._goals.before_tail(goal)):
                return self._about(rule.kind, name)
            if rule.kind == "go" and (reached := self._goals.reached(goal)):
                return self._about(rule.kind, reached)
            if self._goals.tells(goal):
                terms = rule.kind == "go" and self._wording.sets_terms(goal)
                tells = Decline(Reason.TERMS if terms else Reason.CANNOT)
                orders = orders or rule.kind == "go"
            elif rule.kind in LOOSE and not known:
                unsure = self.read(rule, found, literals) if unsure is None else unsure
            elif not forbids or not (rule.kind in FORBIDDABLE or self._wording.forbids(goal)):
                command = self.read(rule, found, literals)
                if command is not None and (known or not goal or self._goals.is_pronoun(goal)):
                    return command
                empty = empty or command is None  # "go to the"
                strange = command if strange is None else strange
        if strange is not None:
            return self._or_none(strange, literals)
        if unsure is None and forbids:
            return Decline(Reason.NOT)
        answer = self._loose_command(step.ways, literals, unsure)
        if answer is not None and not (orders and isinstance(answer, Ask)):
            return self._or_none(answer, literals)
        if tells == Decline(Reason.TERMS):
            return tells  # "go to the kitchen if the door is open"
        goal = self._goals.goal(step.words, literals)
        if (
            not self._goals.is_name(goal)
            and next(readings(step.ways, self._cannot), None) is not None
        ):
            return Decline(Reason.CANNOT)
        if not bare or empty or tells is not None:
            return tells
        if not forbids and (name := self._goals.before_tail(step.words, bare=True)):
            return GoTo((name,))
        if self._goals.tells(step.words):
            return Decline(Reason.STATEMENT)
        goal = self._goals.goal(self._goals.without_towards(step.words), literals)
        long = len(step.words.split()) > _LONGEST_UNKNOWN and goal not in literals
        told = self._wording.has_order(step.words) or self._subject.search(step.words)
        if long and told and not self._goals.knows(goal):
            return Decline(Reason.STATEMENT)  # "the people here go to the kitchen"
        long = long and not self._goals.first_name(goal)
        return None if not goal or long else self._or_none(GoTo((goal,)), literals)

    def _or_none(self, command: Command, literals: Sequence[str]) -> Command:
        """A command; one that cannot be done where it is about what is no thing at all."""
        for goal in goals_of(command):
            if goal not in literals and not self._goals.knows(goal) and self._goals.is_none(goal):
                return Decline(Reason.CANNOT)
        return command

    def read(
        self, rule: SentenceRule, found: re.Match[str], literals: Sequence[str] = ()
    ) -> Command | None:
        """The command that a rule has read; None where its goal is empty."""
        kind = rule.kind
        if kind in ALONE:
            return ALONE[kind]
        if kind in ABOUT or kind == "go":
            said = slot(found, "goal")
            place = self._goals.without_towards(said) if kind == "go" else said
            goal = self._goals.goal(place, literals)
            return self._about(kind, goal) if goal else None
        if kind == "forward":
            way = self._maker.amount(found)
            way = _WAY if way is None else way
            if way < 0.0:
                return Decline(Reason.BACKWARDS)
            within = 0.0 < way <= FARTHEST
            return Move((ShortMove(forward=way),)) if within else Decline(Reason.TOO_FAR)
        angle = self._maker.amount(found, _LEAST_ANGLE)
        turn = _TURN if angle is None else radians(angle)
        if turn < 0.0:
            return Decline(Reason.NUMBER)
        if not 0.0 < turn <= 2 * pi + 1e-9:
            return Decline(Reason.TOO_FAR)
        return Move((ShortMove(turn=turn if kind == "turn_left" else -turn),))

    def _about(self, kind: str, goal: str) -> Command:
        """The command of a kind that names one thing."""
        return GoTo((goal,)) if kind == "go" else ABOUT[kind](goal)

    def _loose_command(
        self, ways: Sequence[str], literals: Sequence[str], unsure: Command | None
    ) -> Command | None:
        """What is asked in words that are none of the rules'.

        Of several readings the first is taken in whose goal there is a name, and that name.

        `unsure` is what a rule has read about a goal that is not known; None without one.
        """
        for rule, found in readings(ways, self._loose):
            goal = slot(found, "goal")
            if not goal:
                return self.read(rule, found)
            if (unsure is None or rule.kind == "how_many") and (
                name := self._goals.first_name(goal)
            ):
                return self._about(rule.kind, name)
            if unsure is None and rule.kind != "go" and not self._goals.tells(goal):
                unsure = self.read(rule, found, literals)
        return unsure
