"""Writes commands as sentences that the grammar of the same language reads as these commands."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import degrees

from vizbot.objectnav.tasks import ShortMove
from vizbot.operator.language.command import Ask, Cancel, Command, Decline, Explore, GoTo, Move
from vizbot.operator.language.sentence_kinds import ABOUT, ALONE, TOPICS


class SentenceWriter:
    """Writes the sentences of one language."""

    def __init__(self, sentences: Mapping[str, str]) -> None:
        """Take over how the language says each command."""
        self._sentences = sentences

    def urgent(self, text: str) -> str:
        """The same sentence, for which the running task has to give way."""
        return self._sentences["at_once"].format(text=text)

    def text(self, command: Command, quoted: Collection[str], goal_format: str) -> str:
        """One sentence for a command.

        Args:
            command: What it asks for.
            quoted: Goals that stand in quotes.
            goal_format: How other goals stand, "{}" or the same in quotes.
        """

        def named(goal: str) -> str:
            return ('"{}"' if goal in quoted else goal_format).format(goal)

        match command:
            case GoTo(goals, after):
                steps = self._in_turn([*map(named, goals)], after, quoted, goal_format)
                return self._sentences["go_to"].format(goals=steps)
            case Cancel(goal, after):
                cancelled = self._sentences["cancel"].format(goal=named(goal))
                return self._in_turn([cancelled], after, quoted, goal_format)
            case Explore(after):
                return self._in_turn([self._sentences["explore"]], after, quoted, goal_format)
            case Move(moves, after):
                return self._in_turn([*map(self._move_text, moves)], after, quoted, goal_format)
            case Ask(topic):
                return self._sentences[TOPICS[topic]]
            case Decline(reason):
                return self._sentences[reason.value]
        for kind, about in ABOUT.items():
            if isinstance(command, about):
                return self._sentences[kind].format(goal=named(command.goal))
        kind = next(kind for kind, alone in ALONE.items() if alone == command)
        return self._sentences[kind]

    def _in_turn(
        self, steps: list[str], after: Command | None, quoted: Collection[str], goal_format: str
    ) -> str:
        last = [] if after is None else [self.text(after, quoted, goal_format)]
        return self._sentences["join"].join([*steps, *last])

    def _move_text(self, move: ShortMove) -> str:
        if move.turn:
            kind = "turn_left" if move.turn > 0.0 else "turn_right"
            return self._sentences[kind].format(number=f"{degrees(abs(move.turn)):g}")
        return self._sentences["forward"].format(number=f"{move.forward:g}")
