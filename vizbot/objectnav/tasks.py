"""The tasks of a tick, and the decision that it makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from math import degrees
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mapping.clip.background.phrases import other_rooms
from mapping.clip.fitted.encoder import embed_asked, weights_of
from mapping.clip.places.evidence import Weights, fitted_weights
from vizbot.core.observer import OpenQuestion, Outcome
from vizbot.core.types import Twist

if TYPE_CHECKING:  # their modules load torch and numba
    from mapping.clip.encoder import TextEncoder
    from nav.navigator import Navigation

FARTHEST = 5.0
"""Longest way straight ahead that may be asked for [m]."""


class Task(Enum):
    """Tasks without a goal in words."""

    MAP = "map what the camera shows, drive nothing"
    EXPLORE = "explore"
    COME_BACK = "come back"
    DOCK = "dock"
    FIND_PLACE = "find its place on the map"


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """One thing to look for.

    Attributes:
        text: The goal in the user's words.
        embedding: (D,) float32 unit, of the bare words, by the encoder of the run.
        threshold: Theta, for the method `paper`.
        note: How the encoder understands the words, in one line; None where it needs no saying.
        rivals: (R, D) embeddings of what a place may be instead, as in `Query`; only rooms have
            any.
        log_odds: Scale and bias of the encoder, as in `TextEncoder`; None where they are not known.
        weights: Of the belief, as they were fitted to the encoder.
        asked: (D,) what the belief asks by; None where that is `embedding`.
    """

    text: str
    embedding: NDArray[np.float32]
    threshold: float
    note: str | None = None
    rivals: Sequence[NDArray[np.float32]] = ()
    log_odds: tuple[float, float] | None = None
    weights: Weights = field(default_factory=fitted_weights)
    asked: NDArray[np.float32] | None = None

    @property
    def is_room(self) -> bool:
        """Whether a room is looked for, and no thing."""
        return len(self.rivals) > 0


def goal_of(encoder: TextEncoder, text: str, threshold: float | None = None) -> Goal:
    """The goal for words, as the encoder knows them; `threshold` None is the encoder's.

    Raises:
        ConfigError: the encoder has no name for them.
    """
    reading = encoder.reading(text)
    [embedding] = encoder.embed_texts([reading.text])
    asked, *rivals = embed_asked(encoder, [reading.text, *other_rooms(reading.text)])
    least = encoder.threshold if threshold is None else threshold
    weights = weights_of(encoder)
    return Goal(text, embedding, least, reading.note, rivals, encoder.log_odds, weights, asked)


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A place to drive to.

    Attributes:
        x: In `map` [m].
        y: In `map` [m].
    """

    x: float
    y: float

    @property
    def xy(self) -> NDArray[np.float64]:
        """(2,) in `map` [m]."""
        return np.array([self.x, self.y])


@dataclass(frozen=True, slots=True)
class ShortMove:
    """A turn on the spot or a distance straight ahead that somebody named: one of the two.

    Attributes:
        turn: Counterclockwise, -2 pi to 2 pi [rad].
        forward: 0 to `FARTHEST` [m].
    """

    turn: float = 0.0
    forward: float = 0.0

    @property
    def text(self) -> str:
        """In plain words."""
        if self.turn:
            return f"turn {'left' if self.turn > 0.0 else 'right'} {degrees(abs(self.turn)):.0f}°"
        return f"go forward {self.forward:.1f} m"


Errand: TypeAlias = Goal | Waypoint | Task | ShortMove
"""What a tick of the robot is done for."""


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """What is decided in one step.

    Attributes:
        twist: What to drive now.
        activity: What the robot is doing, in plain words.
        navigation: The way that the twist is part of; None without one.
        exploring: Whether that way leads into the unknown.
        threshold: The score that the places of the goal were compared with; None where none were.
        why: Why this is done, as in `Step`; empty where it needs no saying.
        ended: How the task ended in this step, and why in one line; None while it goes on.
        score: Score of the place that this is done for; None where it is done for none.
        question: As in `Step`.
        leaves_dock: Whether the twist takes the robot off its dock.
        idle: Whether the robot waits for a person or the base looks for its dock, so that no
            progress is due.
        way_left: What is left of a move without a path, a distance [m] or a turn [rad]; else None.
    """

    twist: Twist
    activity: str
    navigation: Navigation | None = None
    exploring: bool = False
    threshold: float | None = None
    ended: tuple[Outcome, str] | None = None
    why: str = ""
    score: float | None = None
    question: OpenQuestion | None = None
    leaves_dock: bool = False
    idle: bool = False
    way_left: float | None = None
