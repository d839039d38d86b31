"""From the plan of a Sweet Home 3D home to its shell: rooms, floors, ceilings, walls."""

from __future__ import annotations

import re
import zlib
from collections.abc import Callable, Collection, Sequence
from math import pi
from pathlib import Path
from xml.etree.ElementTree import Element

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from sim_stubs.homes.geometry.house import Room
from sim_stubs.homes.geometry.solids import WHITE, Part, flat_panel
from sim_stubs.homes.sweet_home.plan import (
    HomeFile,
    ListedPiece,
    SurfaceStyle,
    look,
    metres,
    plain_name,
    point,
)
from sim_stubs.homes.sweet_home.walls import Hole, Skirting, Wall, WallFinish, build_walls, rounded
from sim_stubs.homes.textures import canvas, finishes
from vizbot.core.home_vocabulary import class_of

OUTDOORS = re.compile(r".*(terrace|balcony|garden|patio|porch|veranda|roof|garage).*")
"""Names of places with a floor that are no part of the home."""
_NAMES = (
    (r"bedr.*|.*bedroom", "bedroom"),
    (r"bath.*|.*bathroom|wc|toilets?|shower.*", "bathroom"),
    (r"living.*|lounge", "living room"),
    (r"kitchen.*", "kitchen"),
    (r"corridor|hall|entrance.*|entry|landing", "hallway"),
    (r"laundry", "laundry room"),
    (r"kids?('s)?( room)?|child.*", "kid's room"),
)
_BY_FURNITURE = (
    (("toilet", "bathtub", "shower"), "bathroom"),
    (("bed", "single bed", "bunk bed"), "bedroom"),
    (("oven", "refrigerator", "kitchen cabinet"), "kitchen"),
    (("sofa", "tv"), "living room"),
    (("washing machine",), "laundry room"),
    (("desk",), "study"),
)
"""Labels that identify a room without a name; the first match counts."""
CELL = 0.5
"""About the longest edge of a floor's triangles [m]; light is computed at their corners."""
CEILING = WallFinish((0.93, 0.93, 0.92))
FLOOR = SurfaceStyle((0.65, 0.60, 0.52))
WALL = SurfaceStyle((0.90, 0.89, 0.86))
GROUND = (0.55, 0.52, 0.48)
"""Colour of surfaces without a colour in the file."""
BELOW = 0.02
"""Depth of the ground around the rooms below their floors [m]; it also joins the rooms."""
PAINT = 0.92
"""Brightness of white paint."""
PLASTER = 2.5
"""Edge of its texture [m]."""
MAX_PICTURE = 512
"""Longest side of a picture on walls and floors [px]."""
_MOST_ARC = 1.5 * pi
"""Largest angle of a round wall, as the program offers it [rad]."""
Finisher = Callable[[SurfaceStyle], WallFinish]


def room_name(name: str, furniture: Collection[str]) -> str:
    """Our name for a room, from its owner's name, else from the labels of its furniture.

    It is the truth for scoring, and never reaches the robot.
    """
    plain = plain_name(name)
    for pattern, ours in _NAMES:
        if re.fullmatch(pattern, plain):
            return ours
    if plain:
        return class_of(plain) or plain
    return next((ours for labels, ours in _BY_FURNITURE if set(labels) & set(furniture)), "room")


def level_face(room: Room, finish: WallFinish, z: float, *, upwards: bool) -> Part | None:
    """Floor or ceiling of a room at height z [m]; None where its polygon has no area."""
    points = samples(room)
    corners = Delaunay(points).simplices if len(points) > 3 else np.zeros((0, 3), np.int32)
    ahead, aside = np.moveaxis(points[corners[:, 1:]] - points[corners[:, :1]], 1, 0)
    area = ahead[:, 0] * aside[:, 1] - ahead[:, 1] * aside[:, 0]
    centres = points[corners].mean(axis=1)
    inside = np.array([room.contains(x, y) for x, y in centres], np.bool_)
    turned = np.where(((area > 0) == upwards)[:, None], corners, corners[:, ::-1])
    faces = turned[inside & (np.abs(area) > 1e-6)]
    if len(faces) == 0:
        return None
    surface = finish.surface
    return Part(
        vertices=np.column_stack([points, np.full(len(points), z)]).astype(np.float32),
        normals=np.tile(np.array([0, 0, 1 if upwards else -1], np.float32), (len(points), 1)),
        texcoords=(points / (finish.width, -finish.height)).astype(np.float32),
        faces=faces.astype(np.int32),
        rgba=np.array([*(WHITE if isinstance(surface, Path) else surface), 1.0], np.float32),
        texture=surface if isinstance(surface, Path) else None,
    )


def samples(room: Room) -> NDArray[np.float64]:
    """Points (N, 2) along the outline of a room, and a grid inside it [m]."""
    outline = []
    for start, end in zip(room.polygon, np.roll(room.polygon, -1, axis=0), strict=True):
        steps = max(1, round(float(np.linalg.norm(end - start)) / CELL * 2))
        outline.append(np.linspace(start, end, steps, endpoint=False))
    low, high = room.polygon.min(axis=0), room.polygon.max(axis=0)
    x, y = np.meshgrid(*(np.arange(a + CELL / 2, b, CELL) for a, b in zip(low, high, strict=True)))
    grid = np.column_stack([x.ravel(), y.ravel()])
    inside = np.array([room.contains(*at) for at in grid], np.bool_)
    return np.unique(np.round(np.concatenate([*outline, grid[inside]]), 4), axis=0)


