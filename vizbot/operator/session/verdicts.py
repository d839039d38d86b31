"""The places of which people are asked whether they are the goal."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import GoalReport, Step
from vizbot.objectnav.looks import APART

_NO_ARTICLE = re.compile(r"(the|an?|my|our|your|this|that|some) .*|.*[^suai]s", re.IGNORECASE)
"""Goals that take no article: those that have one, and what looks like a plural."""


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """Where the robot has arrived last. Another search or another map ends it.

    Attributes:
        number: Number of the task.
        report: Report on its goal.
        picture: JPEG of what was found, with a box around it; None where no picture was kept.
        no_picture: Why no picture was kept, in one line; empty where one was.
        confirmed: Whether somebody says that it is what was asked for; None before.
    """

    number: int
    report: GoalReport
    picture: bytes | None
    no_picture: str = ""
    confirmed: bool | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ApproachedCandidate:
    """The candidate that the robot approaches in a search.

    Attributes:
        number: Index of the step in which it turned to that place.
        goal: What is searched for.
        place_xy: (2,) in `map` [m].
        confirmed: Whether somebody has said to go there.
    """

    number: int
    goal: str
    place_xy: NDArray[np.float64]
    confirmed: bool = False

    @property
    def headline(self) -> str:
        """What the robot says of it: "I see something like a sofa"."""
        article = "an " if self.goal[:1].lower() in tuple("aeiou") else "a "
        named = self.goal if _NO_ARTICLE.fullmatch(self.goal) else article + self.goal
        return f"I see something like {named}"


def candidate_of(step: Step, before: ApproachedCandidate | None) -> ApproachedCandidate | None:
    """The candidate that the robot approaches in a step; None without one, or after an arrival.

    `before` is that of the step before, which is returned again where the place is the same.
    """
    if step.candidate_xy is None or step.ended is not None:
        return None
    if (
        before is not None
        and before.goal == step.goal
        and np.linalg.norm(before.place_xy - step.candidate_xy) <= APART
    ):
        return replace(before, place_xy=step.candidate_xy)
    return ApproachedCandidate(step.index, step.goal, step.candidate_xy)
