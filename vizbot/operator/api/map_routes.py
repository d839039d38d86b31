"""The part of the API that is about maps: asking, keep-out zones, keeping and changing them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Annotated

import numpy as np
from fastapi import APIRouter, HTTPException, Query
from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from vizbot.core.errors import ConfigError, MapError, VizbotError
from vizbot.operator.session.live_map import MOST_ZONES, LiveMap

STRICT = ConfigDict(extra="forbid")
_MOST_CORNERS = 100

Words = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=200)]
Coordinate = Annotated[float, Field(ge=-1000.0, le=1000.0, allow_inf_nan=False)]
"""x or y in `map` [m]."""
Corners = Annotated[
    list[tuple[Coordinate, Coordinate]], Field(min_length=3, max_length=_MOST_CORNERS)
]


class Zones(BaseModel):
    """Keep-out zones: polygons of corners x, y in `map` [m]."""

    model_config = STRICT

    zones: list[Corners] = Field(max_length=MOST_ZONES)


class Zone(BaseModel):
    """One keep-out zone: a polygon of corners x, y in `map` [m]."""

    model_config = STRICT

    corners: Corners


class SaveRequest(BaseModel):
    """How to keep a map."""

    model_config = STRICT

    replace: bool = False
    """The map that has this name is no more."""


def map_router(live_map: LiveMap) -> APIRouter:
    """What answers for the maps of a robot."""
    router = APIRouter()

    @router.get("/map/places")
    def places(text: Annotated[Words, Query()]) -> dict[str, object]:
        """Where on the map, as it is now, is what these words ask for; best place first.

        `told` is the answer in a line, seen from the robot.
        """
        with refusals():
            answer = live_map.places(text)
            return asdict(answer) | {"told": live_map.summary(answer)}

    @router.get("/map/vocabulary")
    def vocabulary() -> dict[str, list[str]]:
        """Which of the usual things and rooms of a household the map finds."""
        with refusals():
            return {"phrases": live_map.vocabulary()}

    @router.get("/map/keep-out")
    def keep_out() -> dict[str, object]:
        """Zones that the robot keeps out of."""
        with refusals():
            return {"zones": [zone.tolist() for zone in live_map.keep_out()]}

    @router.put("/map/keep-out")
    def set_keep_out(zones: Zones) -> dict[str, int]:
        """Have the robot keep out of these zones and no others; who drives by hand may enter."""
        with refusals():
            live_map.set_keep_out([np.array(corners, np.float32) for corners in zones.zones])
        return {"zones": len(zones.zones)}

    @router.post("/map/keep-out")
    def add_zone(zone: Zone) -> dict[str, int]:
        """Have the robot keep out of one more zone, whatever others draw meanwhile."""
        with refusals():
            return {"zones": live_map.add_zone(np.array(zone.corners, np.float32))}

    @router.delete("/map/keep-out")
    def remove_zone(zone: Zone) -> dict[str, int]:
        """Let the robot into the zone that has these corners."""
        with refusals():
            return {"zones": live_map.remove_zone(np.array(zone.corners, np.float32))}

    @router.get("/maps")
    def names() -> dict[str, list[str]]:
        """Names of the maps that are kept, the newest first."""
        return {"names": live_map.names()}

    @router.put("/maps/{name}")
    def save(name: str, kept: SaveRequest) -> dict[str, str]:
        """Keep the map as it is now."""
        with refusals():
            live_map.save(name, replace=kept.replace)
        return {"kept": name}

    @router.post("/maps/{name}/begin")
    def begin_in(name: str) -> dict[str, str | None]:
        """Go on in a map that is kept; the one that is left is kept as what the answer says.

        What the run's folder says of places goes on in the other map's axes.
        """
        with refusals():
            return {"left": live_map.begin(name)}

    @router.post("/map/new")
    def begin_anew() -> dict[str, str | None]:
        """Begin an empty map; the one that is left is kept as what the answer says."""
        with refusals():
            return {"left": live_map.begin(None)}

    return router


@contextmanager
def refusals() -> Iterator[None]:
    """Errors as answers."""
    try:
        yield
    except (ConfigError, MapError) as error:
        raise HTTPException(409, str(error)) from error
    except VizbotError as error:
        raise HTTPException(503, str(error)) from error
