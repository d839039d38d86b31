"""Files of Sweet Home 3D as worlds.

The level nearest to the ground is taken, as it is drawn. Doors inside the home stand open, those
that lead out of it are closed, and windows show a picture of outdoors. The tops of sloping walls
are level, floors have no holes, and pieces without a class of ours are structure.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furniture.catalogue import CLASSES
from sim_stubs.homes.geometry.extent import require_home_sized
from sim_stubs.homes.geometry.house import House, Instance, Room
from sim_stubs.homes.geometry.occupancy_slice import PASSAGE, FreeSpace
from sim_stubs.homes.geometry.solids import Piece, by_material
from sim_stubs.homes.sweet_home.models import Opening, load_listed
from sim_stubs.homes.sweet_home.plan import (
    HomeFile,
    ListedPiece,
    ground_level,
    list_pieces,
    metres,
    open_home_file,
    plain_name,
    point,
)
from sim_stubs.homes.sweet_home.shell import (
    OUTDOORS,
    ceiling_height,
    floors,
    room_name,
    samples,
    shell,
)
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import THINGS, class_of

LIT = 5.0
"""Least area of a room with a lamp [m^2]: lamps of other rooms shine through walls."""
BESIDE = 0.45
"""Distance from the middle of a wall with a door at which the rooms beside it are looked up [m]."""
_TOLD = re.compile("window|door|hatch|frame")
DOOR_SILL = 0.2
"""Height of a sill below which an opening is a door [m]."""


LOW = 0.6
"""Height below which a table is a coffee table [m]."""

_TABLES = ("table", "round table", "square table", "oval table", "rectangular table")
_UNTOLD = ("box",)
"""Names without meaning: owners build everything else from blocks."""
_NAMES: Mapping[str, str] = {
    "chest": "chest of drawers",
    "clothes washer": "washing machine",
    "corner bunk bed": "bunk bed",
    "corner sofa": "sofa",
    "curve staircase": "stairs",
    "electric radiator": "radiator",
    "fitted bath": "bathtub",
    "flat tv": "tv",
    "floor uplight": "floor lamp",
    "fridge & freezer": "refrigerator",
    "fridge freezer": "refrigerator",
    "hood": "range hood",
    "hot water radiator": "radiator",
    "kitchen upper cabinet": "wall cabinet",
    "pendant lamp": "ceiling lamp",
    "spiral staircase": "stairs",
    "toilet unit": "toilet",
    "tv unit": "tv stand",
    "wall uplight": "wall lamp",
    "washbasin with cabinet": "sink",
    "work lamp": "table lamp",
}
"""Names in the program's own catalogue that differ from our classes."""


def label_of(item: ListedPiece) -> str | None:
    """The class of a piece; None without one, as for beams, pipes and blocks."""
    for name in (plain_name(item.name), item.catalogue_name):
        if name in _TABLES:
            return "coffee table" if item.size[2] < LOW else "dining table"
        if name in _NAMES:
            return _NAMES[name]
        label = class_of(name)
        if label in THINGS and label not in _UNTOLD:
            return label
        fitting = (label for label, rule in CLASSES.items() if rule.fits("", name, item.size[2]))
        if (label := next(fitting, None)) is not None:
            return label
    return None


def read_home(path: Path) -> House:
    """The home in a `.sh3d` file, or an example in the program itself: `sweethome3d.jar/Studio`.

    The robot starts where the largest connected part of its rooms is widest.

    Raises:
        ConfigError: it cannot be read, or leaves the robot no free floor.
    """
    with open_home_file(path) as home:
        try:
            house = _house(home)
        except KeyError as error:
            raise ConfigError(f"world {path}: the plan cannot be read ({error!r})") from error
        except ValueError as error:
            raise ConfigError(f"world {path}: the plan cannot be read ({error})") from error
    start = None if house is None else widest_start(house)
    if house is None or start is None:
        raise ConfigError(f"world {path} has no room with free floor; draw rooms, move furniture")
    return replace(house, start=start)


def _house(home: HomeFile) -> House | None:
    """Everything but the start; None without rooms."""
    level = ground_level(home.plan)
    height = ceiling_height(home.plan, level)
    items = [item for item in list_pieces(home.plan, level) if item.elevation < height - 0.01]
    drawn = floors(home.plan, level)
    if not drawn:
        return None
    require_home_sized(_reached(home.plan, level, [room for room, _ in drawn], items))
    rooms = [_named(room, items) for room, _ in drawn]
    structure = shell(home, level, drawn, [item for item in items if item.is_opening])
    licence = _licence(home.plan)
    pieces: dict[tuple[ListedPiece, Opening | None], Piece] = {}
    count: Counter[str] = Counter()
    instances = []
    for item in items:
        opening = _opening(item, rooms)
        label = label_of(item) if opening is None else _OPENINGS[opening]
        # Equal pieces are one, which the renderer stores once; each window has a view of its own.
        here = (item.x, item.y) if opening == "window" else (0.0, 0.0)
        key = (replace(item, x=here[0], y=here[1], yaw=0.0, elevation=0.0), opening)
        if key not in pieces:
            pieces[key] = load_listed(home, item, label or "structure", licence, opening)
        piece = pieces[key]
        count[piece.label] += 1
        name = f"{piece.label}#{count[piece.label]}"
        instance = Instance(name, piece, item.x, item.y, item.yaw, item.elevation)
        if label is None:
            structure += instance.parts()
        else:
            instances.append(instance)
    lights = _lamps(rooms, height)
    return House(tuple(rooms), by_material(structure), tuple(instances), lights, (0.0, 0.0, 0.0))