def ceiling_height(plan: Element, level: str | None) -> float:
    """Height of the ceiling of a level [m]."""
    home = metres(plan, "wallHeight", 2.5)
    heights = [metres(e, "height", home) for e in plan.iter("level") if e.get("id") == level]
    return heights[0] if heights else home


def floors(plan: Element, level: str | None) -> list[tuple[Room, Element]]:
    """Every room of a level that has a floor, by its owner's name, with its element."""
    found = []
    for element in plan.iter("room"):
        corners = np.array([point(corner) for corner in element.findall("point")])
        visible = element.get("floorVisible") != "false"
        if element.get("level", level) != level or not visible or len(corners) < 3:
            continue
        x, y = corners.T
        twice_area = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
        polygon = corners if twice_area > 0 else corners[::-1].copy()
        found.append((Room(element.get("name") or "", polygon), element))
    return found


def shell(
    home: HomeFile,
    level: str | None,
    rooms: Sequence[tuple[Room, Element]],
    openings: Sequence[ListedPiece],
) -> list[Part]:
    """Ground, floors, ceilings, and walls with holes for the openings.

    Raises:
        KeyError: a picture is not in the file.
    """
    height = ceiling_height(home.plan, level)

    def finish(look: SurfaceStyle) -> WallFinish:
        return _finish(home, look)

    parts = [_ground([room for room, _ in rooms])]
    for room, element in rooms:
        floor = finish(look(element, "floorColor", "floorTexture") or FLOOR)
        for face in (
            level_face(room, floor, 0.0, upwards=True),
            level_face(room, CEILING, height, upwards=False),
        ):
            parts += [] if face is None else [face]
    return parts + build_walls(
        _walls(home.plan, level, height, finish), [_hole(it) for it in openings]
    )


def _ground(rooms: Sequence[Room]) -> Part:
    corners = np.concatenate([room.polygon for room in rooms])
    low, high = corners.min(axis=0) - 1.0, corners.max(axis=0) + 1.0
    width, depth = high - low
    return flat_panel((*low, -BELOW), (width, 0, 0), (0, depth, 0), GROUND, cell=1.0)


def _finish(home: HomeFile, look: SurfaceStyle) -> WallFinish:
    image = None
    if look.image is not None:
        encoded = np.frombuffer(home.archive.read(look.image), np.uint8)
        image = cv2.imdecode(encoded, cv2.IMREAD_COLOR)
    if image is None:
        # Real paint is never quite even; a camera finds its place by that.
        colour = PAINT * np.array(look.rgb or GROUND)
        seed = zlib.crc32(colour.round(3).tobytes())
        return WallFinish(finishes.plaster(seed, colour), PLASTER, PLASTER)
    shrink = min(1.0, MAX_PICTURE / max(image.shape[:2]))
    small = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    return WallFinish(canvas.saved(small[..., ::-1] / 255.0), look.width, look.height)


def _walls(plan: Element, level: str | None, ceiling: float, finish: Finisher) -> list[Wall]:
    """Straight walls; a round one becomes several, joined one to the next."""
    elements = [e for e in plan.iter("wall") if e.get("level", level) == level]
    paths = [
        rounded(
            point(element, "xStart", "yStart"),
            point(element, "xEnd", "yEnd"),
            _arc(element),
        )
        for element in elements
    ]
    first = np.cumsum([0, *(len(path) - 1 for path in paths)])
    by_id = {element.get("id"): index for index, element in enumerate(elements)}

    def joined(index: int, end: str) -> int | None:
        """The nearest piece of the wall that this one is joined to at one end."""
        other = by_id.get(elements[index].get(f"wallAt{end}"))
        if other is None:
            return None
        joint = paths[index][0 if end == "Start" else -1]
        gaps = [float(np.linalg.norm(paths[other][i] - joint)) for i in (0, -1)]
        return int(first[other] if gaps[0] <= gaps[1] else first[other + 1] - 1)

    walls = []
    for index, (element, path) in enumerate(zip(elements, paths, strict=True)):
        height = metres(element, "height", ceiling)
        looks = [
            finish(look(element, f"{side}SideColor", f"{side}SideTexture") or WALL)
            for side in ("left", "right")
        ]
        for step in range(len(path) - 1):
            here = int(first[index]) + step
            walls.append(
                Wall(
                    start=path[step],
                    end=path[step + 1],
                    thickness=metres(element, "thickness", 0.1),
                    height=max(height, metres(element, "heightAtEnd", height)),
                    left=looks[0],
                    right=looks[1],
                    skirtings=(_skirting(element, "left"), _skirting(element, "right")),
                    at_start=joined(index, "Start") if step == 0 else here - 1,
                    at_end=joined(index, "End") if step == len(path) - 2 else here + 1,
                )
            )
    return walls


def _arc(wall: Element) -> float:
    """Angle by which a wall turns [rad]."""
    arc = float(wall.get("arcExtent", 0.0))
    if not abs(arc) <= _MOST_ARC:
        raise ValueError(f"arcExtent is {arc:g} rad, of {_MOST_ARC:g} at most")
    return arc


def _skirting(wall: Element, side: str) -> Skirting | None:
    for board in wall.findall("baseboard"):
        if board.get("attribute") == f"{side}SideBaseboard":
            own = look(board, "color") or look(wall, f"{side}SideColor") or WALL
            colour = own.rgb or GROUND
            return Skirting(metres(board, "thickness"), metres(board, "height"), colour)
    return None


def _hole(item: ListedPiece) -> Hole:
    sill = item.elevation
    depth = item.size[1] * (item.in_wall[1] - item.in_wall[0])
    return Hole(item.wall_centre, item.yaw, item.size[0], depth, sill, sill + item.size[2])
