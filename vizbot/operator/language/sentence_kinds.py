"""The kinds of sentences that a language has patterns for, and the commands that they stand for.

Commands are written as sentences that the grammar of the same language reads as these commands.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import degrees, pi

from vizbot.objectnav.tasks import ShortMove
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
)

KINDS = (
    "stop", "no", "yes", "go_on", "explore", "dock", "come_back", "help", "battery", "place",
    "sight", "task", "how_many", "where", "let_in", "keep_out", "cancel", "turn_around",
    "turn_left", "turn_right", "backwards", "forward", "all", "go",
)  # fmt: skip
"""What a language has patterns for, the first that fits is taken."""
FORBIDDABLE = {"explore", "dock", "come_back", "turn_left", "turn_right", "turn_around",
               "backwards", "forward", "all", "go"}  # fmt: skip
"""Of these a sentence that says "not" means nothing that can be done."""
LOOSE = {"where", "how_many"}
"""Of these a sentence about something unknown may be none at all."""
ABOUT: Mapping[str, type[All | WhereIs | HowMany | Cancel | KeepOut]] = {
    "all": All,
    "where": WhereIs,
    "how_many": HowMany,
    "cancel": Cancel,
    "keep_out": KeepOut,
}
"""Kinds that name one thing."""
TOPICS: Mapping[Topic, str] = {
    Topic.HELP: "help",
    Topic.BATTERY: "battery",
    Topic.PLACE: "place",
    Topic.SIGHT: "sight",
    Topic.TASK: "task",
}
"""Kinds that ask the robot about itself."""
ALONE: Mapping[str, Command] = {
    "stop": Stop(),
    "no": No(),
    "yes": Yes(),
    "go_on": GoOn(),
    "explore": Explore(),
    "dock": Dock(),
    "come_back": ComeBack(),
    "turn_around": Move((ShortMove(turn=pi),)),
    "backwards": Decline(Reason.BACKWARDS),
    "let_in": Decline(Reason.ZONE),
    **{kind: Ask(topic) for topic, kind in TOPICS.items()},
}
"""Kinds that need no further words."""


class SentenceWriter:
    """Writes the sentences of one language."""

    def __init__(self, sentences: Mapping[str, str]) -> None:
        self._sentences = sentences

    def urgent(self, text: str) -> str:
        """The same sentence, for which the running task has to give way."""
        return self._sentences["at_once"].format(text=text)

    def text(self, command: Command, quoted: Collection[str], goal_format: str) -> str:
        """One sentence for a command.

        Goals that are `quoted` stand in quotes, others as `goal_format` says: "{}" or that in
        quotes.
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
