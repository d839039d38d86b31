"""Models of what people and their programs send to the API; unknown fields are refused."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from vizbot.operator.session.live_map import MOST_ZONES
from vizbot.operator.session.session import SOMEBODY

_STRICT = ConfigDict(extra="forbid", use_attribute_docstrings=True)
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


class GoalsRequest(BaseModel):
    """Goals in words, visited in this order."""

    model_config = _STRICT

    texts: list[Words] = Field(min_length=1, max_length=20)
    at_once: bool = False
    """Whether the running task ends for these; otherwise they wait for their turn."""


class PlaceRequest(BaseModel):
    """A place on the map to drive to."""

    model_config = _STRICT

    x: Coordinate
    """In `map` [m]."""
    y: Coordinate
    """In `map` [m]."""
    at_once: bool = False
    """Whether the running task ends for this one; otherwise it waits for its turn."""


class TaskOptions(BaseModel):
    """How to queue a task that needs no words."""

    model_config = _STRICT

    at_once: bool = False
    """Whether the running task ends for this one; otherwise it waits for its turn."""


class CancelRequest(BaseModel):
    """Who calls a task off."""

    model_config = _STRICT

    who: PersonName = SOMEBODY
    """For the log."""


class DoubtRequest(BaseModel):
    """A question for a person, raised by a sentence that was not understood for sure."""

    model_config = _STRICT

    question: Words


class VerdictRequest(BaseModel):
    """What somebody says of the place at which the robot has arrived, or to which it goes."""

    model_config = _STRICT

    confirmed: bool
    """Whether it is what was asked for."""
    who: PersonName = SOMEBODY
    """Who says so, for the log."""


class SentenceRequest(BaseModel):
    """A sentence that somebody types to the robot."""

    model_config = _STRICT

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


class ZonesRequest(BaseModel):
    """All keep-out zones: polygons of corners x, y in `map` [m]."""

    model_config = _STRICT

    zones: list[Corners] = Field(max_length=MOST_ZONES)


class ZoneRequest(BaseModel):
    """One keep-out zone: a polygon of corners x, y in `map` [m]."""

    model_config = _STRICT

    corners: Corners


class SaveMapRequest(BaseModel):
    """How to save a map."""

    model_config = _STRICT

    replace: bool = False
    """Whether the map may take the place of another one with this name."""


class RenameMapRequest(BaseModel):
    """The new name of a saved map."""

    model_config = _STRICT

    name: str
    """Of letters, digits, spaces and -, 60 at most."""


class DriveMessage(BaseModel):
    """A motion command, sent over the WebSocket `/drive`."""

    model_config = _STRICT

    sequence: int = Field(ge=0)
    """Grows from one command to the next."""
    heard: float
    """The newest time stamp that has arrived from the robot [s]."""
    linear: float = Field(ge=-1.0, le=1.0)
    """[m/s]"""
    angular: float = Field(ge=-4.0, le=4.0)
    """[rad/s]"""
