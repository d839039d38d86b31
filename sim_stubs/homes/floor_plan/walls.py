"""Walls, floors, ceilings and openings of rectangular rooms, as meshes in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.geometry.bounding_block import Block, wall_span
from sim_stubs.homes.geometry.house import Room
from sim_stubs.homes.geometry.solids import Part, Surface, box, by_material, flat_panel

CEILING = (0.93, 0.93, 0.92)
TRIM = (0.90, 0.90, 0.88)
"""Skirting boards and door frames."""
THRESHOLD = (0.35, 0.24, 0.17)


def wall_of(opening: Opening, room: Block) -> str | None:
    """Direction that the wall of `room` with this opening faces; None where it is in none."""
    hole = Block(opening.x0, opening.y0, opening.x1, opening.y1)
    near = 0.02
    for facing, distance in (
        ("N", abs(hole.y1 - room.y0)),
        ("S", abs(hole.y0 - room.y1)),
        ("E", abs(hole.x1 - room.x0)),
        ("W", abs(hole.x0 - room.x1)),
    ):
        start, end = (hole.x0, hole.x1) if facing in "NS" else (hole.y0, hole.y1)
        low, high = wall_span(room, facing)
        if distance < near and start >= low - near and end <= high + near:
            return facing
    return None


def before_opening(hole: Block, room: Block, facing: str, depth: float) -> Block:
    """The floor of the room in front of an opening."""
    match facing:
        case "N":
            return Block(hole.x0, room.y0, hole.x1, room.y0 + depth)
        case "S":
            return Block(hole.x0, room.y1 - depth, hole.x1, room.y1)
        case "E":
            return Block(room.x0, hole.y0, room.x0 + depth, hole.y1)
        case _:
            return Block(room.x1 - depth, hole.y0, room.x1, hole.y1)


@dataclass(frozen=True, slots=True)
class Opening:
    """A hole through a wall, as a block as thick as the wall.

    Attributes:
        x0: West end [m].
        y0: South end [m].
        x1: East end [m].
        y1: North end [m].
        sill: Height of its lower edge [m].
        head: Height of its upper edge [m]; at the ceiling's the opening has neither frame nor
            threshold, as if there were no wall.
        pane: What closes it: a picture of outdoors for a window, a door leaf's surface for the
            closed outer door; None for an open doorway.
        kind: "doorway" between rooms, "window", or "door" for the closed outer one.
    """

    x0: float
    y0: float
    x1: float
    y1: float
    sill: float = 0.0
    head: float = 2.05
    pane: Surface | None = None
    kind: Literal["doorway", "window", "door"] = "doorway"


@dataclass(frozen=True, slots=True)
class RectangularRoom:
    """A rectangular room to be built, by its inner faces.

    Attributes:
        name: "kitchen", "hallway", ...
        x0: West wall [m].
        y0: South wall [m].
        x1: East wall [m].
        y1: North wall [m].
        floor: Surface of the floor.
        floor_tile: Edge of the floor's texture [m].
        wall: Surface of the walls.
        wall_tile: Edge of the walls' texture [m].
        ceiling: Surface of the ceiling.
    """

    name: str
    x0: float
    y0: float
    x1: float
    y1: float
    floor: Surface
    floor_tile: float
    wall: Surface
    wall_tile: float = 2.5
    ceiling: Surface = CEILING

    @property
    def polygon(self) -> NDArray[np.float64]:
        """(4, 2) corners on the plan [m], counter-clockwise."""
        x0, y0, x1, y1 = self.x0, self.y0, self.x1, self.y1
        return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])

    @property
    def room(self) -> Room:
        """The room with its name and floor."""
        return Room(self.name, self.polygon)


def build_structure(
    rooms: Sequence[RectangularRoom],
    openings: Sequence[Opening],
    height: float = 2.5,
    stairs: Stairs | None = None,
) -> tuple[Part, ...]:
    """Floors, ceilings and walls, with every opening cut into the walls it touches.

    Stairs that lead down get their hole in the floor. Parts are joined by material within a room,
    never across rooms, so that each covers a small part of the plan.
    """
    parts: list[Part] = []
    for room in rooms:
        of_room = [_ceiling(room, height), *_floor(room, stairs)]
        corners = room.polygon
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            of_room += _wall(start, end, room, openings, height)
        for opening in openings:
            neighbours = [other for other in rooms if _beside(opening, other)]
            if neighbours and neighbours[0] is room:
                of_room += _reveal(opening, neighbours, height)
        parts += by_material(of_room)
    return tuple(parts)


def _ceiling(room: RectangularRoom, height: float) -> Part:
    size = (room.x1 - room.x0, room.y1 - room.y0)
    return flat_panel((room.x0, room.y0, height), (0, size[1], 0), (size[0], 0, 0), room.ceiling)


def _floor(room: RectangularRoom, stairs: Stairs | None) -> list[Part]:
    """The floor, around the hole for stairs that lead down."""
    x0, y0, x1, y1 = room.x0, room.y0, room.x1, room.y1
    fields = [(x0, y0, x1, y1)]
    if stairs is not None and stairs.kind == "down":
        a, b, c, d = stairs.bounds
        a, b, c, d = max(a, x0), max(b, y0), min(c, x1), min(d, y1)
        if a < c and b < d:
            fields = [(x0, y0, x1, b), (x0, d, x1, y1), (x0, b, a, d), (c, b, x1, d)]
    parts = []
    for a, b, c, d in fields:
        if c - a < 1e-6 or d - b < 1e-6:
            continue
        part = flat_panel((a, b, 0), (c - a, 0, 0), (0, d - b, 0), room.floor, room.floor_tile)
        # The pattern goes on around the hole.
        shift = np.array([a - x0, y0 - b], np.float32) / np.float32(room.floor_tile)
        parts.append(replace(part, texcoords=part.texcoords + shift))
    return parts


def _beside(opening: Opening, room: RectangularRoom) -> bool:
    """Whether an opening leads into a room."""
    slack = 1e-6
    return (
        opening.x0 <= room.x1 + slack
        and opening.x1 >= room.x0 - slack
        and opening.y0 <= room.y1 + slack
        and opening.y1 >= room.y0 - slack
    )


def _wall(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    room: RectangularRoom,
    openings: Sequence[Opening],
    height: float,
) -> list[Part]:
    """One wall with its skirting; the room lies to the left on the way from start to end."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    inwards = np.array([-along[1], along[0]])
    holes = []
    for opening in openings:
        spans = (np.array([[opening.x0, opening.y0], [opening.x1, opening.y1]]) - start) @ (
            np.column_stack([along, inwards])
        )
        (a, b), (near, far) = sorted(spans[:, 0]), sorted(spans[:, 1])
        if near - 1e-6 <= 0 <= far + 1e-6 and a > -1e-6 and b < length + 1e-6 and b - a > 0.3:
            holes.append((float(a), float(b), opening.sill, opening.head))

    parts: list[Part] = []

    def cover(a: float, b: float, z0: float, z1: float) -> None:
        if b - a < 1e-6 or z1 - z0 < 1e-6:
            return
        corner, leftwards = (*(start + b * along), z0), (*(along * (a - b)), 0)
        part = flat_panel(corner, leftwards, (0, 0, z1 - z0), room.wall, room.wall_tile)
        # The pattern goes on around openings.
        shift = np.array([length - b, -z0], np.float32) / np.float32(room.wall_tile)
        parts.append(replace(part, texcoords=part.texcoords + shift))
        if z0 == 0.0:
            middle = start + along * (a + b) / 2 + inwards * 0.006
            size = np.abs(along * (b - a)) + np.abs(inwards) * 0.012
            parts.append(box((*middle, 0), (*size, 0.08), TRIM))

    at = 0.0
    for a, b, sill, head in sorted(holes):
        cover(at, a, 0.0, height)
        cover(a, b, 0.0, sill)
        cover(a, b, head, height)
        if head < height:
            parts += _frame(start + a * along, start + b * along, inwards, sill, head)
        at = b
    cover(at, length, 0.0, height)
    return parts


