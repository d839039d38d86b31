"""Floor plans of homes, drawn from a seed: rooms, doorways, windows, stairs, floors and walls.

World frame: the plan's south-west corner is the origin, the floor is at z = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.floor_plan.room_layout import Rectangle, room_layout
from sim_stubs.homes.floor_plan.room_openings import (
    doorway,
    outer_door,
    passage,
    shared_wall,
    wide_passage,
    windows,
)
from sim_stubs.homes.floor_plan.stairs import (
    StairChoice,
    Stairs,
    in_living_room,
    in_niche,
    stair_choice,
)
from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom
from sim_stubs.homes.textures.surfaces import SurfaceFinish, any_finish, finish
from vizbot.core.distance import distance_to_zero

CELL = 0.05
"""Edge of a cell of the plan [m]."""
CLEARANCE = 0.25
"""Radius of a disc that gets from each room into every other one [m]."""
Random = np.random.Generator
NECESSARY = ("living room", "kitchen", "bathroom", "bedroom")
OPTIONAL = ("kid's room", "laundry room", "study", "bedroom")
"""Up to four of them come besides the hallway and what is necessary."""
WINDOW_FREE = 3.3
"""Least distance from every window of some place in the hallway [m]."""
TRIALS = 1000
"""Most trials of a plan; a few are enough."""
BRIGHT = ("living room", "kitchen", "bedroom", "kid's room", "study")
"""Rooms that always have a window."""
WET = ("kitchen", "bathroom", "laundry room")
FLOORS: Mapping[str, Mapping[str, float]] = {
    "dry": {"planks": 0.3, "parquet": 0.22, "laminate": 0.25, "tiles": 0.08, "marble": 0.05,
            "flagstones": 0.03, "concrete": 0.07},
    "wet": {"tiles": 0.6, "flagstones": 0.12, "marble": 0.14, "concrete": 0.14},
    "soft": {"planks": 0.3, "parquet": 0.2, "laminate": 0.3, "fitted carpet": 0.2},
}  # fmt: skip
"""Families of floors and their weights, by what a room needs."""
WALLS: Mapping[str, Mapping[str, float]] = {
    "plain": {"paint": 0.5, "plaster": 0.16, "wallpaper": 0.12, "stripes": 0.09,
              "ornaments": 0.08, "bricks": 0.05},
    "kitchen": {"paint": 0.4, "plaster": 0.2, "wall tiles": 0.25, "bricks": 0.08,
                "wallpaper": 0.07},
    "bathroom": {"wall tiles": 0.75, "paint": 0.15, "plaster": 0.1},
}  # fmt: skip
"""Families of walls and their weights."""


def all_reached(
    rooms: Sequence[Rectangle], openings: Sequence[Opening], stairs: Stairs | None
) -> bool:
    """Whether a disc gets from the first room into every other one.

    Args:
        rooms: Rooms by their inner faces.
        openings: Openings, of which windows and the outer door are closed.
        stairs: Stairs, which block their place.
    """
    low = np.min([(room.x0, room.y0) for room in rooms], axis=0) - 0.5
    high = np.max([(room.x1, room.y1) for room in rooms], axis=0) + 0.5
    columns, rows = np.ceil((high - low) / CELL).astype(int)

    def cells(x0: float, y0: float, x1: float, y1: float) -> tuple[slice, slice]:
        (a, b), (c, d) = (
            np.round((np.array(corner) - low) / CELL).astype(int) for corner in ((x0, y0), (x1, y1))
        )
        return slice(int(b), int(d)), slice(int(a), int(c))

    free = np.zeros((rows, columns), np.uint8)
    for room in rooms:
        free[cells(room.x0, room.y0, room.x1, room.y1)] = 1
    for opening in openings:
        if opening.kind == "doorway":
            free[cells(opening.x0, opening.y0, opening.x1, opening.y1)] = 1
    if stairs is not None:
        free[cells(*stairs.bounds)] = 0
    wide = distance_to_zero(free) * CELL > CLEARANCE
    _, labels = cv2.connectedComponents(wide.astype(np.uint8), connectivity=4)
    first = labels[cells(rooms[0].x0, rooms[0].y0, rooms[0].x1, rooms[0].y1)]
    home = int(np.bincount(first[first > 0], minlength=1).argmax())
    for room in rooms:
        if room.name == "stairs":
            continue
        inside = labels[cells(room.x0, room.y0, room.x1, room.y1)]
        if home == 0 or (inside == home).mean() < 0.3:
            return False
    return True


def free_spots(rooms: Sequence[Rectangle], stairs: Stairs | None) -> NDArray[np.float64]:
    """Points (N, 2) every 0.1 m that are 0.3 m or more from walls and stairs [m]."""
    spots = []
    for room in rooms:
        x, y = np.meshgrid(
            np.arange(room.x0 + 0.3, room.x1 - 0.29, 0.1),
            np.arange(room.y0 + 0.3, room.y1 - 0.29, 0.1),
        )
        spots.append(np.column_stack([x.ravel(), y.ravel()]))
    points = np.concatenate(spots)
    if stairs is None:
        return points
    x0, y0, x1, y1 = stairs.bounds
    return points[away_from(points, x0, y0, x1, y1) > 0.3]


def away_from(
    points: NDArray[np.float64], x0: float, y0: float, x1: float, y1: float
) -> NDArray[np.float64]:
    """Distance (N,) of points (N, 2) on the plan to an upright rectangle [m]."""
    nearest = np.clip(points, (x0, y0), (x1, y1))
    return np.asarray(np.linalg.norm(points - nearest, axis=1))


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """A home without furniture.

    Attributes:
        rooms: At least one of each necessary kind; a hallway may consist of several.
        openings: Doorways between rooms, windows and the closed outer door in outer walls.
        stairs: Stairs in the hallway or the living room; None without stairs.
        height: Height of the ceiling [m].
    """

    rooms: tuple[RectangularRoom, ...]
    openings: tuple[Opening, ...]
    stairs: Stairs | None
    height: float


def floor_plan(rng: Random, held_out: bool) -> FloorPlan | None:
    """A home of 5 to 9 rooms, all reached through doorways; None where TRIALS give none."""
    plans = (_drawn(rng, held_out) for _ in range(TRIALS))
    return next((plan for plan in plans if plan is not None), None)


def _drawn(rng: Random, held_out: bool) -> FloorPlan | None:
    """One trial of a plan; None if it fails."""
    height = round(float(rng.uniform(2.4, 2.8)), 2)
    extra = rng.permutation(OPTIONAL)[: int(rng.integers(0, len(OPTIONAL) + 1))]
    choice = stair_choice(rng, held_out) if rng.random() < 0.6 else None
    niche = choice.width if choice is not None and choice.in_niche else None
    rectangles = room_layout(rng, [*NECESSARY, *extra.tolist()], niche)
    if rectangles is None:
        return None
    stairs = None
    if choice is not None:
        stairs = _stairs(rng, choice, rectangles)
        if stairs is None:
            return None
    doorways = _doorways(rng, rectangles, stairs, height)
    leaf = finish("door", rng, held_out).surface
    halls = [r for r in rectangles if r.name == "hallway"]
    door = outer_door(rng, halls, rectangles, leaf)
    if doorways is None or door is None or not all_reached(rectangles, doorways, stairs):
        return None
    closed = [(door.x0, door.y0, door.x1, door.y1)]
    if stairs is not None:
        closed.append(stairs.bounds)
    lit = windows(rng, rectangles, closed, held_out)
    kept = _with_dark_spot(lit, rectangles, stairs)
    if kept is None:
        return None
    rooms = _finished(rng, rectangles, held_out)
    return FloorPlan(rooms, (*doorways, door, *kept), stairs, height)


def _stairs(rng: Random, choice: StairChoice, rooms: Sequence[Rectangle]) -> Stairs | None:
    """Stairs in their niche of the hallway, or in the living room."""
    for room in rooms:
        if choice.in_niche and room.name == "stairs":
            return in_niche(rng, choice, room, rooms[0])
        if not choice.in_niche and room.name == "living room":
            return in_living_room(rng, choice, room)
    return None


def _doorways(
    rng: Random, rooms: Sequence[Rectangle], stairs: Stairs | None, height: float
) -> list[Opening] | None:
    """Doorways between the hallway and every room; None where one has no place."""
    main = rooms[0]
    halls = [room for room in rooms if room.name == "hallway"]
    clear = [] if stairs is None else [stairs.bounds]
    openings = []
    for room in rooms[1:]:
        if room.name in ("hallway", "stairs"):
            wall = shared_wall(main, room)
            if wall is None:
                return None
            openings.append(passage(wall, height))
            continue
        walls = [wall for hall in halls if (wall := shared_wall(hall, room)) is not None]
        holes = (doorway(rng, walls[int(i)], clear) for i in rng.permutation(len(walls)))
        hole = next((hole for hole in holes if hole is not None), None)
        if hole is None:
            return None
        openings.append(hole)
    return openings + _between_kitchen_and_living_room(rng, rooms, clear)


def _between_kitchen_and_living_room(
    rng: Random, rooms: Sequence[Rectangle], clear: Sequence[tuple[float, float, float, float]]
) -> list[Opening]:
    """A wide passage, a doorway or nothing."""
    (kitchen,) = (room for room in rooms if room.name == "kitchen")
    (living,) = (room for room in rooms if room.name == "living room")
    wall = shared_wall(kitchen, living)
    chance = rng.random()
    if wall is None or chance > 0.75:
        return []
    hole = wide_passage(rng, wall, clear) if chance < 0.5 else doorway(rng, wall, clear)
    return [] if hole is None else [hole]


def _with_dark_spot(
    lit: Sequence[Opening], rooms: Sequence[Rectangle], stairs: Stairs | None
) -> list[Opening] | None:
    """The windows less those too near to some place in the hallway.

    The place is the one that costs fewest windows; None where a bright room would go dark.
    """
    halls = [room for room in rooms if room.name == "hallway"]
    spots = free_spots(halls, stairs)
    if not len(spots):
        return None
    far = np.stack([away_from(spots, w.x0, w.y0, w.x1, w.y1) > WINDOW_FREE for w in lit])
    best = int(far.sum(axis=0).argmax())
    kept = [window for window, stays in zip(lit, far[:, best], strict=True) if stays]
    for room in rooms:
        if room.name in BRIGHT and not any(_lights_up(window, room) for window in kept):
            return None
    return kept if len(kept) >= 3 else None


def _lights_up(window: Opening, room: Rectangle) -> bool:
    """Whether a window is in a wall of a room."""
    gap = Rectangle("window", window.x0, window.y0, window.x1, window.y1).gap(room)
    return max(gap) < 0.01


def _finished(
    rng: Random, rectangles: Sequence[Rectangle], held_out: bool
) -> tuple[RectangularRoom, ...]:
    """The rooms with floors, walls and a ceiling; dry rooms often share the floor."""
    ceiling = finish("ceiling", rng, held_out).surface
    common_floor = any_finish(FLOORS["dry"], rng, held_out)
    common_wall = any_finish(WALLS["plain"], rng, held_out)
    looks: dict[str, tuple[SurfaceFinish, SurfaceFinish]] = {}
    rooms = []
    for r in rectangles:
        name = "hallway" if r.name == "stairs" else r.name
        floor, wall = common_floor, common_wall
        if name in WET:
            floor = any_finish(FLOORS["wet"], rng, held_out)
        elif rng.random() < 0.4:
            soft = name in ("bedroom", "kid's room")
            floor = any_finish(FLOORS["soft" if soft else "dry"], rng, held_out)
        if name in WET or rng.random() < 0.75:
            kind = {"kitchen": "kitchen", "bathroom": "bathroom"}.get(name, "plain")
            wall = any_finish(WALLS[kind], rng, held_out)
        if name == "hallway":  # its legs look alike
            floor, wall = looks.setdefault(name, (floor, wall))
        rooms.append(
            RectangularRoom(
                name, r.x0, r.y0, r.x1, r.y1,
                floor.surface, floor.tile, wall.surface, wall.tile, ceiling,
            )
        )  # fmt: skip
    return tuple(rooms)
