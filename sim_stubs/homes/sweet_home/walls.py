"""Walls of a Sweet Home 3D home: of any direction and thickness, round ones too, joined at corners.

World frame: z up, floor at z = 0. Left and right are those of someone who goes from start to end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import atan2, cos, hypot, pi, sin

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.solids import Part, Surface, flat_panel, meshed

Point = NDArray[np.float64]
CUT = (0.80, 0.80, 0.78)
"""Inside of openings and top of low walls."""
CHORD = 0.10
"""Angle of one straight piece of a round wall [rad]."""


@dataclass(frozen=True, slots=True)
class WallFinish:
    """The finish of a side of a wall or of a floor.

    Attributes:
        surface: PNG file or plain colour.
        width: Width of one copy of the picture [m].
        height: Height of one copy of the picture [m].
    """

    surface: Surface
    width: float = 1.0
    height: float = 1.0

    def covering(self, corner: Point, along: Point, height: float) -> Part:
        """An upright rectangle, seen from the side that `along` x up points to."""
        part = flat_panel(corner, (*along, 0.0), (0.0, 0.0, height), self.surface, self.width)
        stretched = part.texcoords * np.array([1.0, self.width / self.height], np.float32)
        return replace(part, texcoords=stretched)


@dataclass(frozen=True, slots=True)
class Skirting:
    """A board along the foot of a wall.

    Attributes:
        thickness: Thickness [m].
        height: Height of its upper edge [m].
        colour: Red, green, blue in [0, 1].
    """

    thickness: float
    height: float
    colour: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """A straight wall.

    Attributes:
        start: (2,) on its middle line [m].
        end: (2,) on its middle line [m].
        thickness: [m].
        height: [m].
        left: Look of its left side.
        right: Look of its right side.
        skirtings: Skirtings of the left and the right side.
        at_start: Index of the wall that it is joined to there, in the list of all walls.
        at_end: Index of the wall that it is joined to there.
    """

    start: Point
    end: Point
    thickness: float
    height: float
    left: WallFinish
    right: WallFinish
    skirtings: tuple[Skirting | None, Skirting | None] = (None, None)
    at_start: int | None = None
    at_end: int | None = None

    @property
    def length(self) -> float:
        """Length of its middle line [m]."""
        return hypot(*(self.end - self.start))

    @property
    def along(self) -> Point:
        """(2,) unit vector from start to end."""
        return np.asarray((self.end - self.start) / self.length)


@dataclass(frozen=True, slots=True, eq=False)
class Hole:
    """The hole of a door or a window in the walls around it.

    Attributes:
        centre: (2,) middle of the part in the wall [m].
        yaw: Direction of its width [rad].
        width: [m].
        depth: Depth of the part in the wall [m].
        sill: Height of its lower edge [m].
        head: Height of its upper edge [m].
    """

    centre: Point
    yaw: float
    width: float
    depth: float
    sill: float
    head: float


def rounded(start: Point, end: Point, arc: float) -> list[Point]:
    """Points (2,) on an arc from start to end; it turns by `arc` [rad], clockwise if positive."""
    chord = end - start
    if abs(arc) < 1e-3:
        return [start, end]
    middle, left = (start + end) / 2, np.array([-chord[1], chord[0]])
    centre = middle - left / 2 / np.tan(arc / 2)
    radius = hypot(*(start - centre))
    first = atan2(*(start - centre)[::-1])
    steps = max(2, round(abs(arc) / CHORD))
    angles = [first - arc * step / steps for step in range(1, steps)]
    between = [centre + radius * np.array([cos(angle), sin(angle)]) for angle in angles]
    return [start, *between, end]


def build_walls(walls: Sequence[Wall], holes: Sequence[Hole]) -> list[Part]:
    """All walls with the holes cut into those that they touch."""
    return [part for wall in walls if wall.length > 0.01 for part in _built(wall, walls, holes)]


def _built(wall: Wall, walls: Sequence[Wall], holes: Sequence[Hole]) -> list[Part]:
    u = wall.along
    n = np.array([-u[1], u[0]])
    cuts = [cut for hole in holes if (cut := _cut(wall, u, n, hole)) is not None]
    marks = sorted({0.0, wall.length, *(s for cut in cuts for s in cut[:2])})
    start = tuple(_corner(wall, walls, side, at_end=False) for side in (1, -1))
    end = tuple(_corner(wall, walls, side, at_end=True) for side in (1, -1))

    def across(s: float) -> tuple[Point, Point]:
        """Points (2,) of the left and the right side at a length on the middle line."""
        if s == 0.0:
            return start[0], start[1]
        if s == wall.length:
            return end[0], end[1]
        middle = wall.start + u * s
        return middle + n * wall.thickness / 2, middle - n * wall.thickness / 2

    parts: list[Part] = []
    for s0, s1 in pairwise(marks):
        here = [(z0, z1) for a, b, z0, z1 in cuts if a <= s0 and s1 <= b]
        (left0, right0), (left1, right1) = across(s0), across(s1)
        for low, high in _solid(here, wall.height):
            rise = high - low
            parts.append(wall.left.covering(np.array([*left1, low]), left0 - left1, rise))
            parts.append(wall.right.covering(np.array([*right0, low]), right1 - right0, rise))
            parts.append(_flat((left0, right0, left1, right1), high, 1.0))
            if low > 0.0:
                parts.append(_flat((left0, right0, left1, right1), low, -1.0))
            else:
                for board, way, foot in zip(
                    wall.skirtings, (n, -n), ((left1, left0), (right0, right1)), strict=True
                ):
                    if board is not None:
                        parts += _skirting(board, way, *foot)
    ends = [(0.0, -1.0, 0.0, wall.height), (wall.length, 1.0, 0.0, wall.height)]
    for a, b, sill, head in cuts:
        ends += [(a, 1.0, sill, head), (b, -1.0, sill, head)]
    for at, facing, low, high in ends:
        left, right = across(at)
        first, last = (right, left) if facing > 0 else (left, right)
        parts.append(WallFinish(CUT).covering(np.array([*first, low]), last - first, high - low))
    return parts


def _cut(wall: Wall, u: Point, n: Point, hole: Hole) -> tuple[float, float, float, float] | None:
    """Beginning and end of the hole along the wall, its sill and head; None if it misses."""
    offset = hole.centre - wall.start
    askew = abs(sin(hole.yaw - atan2(u[1], u[0])))
    beside = abs(float(offset @ n)) > (wall.thickness + hole.depth) / 2 - 0.005
    s = float(offset @ u)
    a, b = max(0.0, s - hole.width / 2), min(wall.length, s + hole.width / 2)
    sill, head = max(0.0, hole.sill), min(wall.height, hole.head)
    if askew > sin(pi / 12) or beside or b - a < 0.01 or head - sill < 0.01:
        return None
    return a, b, sill, head


def _solid(holes: Sequence[tuple[float, float]], height: float) -> list[tuple[float, float]]:
    """Heights from and to which a wall is solid between its holes."""
    spans, low = [], 0.0
    for sill, head in sorted(holes):
        if sill > low + 1e-3:
            spans.append((low, sill))
        low = max(low, head)
    if low < height - 1e-3:
        spans.append((low, height))
    return spans


def _corner(wall: Wall, walls: Sequence[Wall], side: int, *, at_end: bool) -> Point:
    """(2,) where a side of the wall ends: on the side of the next wall, if there is one."""
    joint, u = (wall.end, wall.along) if at_end else (wall.start, -wall.along)
    way = side if at_end else -side
    own = joint + way * wall.thickness / 2 * np.array([-u[1], u[0]])
    index = wall.at_end if at_end else wall.at_start
    if index is None or walls[index].length < 0.01:
        return own
    other = walls[index]
    to_start, to_end = hypot(*(other.start - joint)), hypot(*(other.end - joint))
    v = other.along if to_start < to_end else -other.along
    beyond = other.start if to_start < to_end else other.end
    theirs = beyond + way * other.thickness / 2 * np.array([-v[1], v[0]])
    cross = u[0] * v[1] - u[1] * v[0]
    if abs(cross) < 0.05 or min(to_start, to_end) > 0.05:
        return own
    offset = theirs - own
    corner = own + u * (offset[0] * v[1] - offset[1] * v[0]) / cross
    # Of walls that meet at a sharp angle the sides would run on far beyond the joint.
    return corner if hypot(*(corner - joint)) < wall.thickness + other.thickness else own


def _skirting(board: Skirting, way: Point, first: Point, last: Point) -> list[Part]:
    """The front and the top of a board; seen from the wall, `way` points into the room."""
    out = way * board.thickness
    front = WallFinish(board.colour).covering(
        np.array([*(first + out), 0.0]), last - first, board.height
    )
    top = flat_panel(
        (*(first + out), board.height), (*(last - first), 0.0), (*-out, 0.0), board.colour
    )
    return [front, top]


def _flat(corners: Sequence[Point], z: float, way: float) -> Part:
    """A level face between left and right at two places along a wall, seen from above or below."""
    left0, right0, left1, right1 = corners
    rows = (right0, right1, left0, left1) if way > 0 else (left0, left1, right0, right1)
    vertices = np.array([[*corner, z] for corner in rows])
    normals = np.tile([0.0, 0.0, way], (4, 1))
    return meshed(vertices, normals, np.zeros((4, 2)), (2, 2), CUT)
