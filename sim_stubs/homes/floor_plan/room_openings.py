"""Doorways, windows and the outer door of a home, put into the walls of its rooms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sim_stubs.homes.floor_plan.room_layout import WALL, Rectangle
from sim_stubs.homes.floor_plan.walls import Opening
from sim_stubs.homes.geometry.solids import Surface
from sim_stubs.homes.textures.surfaces import finish

Random = np.random.Generator
Bounds = tuple[float, float, float, float]

CORNER = 0.14
"""Least distance of an opening from a corner: its frame needs that much [m]."""
OUTER_WALL = 0.2
"""Thickness [m]."""
OUTLOOK = 2.0
"""Free distance in front of a window [m]."""
WINDOWS = {
    "living room": (2, 1.3, 2.4),
    "kitchen": (1, 0.9, 1.6),
    "bathroom": (1, 0.5, 0.8),
    "bedroom": (2, 1.0, 1.8),
    "kid's room": (2, 1.0, 1.7),
    "laundry room": (1, 0.5, 0.8),
    "study": (1, 1.0, 1.8),
    "hallway": (1, 0.6, 0.9),
}
"""The most windows in a room, and their least and largest width [m]."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """A piece of wall with nothing or a room behind it, as thick as the wall.

    Attributes:
        x0: West end [m].
        y0: South end [m].
        x1: East end [m].
        y1: North end [m].
        along: Whether it goes along "x" or "y".
    """

    x0: float
    y0: float
    x1: float
    y1: float
    along: str

    @property
    def length(self) -> float:
        """Length of the wall [m]."""
        return self.x1 - self.x0 if self.along == "x" else self.y1 - self.y0

    def cut(self, at: float, width: float) -> Bounds:
        """West, south, east and north edge of a hole that begins `at` from its low end."""
        if self.along == "x":
            return self.x0 + at, self.y0, self.x0 + at + width, self.y1
        return self.x0, self.y0 + at, self.x1, self.y0 + at + width


def shared_wall(one: Rectangle, other: Rectangle) -> Stretch | None:
    """The wall between two rooms; None where they are no neighbours."""
    dx, dy = one.gap(other)
    if abs(dx - WALL) < 0.01 and dy < 0:
        x = min(one.x1, other.x1)
        return Stretch(x, max(one.y0, other.y0), x + dx, min(one.y1, other.y1), "y")
    if abs(dy - WALL) < 0.01 and dx < 0:
        y = min(one.y1, other.y1)
        return Stretch(max(one.x0, other.x0), y, min(one.x1, other.x1), y + dy, "x")
    return None


def outer_walls(
    room: Rectangle, rooms: Sequence[Rectangle], outlook: float = OUTLOOK
) -> list[Stretch]:
    """Stretches of a room's walls before which, for `outlook` metres, nothing is built."""
    stretches = []
    for side in "NESW":
        low, high = (room.x0, room.x1) if side in "NS" else (room.y0, room.y1)
        blocked = []
        for other in rooms:
            dx, dy = room.gap(other)
            away, beside = (dy, dx) if side in "NS" else (dx, dy)
            behind = {
                "N": other.y0 > room.y1,
                "S": other.y1 < room.y0,
                "E": other.x0 > room.x1,
                "W": other.x1 < room.x0,
            }[side]
            if behind and away < outlook and beside < 2 * WALL:
                ends = (other.x0, other.x1) if side in "NS" else (other.y0, other.y1)
                blocked.append((ends[0] - 2 * WALL, ends[1] + 2 * WALL))
        for a, b in _left_over(low, high, blocked):
            stretches.append(
                {
                    "N": Stretch(a, room.y1, b, room.y1 + OUTER_WALL, "x"),
                    "S": Stretch(a, room.y0 - OUTER_WALL, b, room.y0, "x"),
                    "E": Stretch(room.x1, a, room.x1 + OUTER_WALL, b, "y"),
                    "W": Stretch(room.x0 - OUTER_WALL, a, room.x0, b, "y"),
                }[side]
            )
    return stretches


def passage(wall: Stretch, height: float) -> Opening:
    """A wall left out from end to end and up to the ceiling."""
    return Opening(*_rounded(wall.cut(0.0, wall.length)), head=height)


