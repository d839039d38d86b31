"""What a sentence asks for, once it is parsed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
    """Drive until nothing is left to see."""


@dataclass(frozen=True, slots=True)
class GoTo:
    """Go to one thing after another.

    Attributes:
        goals: What to go to, in this order; at least one.
        after: What to do once the last goal has ended; None: stay there.
    """

    goals: tuple[str, ...]
    after: ComeBack | Dock | None = None


@dataclass(frozen=True, slots=True)
class WhereIs:
    """Say where something is, and stay.

    Attributes:
        goal: What is asked for.
    """

    goal: str


@dataclass(frozen=True, slots=True)
class All:
    """Go to everything of a kind.

    Attributes:
        goal: What is asked for, as said: often a plural.
    """

    goal: str


Command = Stop | ComeBack | Dock | Explore | GoTo | WhereIs | All

ONE_OF_ALL = (
    "all of them it cannot visit yet: it goes to one, and of several on its map to one near by"
)
"""What is answered to `All`: the robot chooses by the way there and by how alike a place is."""

_NAMES = {Stop: "stop", GoTo: "go to", WhereIs: "where is", All: "all", ComeBack: "come back"}
_NAMES |= {Dock: "dock", Explore: "explore"}


def command_name(command: Command) -> str:
    """What kind of command it is, in plain words."""
    return _NAMES[type(command)]


def task_requests(command: GoTo | All | ComeBack | Dock | Explore) -> Sequence[str | Task]:
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
        case Explore():
            return [Task.EXPLORE]
