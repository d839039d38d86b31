"""The kinds of sentences that a language has patterns for, and the commands that they stand for."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi

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
