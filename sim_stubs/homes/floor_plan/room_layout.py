"""Layout of the rooms of a home: rectangles in runs along the sides of a hallway.

The hallway is straight, an L or a T. It is drawn with its main leg along x, then turned and
mirrored. A trial that fails is dropped and another one drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import cv2
import numpy as np

WALL = 0.1
"""Thickness between rooms [m]."""
AREAS = {
    "living room": (16.0, 30.0),
    "kitchen": (9.0, 16.0),
    "bathroom": (4.0, 8.0),
    "bedroom": (10.0, 16.0),
    "kid's room": (9.0, 15.0),
    "laundry room": (4.0, 8.0),
    "study": (7.0, 13.0),
}
"""Smallest and largest floor [m^2]."""
NARROWEST = {
    "living room": 3.3,
    "kitchen": 2.3,
    "bathroom": 1.65,
    "bedroom": 2.6,
    "kid's room": 2.5,
    "laundry room": 1.6,
    "study": 2.2,
}
"""Least width [m]."""
LONGEST = 2.1
"""Largest ratio of a room's sides."""
Random = np.random.Generator
LONGEST_HALL = 12.5
"""Length of a hallway's leg [m]."""
BARE = 2.5
"""A leg goes on at most this far without a room on one of its sides [m]."""


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A room's floor on the plan.

    Attributes:
        name: "kitchen", ...; "hallway" for its legs, "stairs" for a niche that opens onto it.
        x0: West wall [m].
        y0: South wall [m].
        x1: East wall [m].
        y1: North wall [m].
    """

    name: str
    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width(self) -> float:
        """Along x [m]."""
        return self.x1 - self.x0

    @property
    def length(self) -> float:
        """Along y [m]."""
        return self.y1 - self.y0

    @property
    def area(self) -> float:
        """Area of the floor [m^2]."""
        return self.width * self.length

    def gap(self, other: Rectangle) -> tuple[float, float]:
        """Free distance to another along x and y [m]; negative where the two overlap."""
        return (
            max(self.x0, other.x0) - min(self.x1, other.x1),
            max(self.y0, other.y0) - min(self.y1, other.y1),
        )


def sound(rectangles: Sequence[Rectangle]) -> bool:
    """Whether nothing overlaps, no chink is left between rooms and no yard is closed in."""
    for one, other in combinations(rectangles, 2):
        dx, dy = one.gap(other)
        if max(dx, dy) < WALL - 1e-6:
            return False
        chink = max(dx, dy)
        if min(dx, dy) < -0.3 and WALL + 0.01 < chink < 0.9:
            return False
    scale = 20.0
    low = np.min([(r.x0, r.y0) for r in rectangles], axis=0) - 0.5
    high = np.max([(r.x1, r.y1) for r in rectangles], axis=0) + 0.5
    columns, rows = np.ceil((high - low) * scale).astype(int)
    outside = np.ones((rows, columns), np.uint8)
    for r in rectangles:
        a, b = ((np.array([r.x0, r.y0]) - low - WALL) * scale).astype(int)
        c, d = ((np.array([r.x1, r.y1]) - low + WALL) * scale).astype(int)
        outside[b : d + 1, a : c + 1] = 0
    return cv2.connectedComponents(outside, connectivity=4)[0] == 2


def kitchen_beside_living_room(rectangles: Sequence[Rectangle]) -> bool:
    """Whether the two share a wall wide enough for a passage."""
    (kitchen,) = (r for r in rectangles if r.name == "kitchen")
    (living,) = (r for r in rectangles if r.name == "living room")
    dx, dy = kitchen.gap(living)
    return max(dx, dy) < WALL + 0.01 and min(dx, dy) < -1.9


@dataclass(frozen=True, slots=True)
class _Cell:
    """A room of a run: its width along the hallway and its depth away from it."""

    name: str
    width: float
    depth: float


def room_layout(
    rng: Random, names: Sequence[str], niche: float | None, trials: int = 4000
) -> list[Rectangle] | None:
    """Rooms around a hallway; the first ones are the hallway's legs.

    Args:
        rng: Draws shape and sizes.
        names: Names of all rooms except the hallway, each in `AREAS`.
        niche: Width of a niche for stairs [m]; None for none.
        trials: Most trials.

    Returns:
        The rooms; None when every trial failed.
    """
    neighbours = rng.random() < 0.75
    legs = int(rng.choice(3, p=_shape_shares(len(names))))
    for _ in range(trials):
        rectangles = _trial(rng, names, legs, niche)
        if rectangles is None or not sound(rectangles):
            continue
        if any(max(r.width, r.length) > LONGEST_HALL for r in rectangles if r.name == "hallway"):
            continue
        if neighbours and not kitchen_beside_living_room(rectangles):
            continue
        return _turned(rectangles, rng)
    return None


def _trial(
    rng: Random, names: Sequence[str], legs: int, niche: float | None
) -> list[Rectangle] | None:
    rooms = [str(name) for name in rng.permutation(list(names))]
    hall = float(rng.uniform(1.2, 1.75))
    end = None
    if legs == 0 and len(rooms) >= 4 and rng.random() < 0.55:
        end = str(rng.choice(["living room", "living room", "bedroom"]))
        rooms.remove(end)
    counts = _counts(rng, len(rooms), (2, 4, 5)[legs])
    runs = [_cells(rng, [rooms.pop() for _ in range(count)]) for count in counts]
    if niche is not None:
        _insert_niche(rng, runs, niche)
    lay = (_straight, _elbow, _tee)[legs]
    rectangles = lay(rng, hall, runs)
    if rectangles is None or end is None:
        return rectangles
    return _with_end(rng, rectangles, end, hall)


def _shape_shares(count: int) -> tuple[float, float, float]:
    """Probabilities of a straight, an L- and a T-shaped hallway for `count` rooms."""
    if count <= 4:
        return 1.0, 0.0, 0.0
    if count == 5:
        return 0.55, 0.45, 0.0
    return 0.3, 0.35, 0.35


def _counts(rng: Random, rooms: int, runs: int) -> list[int]:
    """Rooms in each run: the two long sides first, which are never empty."""
    most = (5, 5, 2, 2, 2)[:runs]
    least = {2: (1, 1), 4: (1, 1, 1, 0), 5: (2, 1, 1, 0, 0)}[runs]
    counts = list(least)
    while sum(counts) < rooms:
        run = int(rng.integers(runs))
        counts[run] = min(counts[run] + 1, most[run])
    return counts


def _cells(rng: Random, names: Sequence[str]) -> list[_Cell]:
    """Rooms of one run, most of them equally deep, so that the outer wall is straight."""
    depth = rng.uniform(2.9, 4.7)
    step = int(rng.integers(1, len(names))) if len(names) > 1 and rng.random() < 0.4 else 99
    other = min(max(depth + rng.uniform(-1.2, 1.2), 2.5), 5.0)
    cells = []
    for index, name in enumerate(names):
        deep = depth if index < step else other
        small = name in ("bathroom", "laundry room") and index in (0, len(names) - 1)
        if small and rng.random() < 0.4:
            deep = rng.uniform(2.1, 3.0)
        width = max(NARROWEST[name], rng.uniform(*AREAS[name]) / deep)
        cells.append(_Cell(name, width, float(deep)))
    return cells


def _insert_niche(rng: Random, runs: list[list[_Cell]], width: float) -> None:
    """A niche for stairs between two rooms or beside one, as deep as its neighbour."""
    run = runs[int(rng.integers(2))]
    at = int(rng.integers(0, len(run) + 1))
    run.insert(at, _Cell("stairs", width, run[min(at, len(run) - 1)].depth))


def _length(run: Sequence[_Cell]) -> float:
    return sum(cell.width for cell in run) + WALL * (len(run) - 1)


def _fitted(run: Sequence[_Cell], length: float) -> list[_Cell] | None:
    """The run stretched or shrunk to a length; None where a room would not stay a good one."""
    rigid = sum(cell.width for cell in run if cell.name == "stairs") + WALL * (len(run) - 1)
    loose = sum(cell.width for cell in run if cell.name != "stairs")
    if not loose:
        return None
    scale = (length - rigid) / loose
    fitted = [c if c.name == "stairs" else replace(c, width=c.width * scale) for c in run]
    return fitted if all(_good(cell) for cell in fitted) else None


def _good(cell: _Cell) -> bool:
    """Whether a room has a fit size and proportion."""
    if cell.name == "stairs":
        return cell.depth >= 3.0
    low, high = AREAS[cell.name]
    sides = sorted((cell.width, cell.depth))
    return (
        low <= cell.width * cell.depth <= high
        and sides[0] >= NARROWEST[cell.name]
        and sides[1] <= LONGEST * sides[0]
    )


def _laid(run: Sequence[_Cell], at: tuple[float, float], side: str) -> list[Rectangle]:
    """A run north or south of a line that goes east from `at`, or west or east of one north."""
    x, y = at
    rectangles = []
    for cell in run:
        w, d = cell.width, cell.depth
        if side in "NS":
            low, high = (y, y + d) if side == "N" else (y - d, y)
            rectangles.append(Rectangle(cell.name, x, low, x + w, high))
            x += w + WALL
        else:
            low, high = (x, x + d) if side == "E" else (x - d, x)
            rectangles.append(Rectangle(cell.name, low, y, high, y + w))
            y += w + WALL
    return rectangles


def _straight(rng: Random, hall: float, runs: list[list[_Cell]]) -> list[Rectangle] | None:
    length = (_length(runs[0]) + _length(runs[1])) / 2
    south, north = (_fitted(run, length) for run in runs)
    if south is None or north is None:
        return None
    return [
        Rectangle("hallway", 0.0, 0.0, length, hall),
        *_laid(south, (0.0, -WALL), "S"),
        *_laid(north, (0.0, hall + WALL), "N"),
    ]


def _elbow(rng: Random, hall: float, runs: list[list[_Cell]]) -> list[Rectangle] | None:
    """An L: the second leg goes north from the east end of the main one."""
    leg = float(rng.uniform(1.2, 1.6))
    length = (_length(runs[0]) + _length(runs[1]) + leg + WALL) / 2
    south, north = _fitted(runs[0], length), _fitted(runs[1], length - leg - WALL)
    if south is None or north is None:
        return None
    front = north[-1].depth + WALL
    reach = _length(runs[2]) - hall - WALL
    if runs[3]:
        reach = (reach + front + _length(runs[3])) / 2
    if reach < 1.3 or (not runs[3] and reach > front + BARE):
        return None
    east = _fitted(runs[2], hall + WALL + reach)
    west = _fitted(runs[3], reach - front) if runs[3] else []
    if east is None or west is None:
        return None
    top = hall + WALL
    return [
        Rectangle("hallway", 0.0, 0.0, length, hall),
        Rectangle("hallway", length - leg, top, length, top + reach),
        *_laid(south, (0.0, -WALL), "S"),
        *_laid(north, (0.0, top), "N"),
        *_laid(east, (length + WALL, 0.0), "E"),
        *_laid(west, (length - leg - WALL, top + front), "W"),
    ]


def _tee(rng: Random, hall: float, runs: list[list[_Cell]]) -> list[Rectangle] | None:
    """A T: the second leg goes north between two rooms of the main one."""
    leg = float(rng.uniform(1.2, 1.6))
    sides = _length(runs[1]) + _length(runs[2])
    length = (_length(runs[0]) + sides + leg + 2 * WALL) / 2
    share = (length - leg - 2 * WALL) / sides
    south = _fitted(runs[0], length)
    left, right = (_fitted(run, _length(run) * share) for run in runs[1:3])
    if south is None or left is None or right is None:
        return None
    fronts = left[-1].depth + WALL, right[0].depth + WALL
    ends = [front + _length(run) for front, run in zip(fronts, runs[3:], strict=True) if run]
    if not ends:
        return None
    reach = sum(ends) / len(ends)
    if len(ends) < 2 and reach > min(fronts) + BARE:
        return None
    west, east = (
        _fitted(run, reach - front) if run else []
        for front, run in zip(fronts, runs[3:], strict=True)
    )
    if west is None or east is None:
        return None
    x, top = _length(left) + WALL, hall + WALL
    return [
        Rectangle("hallway", 0.0, 0.0, length, hall),
        Rectangle("hallway", x, top, x + leg, top + reach),
        *_laid(south, (0.0, -WALL), "S"),
        *_laid(left, (0.0, top), "N"),
        *_laid(right, (x + leg + WALL, top), "N"),
        *_laid(west, (x - WALL, top + fronts[0]), "W"),
        *_laid(east, (x + leg + WALL, top + fronts[1]), "E"),
    ]


def _with_end(
    rng: Random, rectangles: list[Rectangle], name: str, hall: float
) -> list[Rectangle] | None:
    """One more room across the east end of a straight hallway, flush with one of the runs."""
    width = float(rng.uniform(3.3, 5.2))
    depth = rng.uniform(*AREAS[name]) / width
    if not _good(_Cell(name, width, depth)):
        return None
    x = rectangles[0].x1 + WALL
    last = [r for r in rectangles[1:] if abs(r.x1 - rectangles[0].x1) < 1e-6]
    south, north = min(r.y0 for r in last), max(r.y1 for r in last)
    low = south if rng.random() < 0.5 else north - depth
    if low > 0 or low + depth < hall:
        return None
    return [*rectangles, Rectangle(name, x, low, x + width, low + depth)]


def _turned(rectangles: Sequence[Rectangle], rng: Random) -> list[Rectangle]:
    """The plan mirrored and turned by quarters, its south-west corner at the origin; whole cm."""
    quarter, mirror_x, mirror_y = rng.random(3) < 0.5
    corners = np.array([[(r.x0, r.y0), (r.x1, r.y1)] for r in rectangles])
    corners *= np.where([mirror_x, mirror_y], -1, 1)
    if quarter:
        corners = corners[..., ::-1]
    corners -= corners.min(axis=(0, 1))
    low, high = corners.min(axis=1), corners.max(axis=1)
    return [
        Rectangle(r.name, *np.round(a, 3).tolist(), *np.round(b, 3).tolist())
        for r, a, b in zip(rectangles, low, high, strict=True)
    ]
