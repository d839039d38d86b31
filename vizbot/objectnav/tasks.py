"""What a tick may be for, and what it comes to."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from nav.navigator import Navigation
from vizbot.core.observer import Outcome
from vizbot.core.types import Twist


class Task(Enum):
    """What is done without asking for anything in words."""

    MAP = "map what the camera shows, drive nothing"
    EXPLORE = "explore"
    COME_BACK = "come back"
    DOCK = "dock"


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """One thing to look for.

    Attributes:
        text: In the user's words.
        embedding: (D,) float32 unit, by the run's encoder.
        threshold: Theta; a search begins above it and settles for a little less.
    """

    text: str
    embedding: NDArray[np.float32]
    threshold: float


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A place to drive to.

    Attributes:
        x: In `map` [m].
        y: Likewise.
    """

    x: float
    y: float

    @property
    def xy(self) -> NDArray[np.float64]:
        """(2,) in `map` [m]."""
        return np.array([self.x, self.y])


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """What one step comes to: a twist now, and the end of the task if it has ended."""

    twist: Twist
    activity: str
    navigation: Navigation | None = None
    exploring: bool = False
    threshold: float | None = None
    ended: tuple[Outcome, str] | None = None
