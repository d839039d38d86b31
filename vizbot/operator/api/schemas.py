"""What people and their programs send to the API."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.operator.api.map_routes import STRICT, Coordinate, Words


class Goals(BaseModel):
    """Goals in words, visited in this order."""

    model_config = STRICT

    texts: list[Words] = Field(min_length=1, max_length=20)
    at_once: bool = False
    """What is running ends; else they wait for their turn."""


class PlaceRequest(BaseModel):
    """A place on the map to drive to."""

    model_config = STRICT

    x: Coordinate
    y: Coordinate
    at_once: bool = False
    """What is running ends; else it waits for its turn."""


class Order(BaseModel):
    """What belongs to something that needs no words."""

    model_config = STRICT

    at_once: bool = False
    """What is running ends; else it waits for its turn."""


class Doubt(BaseModel):
    """What was not understood for sure."""

    model_config = STRICT

    question: Words
    """For a person to answer."""


class Motion(BaseModel):
    """What to drive by hand."""

    model_config = STRICT

    sequence: int = Field(ge=0)
    """Grows from one to the next."""
    heard: float
    """The newest of our times that has arrived [s]."""
    linear: float = Field(ge=-1.0, le=1.0)
    """[m/s]"""
    angular: float = Field(ge=-4.0, le=4.0)
    """[rad/s]"""