def doorway(rng: Random, wall: Stretch, keep_clear: Sequence[Bounds]) -> Opening | None:
    """A doorway 0.8 to 1 m wide, mostly near an end of the wall; None where none has room."""
    width = min(float(rng.uniform(0.8, 1.0)), wall.length - 2 * CORNER)
    if width < 0.8:
        return None
    spare = max(wall.length - width, 2 * CORNER)  # rounding may take it below
    for _ in range(12):
        near = rng.random() < 0.75
        at = min(CORNER + rng.uniform(0, 0.35), spare - CORNER) if near else rng.uniform(
            CORNER, spare - CORNER
        )  # fmt: skip
        if rng.random() < 0.5:
            at = spare - at
        hole = _rounded(wall.cut(float(at), width))
        if not any(_touch(hole, bounds, 0.15) for bounds in keep_clear):
            return Opening(*hole, head=float(rng.choice([2.0, 2.05, 2.1])))
    return None


def wide_passage(rng: Random, wall: Stretch, keep_clear: Sequence[Bounds]) -> Opening | None:
    """An opening 1.4 to 2.4 m wide between kitchen and living room."""
    width = min(float(rng.uniform(1.4, 2.4)), wall.length - 2 * CORNER)
    if width < 1.3:
        return None
    farthest = max(CORNER, wall.length - width - CORNER)  # rounding may take it below
    hole = _rounded(wall.cut(float(rng.uniform(CORNER, farthest)), width))
    if any(_touch(hole, bounds, 0.15) for bounds in keep_clear):
        return None
    return Opening(*hole, head=float(rng.uniform(2.1, 2.3)))


def outer_door(
    rng: Random, halls: Sequence[Rectangle], rooms: Sequence[Rectangle], leaf: Surface
) -> Opening | None:
    """The closed door at an end of the hallway, else in one of its outer walls."""
    width = float(rng.uniform(0.88, 0.95))
    walls = [
        wall
        for hall in halls
        for wall in outer_walls(hall, rooms, 1.2)
        if wall.length >= width + 2 * CORNER - 0.02
    ]
    if not walls:
        return None
    wall = min(walls, key=lambda w: w.length + rng.uniform(0, 0.5))
    at = (wall.length - width) * 0.5 if wall.length < 2 else wall.length - width - CORNER
    return Opening(*_rounded(wall.cut(at, width)), head=2.05, pane=leaf, kind="door")


def windows(
    rng: Random,
    rooms: Sequence[Rectangle],
    keep_clear: Sequence[Bounds],
    held_out: bool,
) -> list[Opening]:
    """Windows in the outer walls: one at least wherever a room has a wall for it."""
    openings = []
    for room in rooms:
        if room.name == "stairs" or rng.random() < _blind(room.name):
            continue
        most, least, largest = WINDOWS[room.name]
        walls = [w for w in outer_walls(room, rooms) if w.length >= least + 2 * CORNER]
        sill = 0.95 if room.name in ("kitchen", "bathroom") else float(rng.uniform(0.3, 0.95))
        head = float(rng.uniform(2.05, 2.2))
        for index in rng.permutation(len(walls))[: int(rng.integers(1, most + 1))]:
            wall = walls[int(index)]
            width = min(float(rng.uniform(least, largest)), wall.length - 2 * CORNER)
            spare = wall.length - width
            at = float(np.clip(rng.normal(spare / 2, 0.3), CORNER, spare - CORNER))
            hole = _rounded(wall.cut(at, width))
            if any(_touch(hole, bounds, 0.1) for bounds in keep_clear):
                continue
            view = finish("outdoors", rng, held_out).surface
            openings.append(Opening(*hole, sill, head, view, "window"))
    return openings


def _blind(name: str) -> float:
    """Share of rooms without a window."""
    return {"bathroom": 0.3, "laundry room": 0.5, "hallway": 0.75}.get(name, 0.0)


def _left_over(
    low: float, high: float, blocked: Sequence[tuple[float, float]]
) -> list[tuple[float, float]]:
    """The parts of an interval that others do not cover."""
    free, at = [], low
    for a, b in sorted(blocked):
        if a > at:
            free.append((at, min(a, high)))
        at = max(at, b)
    if at < high:
        free.append((at, high))
    return [(a, b) for a, b in free if b - a > 0.3]


def _touch(one: Bounds, other: Bounds, margin: float) -> bool:
    """Whether two rectangles come closer than `margin`."""
    return (
        one[0] < other[2] + margin
        and one[2] > other[0] - margin
        and one[1] < other[3] + margin
        and one[3] > other[1] - margin
    )


def _rounded(bounds: Bounds) -> Bounds:
    a, b, c, d = (round(value, 3) for value in bounds)
    return a, b, c, d
