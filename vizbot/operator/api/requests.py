"""Models of what people and their programs send to the API; unknown fields are refused."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from vizbot.operator.session.live_map import MOST_ZONES
from vizbot.operator.session.session import SOMEBODY

_MOST_CORNERS = 100

Words = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=200)]
"""What a person asks for, in one line."""
SentenceText = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]
"""What a person types, in one line: 120 words and 600 characters at most."""
PersonName = Annotated[str, StringConstraints(max_length=40)]
Coordinate = Annotated[float, Field(ge=-1000.0, le=1000.0, allow_inf_nan=False)]
"""x or y in `map` [m]."""
Corners = Annotated[
    list[tuple[Coordinate, Coordinate]], Field(min_length=3, max_length=_MOST_CORNERS)
]


class StrictRequest(BaseModel):
    """Refuses what it has no field for."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)


class GoalsRequest(StrictRequest):
    """Goals in words, visited in this order."""

    texts: list[Words] = Field(min_length=1, max_length=20)
    at_once: bool = False
    """Whether the running task ends for these; otherwise they wait for their turn."""


class PlaceRequest(StrictRequest):
    """A place on the map to drive to."""

    x: Coordinate
    """In `map` [m]."""
    y: Coordinate
    """In `map` [m]."""
    at_once: bool = False
    """Whether the running task ends for this one; otherwise it waits for its turn."""


class TaskOptions(StrictRequest):
    """How to queue a task that needs no words."""

    at_once: bool = False
    """Whether the running task ends for this one; otherwise it waits for its turn."""


class CancelRequest(StrictRequest):
    """Who calls a task off."""

    who: PersonName = SOMEBODY
    """For the log."""


class DoubtRequest(StrictRequest):
    """A question for a person, raised by a sentence that was not understood for sure."""

    question: Words


class VerdictRequest(StrictRequest):
    """What somebody says of the place at which the robot has arrived, or to which it goes."""

    confirmed: bool
    """Whether it is what was asked for."""
    who: PersonName = SOMEBODY
    """Who says so, for the log."""


class SentenceRequest(StrictRequest):
    """A sentence that somebody types to the robot."""

    text: SentenceText
    """A thing alone is a goal; words in double quotes are literal."""
    at_once: bool = False
    """Whether the running task ends for what the sentence asks for."""
    who: PersonName = SOMEBODY
    """Who types it, for the log."""


class StopRequest(BaseModel):
    """The name of the person who stops the robot. Any other body stops it just as well."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    who: str = SOMEBODY
    """For the log."""


class ZonesRequest(StrictRequest):
    """All keep-out zones: polygons of corners x, y in `map` [m]."""

    zones: list[Corners] = Field(max_length=MOST_ZONES)


class ZoneRequest(StrictRequest):
    """One keep-out zone: a polygon of corners x, y in `map` [m]."""

    corners: Corners


class SaveMapRequest(StrictRequest):
    """How to save a map."""

    replace: bool = False
    """Whether the map may take the place of another one with this name."""


class RenameMapRequest(StrictRequest):
    """The new name of a saved map."""

    name: str
    """Of letters, digits, spaces and -, 60 at most."""


class DriveMessage(StrictRequest):
    """A motion command, sent over the WebSocket `/drive`."""

    sequence: int = Field(ge=0)
    """Grows from one command to the next."""
    heard: float
    """The newest time stamp that has arrived from the robot [s]."""
    linear: float = Field(ge=-1.0, le=1.0)
    """[m/s]"""
    angular: float = Field(ge=-4.0, le=4.0)
    """[rad/s]"""