_OPENINGS: Mapping[Opening, str | None] = {
    "window": "window",
    "closed door": "door",
    "open door": None,
}


def _reached(
    plan: Element, level: str | None, rooms: Sequence[Room], items: Sequence[ListedPiece]
) -> NDArray[np.float64]:
    """Points (N, 2) on the plan that the home does not reach beyond, or not far [m]."""
    sides = np.array([[-0.5], [0.5]])
    walls = [wall for wall in plan.iter("wall") if wall.get("level", level) == level]
    return np.concatenate(
        [
            *(room.polygon for room in rooms),
            *((item.x, item.y) + sides * max(item.size) for item in items),
            *(
                point(wall, f"x{end}", f"y{end}") + sides * metres(wall, "thickness", 0.1)
                for wall in walls
                for end in ("Start", "End")
            ),
        ]
    )


def _named(room: Room, items: Sequence[ListedPiece]) -> Room:
    """The room with the name that we use."""
    labels = [label_of(item) for item in items if room.contains(item.x, item.y)]
    return replace(room, name=room_name(room.name, [label for label in labels if label]))


def _opening(item: ListedPiece, rooms: Sequence[Room]) -> Opening | None:
    """How a door or window is shown; None for one that is open already, and for furniture."""
    if not item.is_opening:
        return None
    words = next((w for w in (plain_name(item.name), item.catalogue_name) if _TOLD.search(w)), "")
    beside = [item.wall_centre + side * BESIDE * item.facing for side in (-1, 1)]
    indoors = all(_is_indoors(x, y, rooms) for x, y in beside)
    if "frame" in words or "hatch" in words:
        return None
    if "window" in words and not (indoors and item.elevation < DOOR_SILL):
        return "window"
    return "open door" if indoors and "front" not in words else "closed door"


def _is_indoors(x: float, y: float, rooms: Sequence[Room]) -> bool:
    return any(room.contains(x, y) and _is_home(room) for room in rooms)


def _is_home(room: Room) -> bool:
    """Whether a room is no terrace, balcony, ..."""
    return OUTDOORS.fullmatch(room.name) is None


def _licence(plan: Element) -> str:
    properties = {child.get("name"): child.get("value") for child in plan.findall("property")}
    return properties.get("License") or "licence not stated"


def _lamps(rooms: Sequence[Room], height: float) -> NDArray[np.float64]:
    """(N, 3) a lamp under the ceiling of every room of some size, where it is widest."""
    inside = [room for room in rooms if _is_home(room)]
    lit = [room for room in inside if _area(room) > LIT] or inside[:1]
    return np.array([(*_widest(room), height - 0.2) for room in lit]).reshape(-1, 3)


def _area(room: Room) -> float:
    return float(cv2.contourArea(room.polygon.astype(np.float32)))


def _widest(room: Room) -> tuple[float, float]:
    """The point farthest from the outline, to about a quarter of a metre."""
    outline = room.polygon.astype(np.float32)
    points = samples(room)
    distances = [cv2.pointPolygonTest(outline, (x, y), True) for x, y in points]
    x, y = points[int(np.argmax(distances))]
    return float(x), float(y)


def widest_start(house: House) -> tuple[float, float, float] | None:
    """x, y [m] and yaw [rad] of the robot; None where it fits in no room.

    A house without rooms is one room.
    """
    space = FreeSpace.from_house(house)
    _, regions = cv2.connectedComponents((space.clear > PASSAGE).astype(np.uint8), connectivity=4)
    indoors = np.full(space.grid.shape, not house.rooms)
    for room in house.rooms:
        if _is_home(room):
            indoors |= space.inside(room)
    sizes = np.bincount(regions[indoors], minlength=2)
    sizes[0] = 0  # what is not free
    if not sizes.any():
        return None
    here = indoors & (regions == int(np.argmax(sizes)))
    row, column = np.unravel_index(np.argmax(np.where(here, space.clear, 0.0)), here.shape)
    x, y = space.grid.pixels_to_xy(np.array([column, row]))
    return float(x), float(y), 0.0
