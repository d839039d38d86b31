"""Finds what is asked for in a line that says more than that.

"My feet hurt can you go to the sofa I told you already" has three clauses, and one of them asks for
something. The other two are remarks, so they are left out. A clause is left out where
nothing in it can change what the others ask for: it forbids nothing, takes nothing back, reports
nobody's words, sets no condition and no time, and begins like no order.

"The bed, sorry, I mean the sofa" and "the sofa, not the bed" are put as "the sofa".
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import islice
from typing import Any

from vizbot.operator.language.command import Ask, Cancel, Command, Decline, GoTo, WhereIs, goals_of
from vizbot.operator.language.goal_reader import GoalReader
from vizbot.operator.language.sentence_rules import RuleMaker, SentenceRule, is_read, readings, slot
from vizbot.operator.language.step_reader import StepReader
from vizbot.operator.language.step_splitter import (
    MOST_STEPS,
    SentenceStep,
    StepSplitter,
    by_word,
    either,
    tidy,
)
from vizbot.operator.language.wording import Wording

_KEPT = 256
"""Clauses whose parts are kept."""
_MOST_VERBS = 12
"""Verbs of a clause before which it may be cut."""
_MOST_PAUSES = 8
"""Pauses before and after the words that announce a correction."""
_FEWEST_WORDS = 3
"""A shorter clause that nobody knows may be whom a line is meant for: "Anna, come back"."""


class ClauseReader:
    """Separates the clauses of one language that ask for something from those that do not."""

    def __init__(
        self,
        language: Mapping[str, Any],
        maker: RuleMaker,
        splitter: StepSplitter,
        reader: StepReader,
        wording: Wording,
        goals: GoalReader,
    ) -> None:
        remarks = language["remarks"]
        verbs = either(language["imperatives"])
        marker, pause = maker.part("corrections"), maker.part("pauses")
        contrast = maker.part("contrasts")
        self._splitter, self._reader = splitter, reader
        self._wording, self._goals = wording, goals
        names = (
            "around", "denials", "insisting", "joining", "leaving", "looking", "pointing", "rather",
            "reminders", "sparing", "ways", "whereabouts",
        )  # fmt: skip
        self._rules = {name: maker.rules({name: remarks[name]}) for name in names}
        self._going = language["sentences"]["go_to"].format(goals="").strip()
        self._condition = re.compile(rf"(?:{either(language['words']['conditions'])})\b")
        self._amount = re.compile(rf"\d|\b(?:{either(by_word(language['units']))})\b")
        self._retracts = re.compile(rf"\b(?:{either(remarks['retracts'])})\b")
        self._backwards = re.compile(rf"\b(?:{either(remarks['backwards'])})\b")
        requests = rf"{maker.part('requests')}(?= |$)"
        self._request = re.compile(
            rf"(?P<question>{maker.part('questions')}{requests})|,?(?={requests})"
        )
        self._corrected = re.compile(
            rf"(?:,?{pause}){{0,{_MOST_PAUSES}}},?(?P<marker>{marker})"
            rf"(?:,?(?:{marker}|{pause})){{0,{_MOST_PAUSES}}},? (?=\S)"
        )
        self._cut_up = lru_cache(_KEPT)(self._parts)  # a line is read in more than one way
        self._marker = re.compile(marker)
        self._correction = re.compile(rf"{marker}(?: |$)")
        self._contrast = re.compile(
            rf"(?P<before>.*?){contrast} (?P<other>.+?)(?P<after>(?: (?:{verbs})\b.*)?)"
        )
        self._verb = re.compile(rf"(?: (?P<order>{verbs})|{maker.part('tails')})(?= |$)")
        self._unfinished = {word.casefold() for word in remarks["unfinished"]}
        self._subject = re.compile(rf"(?:{either(remarks['subjects'])})\b")
        self._governed = re.compile(rf"\S+ (?:{either(remarks['subjects'])})\b")
        self._replaces = re.compile(rf"\b(?:{either(remarks['replacing'])})\b")
        self._charger = re.compile(rf"{maker.part('charger')}(?= |$)")
        self._finite = re.compile(rf"\b(?:{either(remarks['finite'])})\b")

    def asked(
        self, polished: str, literals: Sequence[str], *, bare: bool = False, polite: bool = False
    ) -> tuple[str, str]:
        """A line without the clauses that ask for nothing, and the only name in these.

        Both are empty where nothing is left out, the name also where there is no other than one.
        What asks to come to a person who has told where he is asks to go there: "I am on the sofa,
        come to me".

        Questions about the robot itself, and what tells that a thing is lost, count as such where
        something else is asked for; so does why something is called off, and what is not. Nothing
        remains of a line that takes back what it asks for.

        Args:
            polished: As the splitter has it.
            literals: What each mark in it stands for.
            bare: Whether a goal needs no words before it. Then what tells something of it asks for
                nothing: "the dog, he is hungry".
            polite: Whether its first words end with "please". These are asked for all the same,
                if they are a goal: "trash can please, it stinks".
        """
        asked, questions, told = list[str](), list[str](), list[str]()
        lost, missed, cancels = list[str](), list[str](), False
        clauses = self._clauses(polished, literals)
        replaced = any(map(self._replaces.search, clauses))
        insists = any(self._reads("insisting", clause) for clause in clauses)
        for clause in clauses if len(clauses) <= MOST_STEPS else []:
            steps = self._splitter.steps(clause)
            command = self._reader.command(steps[0], literals) if len(steps) == 1 else None
            if self._reads("reminders", clause) or (cancels and self._reads("sparing", clause)):
                continue
            if (said := next(readings([clause], self._rules["insisting"]), None)) is not None:
                goal = slot(said[1], "goal")
                if not goal:
                    continue  # "not the bed, the sofa I said"
                contrasts = any(map(self._wording.forbids, clauses))
                order = self._wording.begins_order(goal)
                if contrasts and not order and self._goes(goal, literals):
                    asked.append(f"{self._going} {goal}")
                    continue
            cancels = cancels or isinstance(command, Cancel)
            if isinstance(command, Ask) and self._condition.match(clause):
                return "", ""  # "once you are charged, go to the sofa"
            if isinstance(command, Decline | None) and self._only_addresses(clause, steps):
                continue  # "love, ..."
            if isinstance(command, Ask):
                questions.append(clause)
            elif self._tells_of_loss(command, clause):
                lost.append(clause)
                missed += goals_of(command)
            elif self._only_sounds(command, clause, asked):
                told.append(clause)
            elif self.is_marker(clause) or not (
                isinstance(command, Decline | None)
                or (not goals_of(command) and self._wording.is_idle(clause))
            ):
                asked.append(clause)
            elif self._wording.is_idle(clause):
                if bare and " " in clause and self._backwards.fullmatch(clause):
                    return "", ""  # "the scissors, I find"
                continue  # "..., would you" sets no terms
            elif (kept := self._without_contrast(clause, literals)) is not None:
                if bare and not (kept or asked or insists):
                    return "", ""  # "not the bed, the sofa"
                asked += [kept] if kept else []
            elif not self._only_tells(clause):
                asked.append(clause)
            elif (
                self._wording.sets_terms(clause, aside=not (bare or cancels))
                or (asked and not replaced and self._takes_back(clause))
                or (bare and not (polite and self._only_names(asked)) and self._tells(clause))
            ):
                return "", ""
            else:
                told.append(clause)
        told_of = ", ".join(told + missed)
        name = self._goals.first_name(told_of)
        if self._goals.mentions(told_of.replace(name, ",")):
            name = ""
        here = [slot(found, "goal") for _, found in readings(told, self._rules["whereabouts"])]
        place = self._goals.first_name(here[0]) if len(here) == 1 else ""
        if name and not questions and self._all_read(asked, self._rules["pointing"]):
            asked = [f"{self._going} {name}"]
        if place and not questions and self._all_read(asked, self._rules["joining"]):
            asked = [f"{self._going} {place}"]
        remains = ", ".join(asked or questions or lost)
        return remains, name

    def _tells_of_loss(self, command: Command | None, clause: str) -> bool:
        """Whether a clause asks where something is by telling that it is lost: "I lost my bag"."""
        loses = isinstance(command, WhereIs) and self._subject.match(clause) is not None
        return loses and not self._wording.sets_terms(clause)

    def _only_sounds(self, command: Command | None, clause: str, asked: Sequence[str]) -> bool:
        """Whether a clause sounds like an order only: "never mind the mess, go to the sofa".

        Or it tells what for: "turn left, I would like to see your other side".
        """
        known = all(map(self._goals.knows, goals_of(command)))
        wishes = isinstance(command, GoTo) and asked and self._subject.match(clause) is not None
        return not known and (isinstance(command, Cancel) or bool(wishes))

    def _only_names(self, clauses: Sequence[str]) -> bool:
        """Whether clauses are one known goal."""
        steps = [step for clause in clauses for step in self._splitter.steps(clause)]
        return len(steps) == 1 and self._goals.knows(self._goals.without_article(steps[0].words))

    def _only_addresses(self, clause: str, steps: Sequence[SentenceStep]) -> bool:
        """Whether a clause does no more than to say whom an order is for."""
        says = self.denies(clause) or self.is_marker(clause) or self._condition.match(clause)
        return not says and not any(step.words for step in steps)

    def _tells(self, clause: str) -> bool:
        """Whether a clause may tell something of a thing that stands alone: "he is hungry"."""
        if self._reads("around", clause):
            return False
        return self._backwards.search(clause) is not None or self._goals.mentions(clause)

    def _reads(self, name: str, clause: str) -> bool:
        """Whether one of the patterns of remarks of this name reads a clause."""
        return is_read(clause, self._rules[name])

    def denies(self, clause: str) -> bool:
        """Whether a clause takes back all that was said before it."""
        return self._reads("denials", clause)

    def only_looks(self, step: SentenceStep) -> bool:
        """Whether a step asks for no more than to look where the one before it leads."""
        return self._reads("looking", step.whole)

    def only_leaves(self, step: SentenceStep) -> bool:
        """Whether a step asks to leave a known thing where and as it is."""
        return any(
            self._goals.knows(self._goals.without_article(slot(found, "goal")))
            for _, found in readings([step.whole], self._rules["leaving"])
        )

    def corrects(self, clause: str) -> bool:
        """Whether a clause begins like one that replaces what was said before it."""
        return self._correction.match(f" {clause}") is not None

    def _all_read(self, clauses: Sequence[str], rules: Sequence[SentenceRule]) -> bool:
        """Whether clauses are one step, and a rule reads it."""
        steps = [step for clause in clauses for step in self._splitter.steps(clause)]
        return len(steps) == 1 and next(readings(steps[0].ways, rules), None) is not None

    def is_marker(self, clause: str) -> bool:
        """Whether a clause does nothing but announce that it will be replaced."""
        return self._marker.fullmatch(f" {clause}") is not None

    def _clauses(self, polished: str, literals: Sequence[str]) -> list[str]:
        """A line cut at its commas, before what corrects it, and before each order."""
        corrected = self._corrected.sub(self._cut, f" {polished}")
        cut = self._request.sub(lambda found: found["question"] or ", ", corrected)
        clauses = tidy(cut).split(", ")
        kept = tuple(literals)
        return [part for clause in clauses for part in self._cut_up(clause, kept)]

    def _cut(self, found: re.Match[str]) -> str:
        """A marker of a correction between two pauses, unless it belongs to what is before it."""
        rest = found.string[found.end() :].partition(",")[0]
        begins = not found.string[: found.start()] and "," not in found[0]
        if begins and self._wording.forbids(found["marker"]) and self._goals.is_name(rest):
            return found[0]  # "no kitchen, it is wet"
        belongs = found.string[: found.start()].rpartition(" ")[2] in self._unfinished
        return found[0] if belongs else f",{found['marker']}, "  # "we no longer need it"

    def forget(self) -> None:
        """Forget the clauses whose parts are kept, as where reading is timed."""
        self._cut_up.cache_clear()

    def _parts(self, clause: str, literals: tuple[str, ...]) -> list[str]:
        """A clause cut before the orders in it: "I am tired go to the sofa turn around"."""
        if self._command(clause, literals) is not None:
            return [clause]
        parts, begin = list[str](), 0
        for found in islice(self._verb.finditer(clause), _MOST_VERBS):
            before = clause[begin : found.start()].strip()
            if before and self._is_complete(before, literals, order=bool(found["order"])):
                parts.append(before)
                begin = found.start()
        return [*parts, clause[begin:].strip()]

    def _is_complete(self, words: str, literals: Sequence[str], *, order: bool) -> bool:
        """Whether another clause may follow words without a pause, since they say something."""
        if self._reads("reminders", words):
            return True
        steps = self._splitter.steps(words)
        ends = {said.rpartition(" ")[2] for said in (words, *(step.words for step in steps))}
        idle = self._wording.is_idle(words) or self._wording.forbids(words)
        if idle or ends & self._unfinished:
            return False
        if self._command(words, literals) is not None:
            return True
        last = words.rpartition(" ")[2]
        if not order or last.endswith("ly"):
            return False
        if self._subject.match(words):
            return self._finite.search(words) is not None
        return self._only_tells(words) and not self._goals.mentions(last)

    def _command(self, words: str, literals: Sequence[str]) -> Command | None:
        """What words ask for by themselves; None where that is nothing, or nothing known."""
        steps = self._splitter.steps(words)
        command = self._reader.command(steps[0], literals) if len(steps) == 1 else None
        known = all(goal in literals or self._goals.knows(goal) for goal in goals_of(command))
        return command if known and not isinstance(command, Decline) else None

    def _only_tells(self, clause: str) -> bool:
        """Whether a clause without a command asks for nothing."""
        ways = [way for step in self._splitter.steps(clause) for way in (step.whole, *step.ways)]
        told = next(readings(ways[:_MOST_VERBS], self._rules["ways"]), None) is not None
        if told or self.denies(clause) or self._wording.is_idle(clause):
            return True
        order = self._wording.begins_order(clause) or self._wording.forbids(clause)
        strange = len(clause.split()) < _FEWEST_WORDS or self._goals.mentions(clause)
        strange = strange or self._governed.match(clause) is not None
        strange = strange or self._amount.search(clause) is not None
        strange = strange or self._charger.search(f" {clause}") is not None
        goal = any(self._goals.without_article(way) != way for way in ways)
        return not (order or strange or goal or self.corrects(clause))

    def _takes_back(self, clause: str) -> bool:
        """Whether a clause takes back what was asked for before it."""
        forbids = self._wording.forbids(clause) and self._retracts.search(clause) is not None
        return forbids or self.denies(clause)

    def _without_contrast(self, clause: str, literals: Sequence[str]) -> str | None:
        """A clause without the goal that it does not mean; None where it names none."""
        if (read := next(readings([clause], self._rules["rather"]), None)) is not None:
            goals = list(read[1].groups())
            return goals[-1] if all(self._goes(goal, literals) for goal in goals) else None
        if (found := self._contrast.fullmatch(f" {clause}")) is None:
            return None
        before, other, after = (found[part].strip(" ,") for part in ("before", "other", "after"))
        if self._goals.refined(other, "") is not None:
            other = ""  # "the red one"
        if all(self._goes(words, literals) for words in (before, other) if words.strip()):
            return before or after
        return None

    def _goes(self, words: str, literals: Sequence[str]) -> bool:
        """Whether words are one known goal, with or without an order before it."""
        steps = self._splitter.steps(words)
        if len(steps) != 1:
            return False
        command = self._reader.command(steps[0], literals, bare=True)
        return isinstance(command, GoTo) and all(map(self._goals.knows, command.goals))