def _frame(
    left: NDArray[np.float64],
    right: NDArray[np.float64],
    inwards: NDArray[np.float64],
    sill: float,
    head: float,
) -> list[Part]:
    """Trim around an opening, on the wall."""
    along = (right - left) / np.linalg.norm(right - left)
    width, thick = 0.06, np.abs(inwards) * 0.02
    parts = []
    for corner, way in ((left, -1.0), (right, 1.0)):
        middle = corner + along * way * width / 2 + inwards * 0.01
        post = (*(np.abs(along) * width + thick), head + width - sill)
        parts.append(box((*middle, sill), post, TRIM))
    middle, span = (left + right) / 2 + inwards * 0.01, np.abs(right - left) + thick
    parts.append(box((*middle, head), (*span, width), TRIM))
    if sill > 0:
        parts.append(box((*middle, sill - width), (*span, width), TRIM))
    return parts


def _reveal(opening: Opening, neighbours: Sequence[RectangularRoom], height: float) -> list[Part]:
    """The inside of an opening: jambs, head, threshold or sill, and what closes it."""
    x0, y0, x1, y1, z0, z1 = (
        opening.x0, opening.y0, opening.x1, opening.y1, opening.sill, opening.head
    )  # fmt: skip
    east, north, up = (x1 - x0, 0, 0), (0, y1 - y0, 0), (0, 0, z1 - z0)
    through_y = x1 - x0 > y1 - y0
    room = neighbours[0]
    passage = z1 >= height  # as if there were no wall
    jamb, tile = (room.wall, room.wall_tile) if passage else (TRIM, 1.0)
    if passage:
        parts = [
            flat_panel((x0, y0, z0), east, north, room.floor, room.floor_tile),
            flat_panel((x0, y0, z1), north, east, room.ceiling),
        ]
    else:
        below = THRESHOLD if z0 == 0 else TRIM
        parts = [
            flat_panel((x0, y0, z0), east, north, below),
            flat_panel((x0, y0, z1), north, east, TRIM),
        ]
    if through_y:
        parts.append(flat_panel((x0, y0, z0), north, up, jamb, tile))
        parts.append(flat_panel((x1, y1, z0), (0, y0 - y1, 0), up, jamb, tile))
    else:
        parts.append(flat_panel((x1, y0, z0), (x0 - x1, 0, 0), up, jamb, tile))
        parts.append(flat_panel((x0, y1, z0), east, up, jamb, tile))
    if opening.pane is not None:
        share = 0.5
        if opening.kind == "window":
            # The view hangs at the outer face; what stands in the opening is in front of it.
            share = 0.98 if _beside_low_face(opening, room, through_y) else 0.02
        if through_y:
            y = y0 + share * (y1 - y0)
            parts.append(flat_panel((x0, y, z0), east, up, opening.pane, tile=0))
            parts.append(flat_panel((x1, y, z0), (x0 - x1, 0, 0), up, opening.pane, tile=0))
        else:
            x = x0 + share * (x1 - x0)
            parts.append(flat_panel((x, y0, z0), north, up, opening.pane, tile=0))
            parts.append(flat_panel((x, y1, z0), (0, y0 - y1, 0), up, opening.pane, tile=0))
    return parts


def _beside_low_face(opening: Opening, room: RectangularRoom, through_y: bool) -> bool:
    """Whether the room lies south or west of the opening."""
    if through_y:
        return room.y0 < opening.y0
    return room.x0 < opening.x0
