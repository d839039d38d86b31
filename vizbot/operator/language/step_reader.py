"""Reads one step of what people say: from its words to a command."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from math import pi, radians
from typing import Any

from vizbot.behaviours.short_move import FARTHEST, ShortMove
from vizbot.operator.language.command import Command, Decline, GoTo, Move, Reason
from vizbot.operator.language.sentence_kinds import ABOUT, ALONE, FORBIDDABLE, KINDS, LOOSE
from vizbot.operator.language.sentence_rules import RuleMaker, SentenceRule, readings, slot
from vizbot.operator.language.step_splitter import SentenceStep, either

_MOST_WORDS = 16
"""Words of a question among which a name is looked for."""
_LONGEST_GOAL = 80
"""Letters of a step among which a goal ends."""
_LONGEST_NAME = 4
"""Words of a name that is looked for among others."""
_LONGEST_UNKNOWN = 3
"""More words without any name are no thing that somebody looks for."""
_LEAST_ANGLE = 5.0
"""A smaller number in words is none of an angle [deg]."""
_TURN, _WAY = pi / 2, 0.5
"""A turn and a way without a number [rad, m]."""

_MARK = "\N{LATIN LETTER BIDENTAL PERCUSSIVE}"
"""A letter that no language is written with: it stands for what is taken literally."""
_MARKED = re.compile(rf"{_MARK}(\d+){_MARK}")


def without_marks(line: str) -> str:
    """A line without the letter that marks are made of."""
    return line.replace(_MARK, " ")


def literal_mark(number: int) -> str:
    """What stands in a step for a literal."""
    return f"{_MARK}{number}{_MARK}"


class StepReader:
    """Reads the steps of one language.

    Attributes:
        rules: Its patterns, in the order in which they are tried.
    """

    def __init__(
        self,
        language: Mapping[str, Any],
        maker: RuleMaker,
        is_name: Callable[[str], bool],
        knows: Callable[[str], bool],
    ) -> None:
        """Take over a language.

        Args:
            language: As its file has it.
            maker: Of its rules.
            is_name: Whether words are the name of a thing or room: "plant" and "water cooler" are,
                which begin like something that no robot can do.
            knows: Whether the robot knows every word of a goal.

        Raises:
            KeyError: it lacks something.
            ValueError: a pattern of it is none.
        """
        words, cannot = language["words"], language["cannot"]
        self._maker, self._is_name, self._knows = maker, is_name, knows
        self.rules = maker.rules({kind: language["commands"][kind] for kind in KINDS})
        self._loose = maker.rules(language["loose"])
        self._cannot_early = maker.rules({"cannot": cannot["early"]})
        able = f"({cannot['verbs']}) [{{rest}}]"
        self._cannot = maker.rules({"cannot": [able, *cannot["ways"]]})
        self._not = re.compile(rf"\b(?:{words['not'].casefold()})\b")
        self._clause = re.compile(rf"\b(?:{words['clause'].casefold()})\b")
        self._pronouns = {word.casefold() for word in words["pronouns"]}
        self._towards = re.compile(rf"^(?:{either(words['towards'])}) ")
        self._tail = re.compile(rf"{maker.part('tails')}(?= |$)")
        idle = f"{either(words['idle'])}|{words['adverb']}"
        self._idle = re.compile(rf"(?: (?:{idle})(?= |$))+")
        self._courteous = re.compile(rf"(?: (?:{idle}|{either(words['courtesy'])})(?= |$))+")
        self._subject = re.compile(rf"\b(?:{either(words['subjects'])}) \w")
        verbs = either(language["imperatives"].values())
        self._order = re.compile(rf"\b(?:{verbs}|{cannot['verbs']})\b")
        self._told_tail = re.compile(rf"{maker.part('told_tails')}(?= |$)")
        self._ones = {word.casefold() for word in words["ones"]}
        endless = (*words["directions"], *words["subordinate"], *language["remarks"]["unfinished"])
        self._endless = {word.casefold() for word in endless}
        self._harmless = re.compile(rf"\b(?:{either(language['remarks']['harmless'])})\b")
        self._terms = re.compile(rf"\b(?:{either(language['remarks']['never'])})\b")
        self._articles = re.compile(rf"^(?:(?:{either(words['articles'])})(?: |$))+")

    def command(
        self, step: SentenceStep, literals: Sequence[str] = (), *, bare: bool = False
    ) -> Command | None:
        """The command of one step; None if it is none.

        Args:
            step: The step.
            literals: What each mark in it stands for.
            bare: Whether a goal needs no words before it.
        """
        forbids = self.forbids(step.whole)
        if next(readings(step.ways, self._cannot_early), None) is not None:
            return Decline(Reason.CANNOT)
        tells = unsure = strange = None
        for rule, found in readings(step.ways, self.rules):
            goal = slot(found, "goal")
            known = self._knows(self._goal(goal, literals))
            if goal and not (known or forbids) and (name := self._before_tail(goal, self._tail)):
                return self._about(rule.kind, name)
            if self._tells(goal):
                tells = Decline(Reason.CANNOT)  # "go to the kitchen if the door is open"
            elif rule.kind in LOOSE and not known:
                unsure = self.read(rule, found, literals) if unsure is None else unsure
            elif not forbids or not (rule.kind in FORBIDDABLE or self.forbids(goal)):
                command = self.read(rule, found, literals)
                if command is not None and (known or not goal or goal in self._pronouns):
                    return command
                strange = command if strange is None else strange
        if strange is not None:
            return strange
        if unsure is None and forbids:
            return Decline(Reason.NOT)
        if (answer := self._loose_command(step.ways, literals, unsure)) is not None:
            return answer
        goal = self._goal(step.words, literals)
        if not self._is_name(goal) and next(readings(step.ways, self._cannot), None) is not None:
            return Decline(Reason.CANNOT)
        if not bare or tells is not None:
            return tells
        if not forbids and (name := self._before_tail(step.words, self._told_tail)):
            return GoTo((name,))
        if self._tells(step.words):
            return Decline(Reason.STATEMENT)
        goal = self._goal(self._towards.sub("", step.words), literals)
        long = len(step.words.split()) > _LONGEST_UNKNOWN and goal not in literals
        told = self._order.search(step.words) or self._subject.search(step.words)
        if long and told and not self._knows(goal):
            return Decline(Reason.STATEMENT)  # "the people here go to the kitchen"
        long = long and not self._name_in(goal)
        return None if not goal or long else GoTo((goal,))

    def read(
        self, rule: SentenceRule, found: re.Match[str], literals: Sequence[str] = ()
    ) -> Command | None:
        """The command that a rule has read; None where its goal is empty."""
        kind = rule.kind
        if kind in ALONE:
            return ALONE[kind]
        if kind in ABOUT or kind == "go":
            goal = self._goal(slot(found, "goal"), literals)
            return self._about(kind, goal) if goal else None
        if kind == "forward":
            way = self._maker.amount(found)
            way = _WAY if way is None else way
            within = 0.0 < way <= FARTHEST
            return Move((ShortMove(forward=way),)) if within else Decline(Reason.TOO_FAR)
        angle = self._maker.amount(found, _LEAST_ANGLE)
        turn = _TURN if angle is None else radians(angle)
        if not 0.0 < turn <= 2 * pi + 1e-9:
            return Decline(Reason.TOO_FAR)
        return Move((ShortMove(turn=turn if kind == "turn_left" else -turn),))

    def forbids(self, words: str) -> bool:
        """Whether words say what must not be done."""
        return self._not.search(self._harmless.sub(" ", words)) is not None

    def sets_terms(self, words: str) -> bool:
        """Whether words report, wish, or set a condition or a time, beside what they tell."""
        return self._terms.search(self._harmless.sub(" ", words)) is not None

    def is_pronoun(self, goal: str) -> bool:
        """Whether a goal stands for what was named before."""
        return goal in self._pronouns

    def refined(self, goal: str, named: str) -> str | None:
        """A goal that says more of the one named before it, as one; None where it does not.

        After "the chair" "the red one" is a "red chair".
        """
        more, _, last = goal.rpartition(" ")
        return f"{more} {named}" if more and last in self._ones else None

    def is_towards(self, words: str) -> bool:
        """Whether words begin with what stands before a place, like "to"."""
        return self._towards.match(words) is not None

    def without_article(self, words: str) -> str:
        """Words without the articles before them."""
        return self._articles.sub("", words)

    def knows(self, goal: str) -> bool:
        """Whether the robot knows every word of a goal."""
        return self._knows(goal)

    def is_idle(self, words: str) -> bool:
        """Whether words are of courtesy alone, or say nothing at all."""
        return self._courteous.fullmatch(f" {words}") is not None and not self.orders(words)

    def orders(self, words: str) -> bool:
        """Whether words begin with the verb of an order, also of one that cannot be obeyed."""
        return self._order.match(words) is not None

    def named(self, words: str) -> str:
        """The first name of a thing or room among some words; empty without one."""
        return self._name_in(words)

    def mentions(self, words: str) -> bool:
        """Whether there is a name of a thing or room among some words."""
        said = words.split()
        ends = range(1, _LONGEST_NAME + 1)
        return any(
            self._is_name(" ".join(said[at : at + end])) for at in range(len(said)) for end in ends
        )

    def _about(self, kind: str, goal: str) -> Command:
        """The command of a kind that names one thing."""
        return GoTo((goal,)) if kind == "go" else ABOUT[kind](goal)

    def _before_tail(self, words: str, tails: re.Pattern[str]) -> str:
        """The known goal that some words begin with, the rest of which only tells something.

        Empty without one, as for "kitchen when I say so": "kitchen so that I can film you".
        """
        for found in tails.finditer(words[:_LONGEST_GOAL]):
            goal, tail = self.without_article(words[: found.start()]), words[found.start() :]
            if self._is_whole(goal):
                return "" if self.sets_terms(tail) or self.forbids(tail) else goal
        return self._before_idle(words)

    def _is_whole(self, goal: str) -> bool:
        """Whether the robot knows a goal that tells nothing and does not end before it should."""
        ends = goal.rpartition(" ")[2] not in self._endless
        return ends and self._knows(goal) and self._clause.search(goal) is None

    def _before_idle(self, words: str) -> str:
        """The known goal that some words begin with, before a word that says nothing more of it."""
        said = words[:_LONGEST_GOAL].split()
        for end in range(len(said) - 1, 0, -1):
            goal, rest = self.without_article(" ".join(said[:end])), " ".join(["", *said[end:]])
            if self._idle.match(rest) is not None and self._is_whole(goal):
                told = self._idle.fullmatch(rest) is not None or not (
                    self.mentions(rest) or self.sets_terms(rest) or self.forbids(rest)
                    or self._clause.search(rest) or self._order.search(rest)
                )  # fmt: skip
                return goal if told else ""
        return ""

    def _loose_command(
        self, ways: Sequence[str], literals: Sequence[str], unsure: Command | None
    ) -> Command | None:
        """What is asked in words that are none of the rules'.

        Of several readings the first is taken in whose goal there is a name, and that name.

        Args:
            ways: The ways to read a step.
            literals: What each mark in it stands for.
            unsure: What a rule has read about a goal that is not known; None without one.
        """
        for rule, found in readings(ways, self._loose):
            goal = slot(found, "goal")
            if not goal:
                return self.read(rule, found)
            if (unsure is None or rule.kind == "how_many") and (name := self._name_in(goal)):
                return self._about(rule.kind, name)
            if unsure is None and rule.kind != "go" and not self._tells(goal):
                unsure = self.read(rule, found, literals)
        return unsure

    def _name_in(self, words: str) -> str:
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

    def _tells(self, words: str) -> bool:
        """Whether words that stand for a goal have a clause of their own."""
        return self._clause.search(words) is not None and not self._is_name(
            self.without_article(words)
        )

    def _goal(self, words: str, literals: Sequence[str]) -> str:
        """A goal without articles, with each literal in the place of its mark."""
        goal = words if self.is_pronoun(words) else self.without_article(words)
        return _MARKED.sub(lambda found: literals[int(found[1])], goal)
