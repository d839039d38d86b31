"""What a sentence asks for, once it is parsed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import TypeAlias

from vizbot.behaviours.short_move import ShortMove
from vizbot.objectnav.tasks import Task


@dataclass(frozen=True, slots=True)
class Stop:
    """Stand still at once; asks for nothing back."""


@dataclass(frozen=True, slots=True)
class ComeBack:
    """Go to where the run began."""


@dataclass(frozen=True, slots=True)
class Dock:
    """Go to the charger and charge."""


@dataclass(frozen=True, slots=True)
class Explore:
    """Drive until nothing is left to see.

    Attributes:
        after: What to do then; None: stay there.
    """

    after: ComeBack | Dock | None = None


@dataclass(frozen=True, slots=True)
class GoTo:
    """Go to one thing after another.

    Attributes:
        goals: What to go to, in this order; at least one.
        after: What to do once the last goal has ended; None: stay there.
    """

    goals: tuple[str, ...]
    after: ComeBack | Dock | Explore | None = None


@dataclass(frozen=True, slots=True)
class WhereIs:
    """Say where something is, and stay.

    Attributes:
        goal: What is asked for.
    """

    goal: str


@dataclass(frozen=True, slots=True)
class HowMany:
    """Say how many of a kind were seen so far.

    Attributes:
        goal: What is asked for, as said: often a plural.
    """

    goal: str


@dataclass(frozen=True, slots=True)
class All:
    """Go to everything of a kind.

    Attributes:
        goal: What is asked for, as said: often a plural.
    """

    goal: str


@dataclass(frozen=True, slots=True)
class Cancel:
    """Call off what was asked for, and leave the rest.

    Attributes:
        goal: What is no longer wanted.
    """

    goal: str


@dataclass(frozen=True, slots=True)
class KeepOut:
    """Enter a room no more.

    Attributes:
        goal: The room, or a thing to stay away from.
    """

    goal: str


@dataclass(frozen=True, slots=True)
class Move:
    """Turn on the spot or drive straight ahead.

    Attributes:
        moves: In this order; at least one.
    """

    moves: tuple[ShortMove, ...]


@dataclass(frozen=True, slots=True)
class GoOn:
    """Do what still waits."""


class Topic(Enum):
    """What a robot can be asked about itself."""

    HELP = "help"
    BATTERY = "battery"
    PLACE = "where are you"
    SIGHT = "what do you see"
    TASK = "what are you doing"


@dataclass(frozen=True, slots=True)
class Ask:
    """Say something about yourself, and stay.

    Attributes:
        topic: What.
    """

    topic: Topic


@dataclass(frozen=True, slots=True)
class Yes:
    """Agree to what was asked back."""


@dataclass(frozen=True, slots=True)
class No:
    """Do not agree to what was asked back."""


class Reason(Enum):
    """Why a sentence sets nothing off although it is understood."""

    NOT = "not"
    CANNOT = "cannot"
    BACKWARDS = "backwards"
    TOO_FAR = "too far"


@dataclass(frozen=True, slots=True)
class Decline:
    """Do nothing, and say why.

    Attributes:
        reason: Why.
    """

    reason: Reason


Mission: TypeAlias = GoTo | All | ComeBack | Dock | Explore | Move
"""What the robot drives for."""
MISSIONS = GoTo, All, ComeBack, Dock, Explore, Move
"""The same, to be asked for with `isinstance`."""
Command: TypeAlias = (
    Mission | Stop | WhereIs | HowMany | Cancel | KeepOut | GoOn | Ask | Yes | No | Decline
)

_NAMES: dict[type[Command], str] = {
    Stop: "stop",
    GoTo: "go to",
    WhereIs: "where is",
    HowMany: "how many",
    All: "all",
    ComeBack: "come back",
    Dock: "dock",
    Explore: "explore",
    Cancel: "cancel",
    KeepOut: "keep out",
    Move: "move",
    GoOn: "go on",
    Yes: "yes",
    No: "no",
}


def command_name(command: Command) -> str:
    """What kind of command it is, in plain words."""
    match command:
        case Ask(topic):
            return topic.value
        case Decline(reason):
            return f"nothing: {reason.value}"
    return _NAMES[type(command)]


def goals_of(command: Command) -> tuple[str, ...]:
    """The things and rooms that a command names, in order."""
    match command:
        case GoTo(goals):
            return goals
        case WhereIs(goal) | HowMany(goal) | All(goal) | Cancel(goal) | KeepOut(goal):
            return (goal,)
    return ()


def with_goals(command: Command, goals: Sequence[str]) -> Command:
    """The same command for other goals, one for each of its own."""
    match command:
        case GoTo():
            return replace(command, goals=tuple(goals))
        case WhereIs() | HowMany() | All() | Cancel() | KeepOut():
            return replace(command, goal=goals[0])
    return command


def task_requests(command: Mission) -> Sequence[str | Task | ShortMove]:
    """What a command puts in the robot's queue, in order."""
    match command:
        case GoTo(goals, after):
            return [*goals, *([] if after is None else task_requests(after))]
        case All(goal):
            return [goal]
        case ComeBack():
            return [Task.COME_BACK]
        case Dock():
            return [Task.DOCK]
        case Explore(after):
            return [Task.EXPLORE, *([] if after is None else task_requests(after))]
        case Move(moves):
            return [replace(move) for move in moves]  # each is a move of its own


def step_count(command: Command) -> int:
    """Of how many steps a command consists."""
    match command:
        case GoTo(goals, after):
            return len(goals) + (0 if after is None else step_count(after))
        case Explore(after):
            return 1 + (0 if after is None else step_count(after))
        case Move(moves):
            return len(moves)
    return 1


def join_commands(commands: Sequence[Command | None]) -> Command | None:
    """Several commands as one; None if they cannot be one, or one of them is none.

    One that refuses makes the whole refuse.
    """
    if len(commands) == 1:
        return commands[0]
    if (forbids := Decline(Reason.NOT)) in commands:
        return forbids
    if None in commands:
        return None
    if (
        refused := next((each for each in commands if isinstance(each, Decline)), None)
    ) is not None:
        return refused
    if moves := [move for each in commands if isinstance(each, Move) for move in each.moves]:
        alone = all(isinstance(each, Move) for each in commands)
        return Move(tuple(moves)) if alone else None
    goals: list[str] = []
    explore: Explore | None = None
    home: ComeBack | Dock | None = None
    for command in commands:
        match command:
            case GoTo(more, None) if explore is None and home is None:
                goals += more
            case Explore(after) if explore is None and home is None:
                explore, home = Explore(), after
            case Dock():
                home = command
            case ComeBack() if home is None:
                home = command
            case GoTo(more, after) if explore is None and home is None and after is not None:
                goals += more
                explore, home = (
                    (Explore(), after.after) if isinstance(after, Explore) else (None, after)
                )
            case _:
                return None
    after = home if explore is None else Explore(home)
    return GoTo(tuple(goals), after) if goals else after
