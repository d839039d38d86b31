"""Routes of the API about maps: places, keep-out zones, saved maps."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import numpy as np
from fastapi import APIRouter, Query, Response

from vizbot.operator.api.answers import (
    DeletedMap,
    LeftMap,
    ListedMap,
    MapNames,
    MapSaved,
    NamedRoom,
    PlacesAnswer,
    RenamedMap,
    RoomsAnswer,
    VocabularyAnswer,
    ZoneCount,
    ZonesAnswer,
)
from vizbot.operator.api.errors import WITH_BODY, error_responses
from vizbot.operator.api.image_stream import picture_answer, picture_response
from vizbot.operator.api.requests import (
    RenameMapRequest,
    SaveMapRequest,
    Words,
    ZoneRequest,
    ZonesRequest,
)
from vizbot.operator.figures.image_encoding import jpeg
from vizbot.operator.figures.panels import thumbnail
from vizbot.operator.session.live_map import LiveMap

_BUSY = error_responses(409, 503)
_QUERY = error_responses(409, 422, 503)
_CHANGE = error_responses(409, 503, *WITH_BODY)
_NAMED = error_responses(409)


def map_router(live_map: LiveMap) -> APIRouter:
    """The routes about the maps of a robot."""
    router, saved = APIRouter(tags=["map"]), APIRouter(tags=["saved maps"])
    both = APIRouter()

    @router.get("/map/places", summary="Ask the map", responses=_QUERY)
    def places(text: Annotated[Words, Query()]) -> PlacesAnswer:
        """Find on the map, as it is now, what these words ask for."""
        answer = live_map.places(text)
        return PlacesAnswer(**asdict(answer), summary=live_map.summary(answer))

    @router.get("/map/vocabulary", summary="List what the map finds", responses=_BUSY)
    def vocabulary() -> VocabularyAnswer:
        """List the usual things and rooms of a household that the map finds."""
        return VocabularyAnswer(phrases=live_map.vocabulary())

    @router.get("/map/rooms", summary="List rooms", responses=_BUSY)
    def rooms() -> RoomsAnswer:
        """List what the map most probably shows of each kind of room; up to ten seconds old."""
        return RoomsAnswer(rooms=[NamedRoom(**asdict(each)) for each in live_map.rooms()])

    @router.get("/map/keep-out", summary="List keep-out zones", responses=_BUSY)
    def zones() -> ZonesAnswer:
        """List the zones that the robot does not enter by itself."""
        return ZonesAnswer(zones=[zone.tolist() for zone in live_map.keep_out()])

    @router.put("/map/keep-out", summary="Replace keep-out zones", responses=_CHANGE)
    def replace_zones(zones: ZonesRequest) -> ZoneCount:
        """Keep the robot out of these zones and no others. Driving by hand ignores zones."""
        live_map.set_keep_out([np.array(corners, np.float32) for corners in zones.zones])
        return ZoneCount(zones=len(zones.zones))

    @router.post("/map/keep-out", summary="Add a keep-out zone", responses=_CHANGE)
    def add_zone(zone: ZoneRequest) -> ZoneCount:
        """Keep the robot out of one more zone; zones that others add meanwhile stay."""
        return ZoneCount(zones=live_map.add_zone(np.array(zone.corners, np.float32)))

    @router.delete("/map/keep-out", summary="Remove a keep-out zone", responses=_CHANGE)
    def remove_zone(zone: ZoneRequest) -> ZoneCount:
        """Let the robot into the zone that has these corners."""
        return ZoneCount(zones=live_map.remove_zone(np.array(zone.corners, np.float32)))

    @saved.get("/maps", summary="List saved maps")
    def names() -> MapNames:
        """List the saved maps: their names, when they were saved, which ones robots are in."""
        maps = [ListedMap(**asdict(each)) for each in live_map.saved.maps()]
        return MapNames(names=[each.name for each in maps], maps=maps)

    @saved.get(
        "/maps/{name}/picture.jpg",
        summary="Read the picture of a saved map",
        response_class=Response,
        responses={200: picture_response("Its floor plan."), **error_responses(409)},
    )
    def map_picture(name: str) -> Response:
        """Read a small floor plan of a saved map: walls are dark, keep-out zones red."""
        return picture_answer(jpeg(thumbnail(live_map.saved.grid(name))))

    @saved.put("/maps/{name}", summary="Save the map", responses=_CHANGE)
    def save(name: str, options: SaveMapRequest) -> MapSaved:
        """Save the map as it is now."""
        live_map.save(name, replace=options.replace)
        return MapSaved(saved=name)

    @saved.post("/maps/{name}/begin", summary="Change to a saved map", responses=_BUSY)
    def begin_saved(name: str) -> LeftMap:
        """Leave the map, which is saved, and go on in another saved one.

        A map that cannot be saved is refused once (409), and lost where this is asked once more.
        Positions in the run's folder refer to the axes of the new map from then on.
        """
        return LeftMap(left=live_map.begin(name))

    @saved.post("/maps/{name}/rename", summary="Rename a saved map", responses=_CHANGE)
    def rename(name: str, request: RenameMapRequest) -> RenamedMap:
        """Give a saved map another name, which no other map may have."""
        live_map.rename(name, request.name)
        return RenamedMap(renamed=request.name)

    @saved.delete("/maps/{name}", summary="Delete a saved map", responses=_NAMED)
    def delete(name: str) -> DeletedMap:
        """Delete a saved map; one that a robot is in stays."""
        live_map.delete(name)
        return DeletedMap(deleted=name)

    @saved.post("/map/new", summary="Change to an empty map", responses=_BUSY)
    def begin_empty() -> LeftMap:
        """Leave the map, which is saved, and begin an empty one.

        A map that cannot be saved is refused once (409), and lost where this is asked once more.
        """
        return LeftMap(left=live_map.begin(None))

    for each in (router, saved):
        both.include_router(each)
    return both
