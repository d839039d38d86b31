"""The place at which the robot has arrived, as people are asked about it."""

from __future__ import annotations

from dataclasses import dataclass

from vizbot.core.observer import GoalReport


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """Where the robot has arrived last. Another search or another map ends it.

    Attributes:
        number: Of the task.
        report: On its goal.
        picture: JPEG of what was found, with a box around it; None where no picture was kept.
        no_picture: Why no picture was kept, in one line; empty where one was.
        confirmed: Whether somebody says that it is what was asked for; None before.
    """

    number: int
    report: GoalReport
    picture: bytes | None
    no_picture: str = ""
    confirmed: bool | None = None
