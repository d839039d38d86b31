"""Walls, floors, ceilings and openings of rectangular rooms, as meshes in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim_stubs.house import Room
from sim_stubs.piece import Part
from sim_stubs.solids import Surface, box, by_material, panel

CEILING = (0.93, 0.93, 0.92)
TRIM = (0.90, 0.90, 0.88)
"""Skirting boards and door frames."""


@dataclass(frozen=True, slots=True)
class Opening:
    """A hole through a wall, as a block as thick as the wall.

    Attributes:
        x0: West end [m].
        y0: South end [m].
        x1: East end [m].
        y1: North end [m].
        sill: Height of its lower edge [m].
        head: Height of its upper edge [m].
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
    """

    name: str
    x0: float
    y0: float
    x1: float
    y1: float
    floor: Surface
    floor_tile: float
    wall: Surface

    @property
    def polygon(self) -> NDArray[np.float64]:
        """(4, 2) corners on the plan [m], counter-clockwise."""
        x0, y0, x1, y1 = self.x0, self.y0, self.x1, self.y1
        return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])

    @property
    def room(self) -> Room:
        """Its name and floor."""
        return Room(self.name, self.polygon)


def build_structure(
    rooms: Sequence[RectangularRoom], openings: Sequence[Opening], height: float = 2.5
) -> tuple[Part, ...]:
    """Floors, ceilings and walls of `rooms`, with every opening cut into the walls it touches."""
    parts: list[Part] = []
    for room in rooms:
        size = (room.x1 - room.x0, room.y1 - room.y0)
        east, north = (size[0], 0, 0), (0, size[1], 0)
        parts.append(panel((room.x0, room.y0, 0), east, north, room.floor, room.floor_tile))
        parts.append(panel((room.x0, room.y0, height), north, east, CEILING))
        corners = room.polygon
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            parts += _wall(start, end, room.wall, openings, height)
    for opening in openings:
        parts += _reveal(opening)
    return by_material(parts)


def _wall(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    surface: Surface,
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
        if near - 1e-6 <= 0 <= far + 1e-6 and a >= 0 and b <= length and b - a > 0.3:
            holes.append((float(a), float(b), opening.sill, opening.head))

    parts: list[Part] = []

    def cover(a: float, b: float, z0: float, z1: float) -> None:
        if b - a < 1e-6 or z1 - z0 < 1e-6:
            return
        corner, leftwards = (*(start + b * along), z0), (*(along * (a - b)), 0)
        parts.append(panel(corner, leftwards, (0, 0, z1 - z0), surface, 2.5))
        if z0 == 0.0:
            middle = start + along * (a + b) / 2 + inwards * 0.006
            size = np.abs(along * (b - a)) + np.abs(inwards) * 0.012
            parts.append(box((*middle, 0), (*size, 0.08), TRIM))

    at = 0.0
    for a, b, sill, head in sorted(holes):
        cover(at, a, 0.0, height)
        cover(a, b, 0.0, sill)
        cover(a, b, head, height)
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


def _reveal(opening: Opening) -> list[Part]:
    """The inside of an opening: jambs, head, threshold or sill, and what closes it."""
    x0, y0, x1, y1, z0, z1 = (
        opening.x0, opening.y0, opening.x1, opening.y1, opening.sill, opening.head
    )  # fmt: skip
    east, north, up = (x1 - x0, 0, 0), (0, y1 - y0, 0), (0, 0, z1 - z0)
    threshold = (0.35, 0.24, 0.17) if z0 == 0 else TRIM
    parts = [
        panel((x0, y0, z0), east, north, threshold),
        panel((x0, y0, z1), north, east, TRIM),
    ]
    through_y = x1 - x0 > y1 - y0
    if through_y:
        parts.append(panel((x0, y0, z0), north, up, TRIM))
        parts.append(panel((x1, y1, z0), (0, y0 - y1, 0), up, TRIM))
    else:
        parts.append(panel((x1, y0, z0), (x0 - x1, 0, 0), up, TRIM))
        parts.append(panel((x0, y1, z0), east, up, TRIM))
    if opening.pane is not None:
        if through_y:
            y = (y0 + y1) / 2
            parts.append(panel((x0, y, z0), east, up, opening.pane, tile=0))
            parts.append(panel((x1, y, z0), (x0 - x1, 0, 0), up, opening.pane, tile=0))
        else:
            x = (x0 + x1) / 2
            parts.append(panel((x, y0, z0), north, up, opening.pane, tile=0))
            parts.append(panel((x, y1, z0), (0, y0 - y1, 0), up, opening.pane, tile=0))
    return parts
