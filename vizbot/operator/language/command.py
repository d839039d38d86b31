"""What a sentence asks for, once it is parsed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import chain
from typing import TypeAlias, cast

from vizbot.objectnav.tasks import ShortMove, Task


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
    """Drive until nothing is left to see, then do what comes `after`; None: stay there."""

    after: Mission | None = None


@dataclass(frozen=True, slots=True)
class GoTo:
    """Go to one thing after another.

    Attributes:
        goals: What to go to, in this order; at least one.
        after: What to do once the last goal has ended; None: stay there.
    """

    goals: tuple[str, ...]
    after: Mission | None = None


@dataclass(frozen=True, slots=True)
class WhereIs:
    """Say where `goal` is, and stay."""

    goal: str


@dataclass(frozen=True, slots=True)
class HowMany:
    """Say how many of `goal`, as said: often a plural, were seen so far."""

    goal: str


@dataclass(frozen=True, slots=True)
class All:
    """Go to everything that is a `goal`, as said: often a plural."""

    goal: str


@dataclass(frozen=True, slots=True)
class Cancel:
    """Call off what was asked for, and leave the rest.

    Attributes:
        goal: What is no longer wanted.
        after: What to do instead; None: nothing.
    """

    goal: str
    after: Mission | None = None


@dataclass(frozen=True, slots=True)
class KeepOut:
    """Enter `goal`, a room, no more, or stay away from it, a thing."""

    goal: str


@dataclass(frozen=True, slots=True)
class Move:
    """Turn on the spot or drive straight ahead.

    Attributes:
        moves: In this order; at least one.
        after: What to do then; None: stay there.
    """

    moves: tuple[ShortMove, ...]
    after: Mission | None = None


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
    """Say something about yourself, and stay."""

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
    STATEMENT = "statement"
    BACKWARDS = "backwards"
    ZONE = "zone"
    TERMS = "terms"
    TOO_FAR = "too far"
    NUMBER = "number"


@dataclass(frozen=True, slots=True)
class Decline:
    """Do nothing, and say why."""

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


def drives(command: Command) -> bool:
    """Whether the robot drives for it."""
    return isinstance(command, MISSIONS) or (
        isinstance(command, Cancel) and command.after is not None
    )


def goals_of(command: Command | None) -> tuple[str, ...]:
    """The things and rooms that a command names, in order."""
    match command:
        case GoTo(goals, after):
            return (*goals, *goals_of(after))
        case Explore(after) | Move(_, after):
            return goals_of(after)
        case Cancel(goal, after):
            return (goal, *goals_of(after))
        case WhereIs(goal) | HowMany(goal) | All(goal) | KeepOut(goal):
            return (goal,)
    return ()


def with_goals(command: Command, goals: Sequence[str]) -> Command:
    """The same command for other goals, one for each of its own."""
    match command:
        case GoTo(own):
            rest = goals[len(own) :]
            return _with_after(replace(command, goals=tuple(goals[: len(own)])), rest)
        case Explore() | Move():
            return _with_after(command, goals)
        case Cancel():
            return _with_after(replace(command, goal=goals[0]), goals[1:])
        case WhereIs() | HowMany() | All() | KeepOut():
            return replace(command, goal=goals[0])
    return command


def _with_after(command: GoTo | Explore | Move | Cancel, goals: Sequence[str]) -> Command:
    """The same command with other goals in what it does then."""
    if command.after is None:
        return command
    return replace(command, after=cast(Mission, with_goals(command.after, goals)))


def split_goals(command: Command, parts: Callable[[str], Sequence[str]]) -> Command:
    """The same command, which goes to each part of a goal in turn."""
    if not isinstance(command, GoTo | Explore | Move | Cancel):
        return command
    if isinstance(command, GoTo):
        command = replace(command, goals=tuple(chain.from_iterable(map(parts, command.goals))))
    if command.after is None:
        return command
    return replace(command, after=cast(Mission, split_goals(command.after, parts)))


def task_requests(command: Mission) -> Sequence[str | Task | ShortMove]:
    """What a command puts in the robot's queue, in order."""
    match command:
        case GoTo(goals, after):
            first: list[str | Task | ShortMove] = [*goals]
        case Move(moves, after):
            first = [replace(move) for move in moves]  # each is a move of its own
        case Explore(after):
            first = [Task.EXPLORE]
        case All(goal):
            return [goal]
        case ComeBack():
            return [Task.COME_BACK]
        case Dock():
            return [Task.DOCK]
    return [*first, *([] if after is None else task_requests(after))]


def step_count(command: Command) -> int:
    """Of how many steps a command consists."""
    if isinstance(command, Cancel) and command.after is not None:
        return 1 + step_count(command.after)
    return len(task_requests(command)) if isinstance(command, MISSIONS) else 1


def join_commands(commands: Sequence[Command | None]) -> Command | None:
    """Several commands as one; None if they cannot be one, or one of them is none.

    One that refuses makes the whole refuse.
    """
    if len(commands) <= 1:
        return commands[0] if commands else None
    if (forbids := Decline(Reason.NOT)) in commands:
        return forbids
    if None in commands:
        return None
    if (
        refused := next((each for each in commands if isinstance(each, Decline)), None)
    ) is not None:
        return refused
    joined, *sooner = reversed(commands)
    for command in sooner:
        joined = None if joined is None else _in_turn(command, joined)
    return joined


def _in_turn(first: Command | None, then: Command) -> Command | None:
    """One command after the other, as one; None where nothing can come after the first."""
    match first, then:
        case (ComeBack() | Dock(), Dock()):
            return then
        case (Stop() | Yes() | No() | Ask(), _) if first == then:
            return then
        case (GoTo(goals, None), GoTo(more, after)):
            return GoTo((*goals, *more), after)
        case (Move(moves, None), Move(more_moves, after)):
            return Move((*moves, *more_moves), after)
        case (GoTo() | Explore() | Move(), GoTo() | Explore() | Move() | ComeBack() | Dock()):
            after_first = then if first.after is None else _in_turn(first.after, then)
            done = cast(Mission | None, after_first)
            return None if done is None else replace(first, after=done)
        case (Cancel(after=None), GoTo() | All() | ComeBack() | Dock() | Explore() | Move()):
            return replace(first, after=then)
    return None
