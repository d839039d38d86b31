"""An office for the paper's robot experiment: yellow chair, electric fan, bookshelf, in this order.

14 x 11 m: an open-plan office, a meeting room, a small office, a kitchen and a lounge along a
corridor. The plan is the same for every seed; the seed draws models and surfaces, all held out
from training, which of three rooms has which of the goals, and the start, which is in another room
and out of sight of all three (paper, section "Real Robot Experiments").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom, build_structure
from sim_stubs.homes.furniture.catalogue import read_catalogue
from sim_stubs.homes.furniture.fitting import Slot, Source, furnished
from sim_stubs.homes.furniture.paint import painted_plain
from sim_stubs.homes.furniture.source import furniture_source
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace, PlanGrid, occupied
from sim_stubs.homes.geometry.solids import Piece, triangles
from sim_stubs.homes.goal_chair import FIRST_DISTANCE, YELLOW, is_passable
from sim_stubs.homes.textures.surfaces import finish
from vizbot.core.errors import ConfigError

GOALS = ("yellow chair", "electric fan", "bookshelf")
"""Goals of the experiment, in its order."""
HEIGHT = 2.6
"""Height of the ceilings [m]."""
DRAWS = 200
"""Most starts tried; a good one comes after a few."""
SHELVES = 4
"""Bookshelves drawn, of which the tallest is taken, because the office has only one."""
EYE = (0.5, 1.0)
"""Heights between which a wall hides what is behind it [m]."""
CLEAR = 0.35
"""Least distance of a start from everything [m]."""

_Place = tuple[float, float, str]
"""Middle of the back of a piece [m], and the direction of its front."""

PLACES: tuple[_Place, ...] = ((0.04, 10.2, "E"), (8.54, 1.0, "E"), (0.04, 2.9, "E"))
"""Places of the goals: in the open-plan office, the lounge and the small office."""
START_ROOMS = ("meeting room", "kitchen")


def _workplaces() -> tuple[Slot, ...]:
    """Two blocks of four desks, each with a screen and a chair."""
    slots = []
    for x in (1.9, 3.35, 6.0, 7.45):
        for desk, screen, chair, front, back in (
            (8.6, 8.65, 9.95, "N", "S"),
            (8.6, 8.55, 7.25, "S", "N"),
        ):
            slots.append(Slot("desk", x, desk, front, 1.4, 0.7, fill=True, height=0.8))
            slots.append(Slot("computer", x, screen, front, 0.6, 0.4, on="desk"))
            slots.append(Slot("office chair", x, chair, back, 0.6, 0.6))
    return tuple(slots)


OPEN_PLAN = (
    *_workplaces(),
    Slot("whiteboard", 0.05, 7.6, "E", 1.3, 0.55),
    Slot("filing cabinet", 0.04, 6.3, "E", 0.45, 0.55),
    Slot("printer", 0.08, 6.3, "E", 0.45, 0.4, on="filing cabinet"),
    Slot("plant", 8.05, 5.78, "N", 0.5, 0.5),
    Slot("plant", 8.05, 10.87, "S", 0.5, 0.5),
    Slot("trash can", 4.7, 10.87, "S", 0.3, 0.3),
    Slot("picture", 0.02, 9.2, "E", 0.9, 0.1, 1.3),
    Slot("picture", 1.6, 5.72, "N", 0.9, 0.1, 1.3),
    Slot("picture", 6.6, 5.72, "N", 0.9, 0.1, 1.3),
    Slot("picture", 8.38, 7.0, "W", 0.9, 0.1, 1.3),
)
MEETING_ROOM = (
    Slot("table", 11.3, 8.75, "S", 2.4, 1.1, fill=True, height=0.8),
    *(Slot("chair", x, 9.45, "S", 0.55, 0.6) for x in (10.55, 11.3, 12.05)),
    *(Slot("chair", x, 6.95, "N", 0.55, 0.6) for x in (10.55, 11.3, 12.05)),
    Slot("whiteboard", 13.95, 8.2, "W", 1.4, 0.55),
    Slot("tv", 8.55, 8.2, "E", 1.2, 0.3, 1.0),
    Slot("plant", 13.6, 10.85, "S", 0.55, 0.55),
    Slot("picture", 13.98, 6.4, "W", 0.9, 0.1, 1.3),
    Slot("picture", 12.6, 5.72, "N", 0.9, 0.1, 1.3),
)
SMALL_OFFICE = (
    Slot("desk", 1.3, 0.03, "N", 1.4, 0.7, fill=True, height=0.8),
    Slot("computer", 1.3, 0.08, "N", 0.6, 0.4, on="desk"),
    Slot("office chair", 1.3, 1.4, "S", 0.6, 0.6),
    Slot("desk", 3.1, 0.03, "N", 1.4, 0.7, fill=True, height=0.8),
    Slot("laptop", 3.1, 0.25, "N", 0.36, 0.3, on="desk"),
    Slot("office chair", 3.1, 1.4, "S", 0.6, 0.6),
    Slot("filing cabinet", 4.37, 2.2, "W", 0.45, 0.55),
    Slot("plant", 0.3, 0.05, "N", 0.45, 0.45),
    Slot("picture", 4.38, 1.2, "W", 0.9, 0.1, 1.3),
    Slot("picture", 1.6, 3.88, "S", 0.9, 0.1, 1.3),
)
KITCHEN = (
    Slot("kitchen cabinet", 5.2, 0.02, "N", 1.2, 0.62, fill=True),
    Slot("coffee machine", 5.2, 0.06, "N", 0.4, 0.4, on="kitchen cabinet"),
    Slot("sink", 6.3, 0.02, "N", 0.8, 0.6),
    Slot("kitchen cabinet", 7.2, 0.02, "N", 0.9, 0.62, fill=True),
    Slot("microwave", 7.2, 0.06, "N", 0.5, 0.4, on="kitchen cabinet"),
    Slot("refrigerator", 8.0, 0.03, "N", 0.68, 0.7),
    Slot("table", 7.85, 2.9, "S", 0.9, 0.8),
    Slot("stool", 7.1, 2.5, "E", 0.4, 0.4),
    Slot("trash can", 4.75, 1.1, "E", 0.3, 0.3),
    Slot("picture", 4.52, 2.2, "E", 0.9, 0.1, 1.3),
)
LOUNGE = (
    Slot("sofa", 11.4, 0.04, "N", 2.0, 0.9),
    Slot("coffee table", 11.4, 1.5, "N", 1.0, 0.6),
    Slot("armchair", 13.93, 1.7, "W", 0.9, 0.9),
    Slot("plant", 13.65, 0.06, "N", 0.55, 0.55),
    Slot("red chair", 9.0, 3.86, "S", 0.55, 0.6),
    Slot("picture", 11.0, 3.88, "S", 0.9, 0.1, 1.3),
    Slot("picture", 13.98, 2.9, "W", 0.9, 0.1, 1.3),
)
CORRIDOR = (
    Slot("water cooler", 0.5, 5.57, "S", 0.35, 0.35),
    Slot("plant", 13.7, 5.57, "S", 0.4, 0.4),
    Slot("fire extinguisher", 8.0, 5.58, "S", 0.2, 0.2),
    *(Slot("picture", x, 5.58, "S", 0.9, 0.1, 1.3) for x in (1.8, 6.3, 11.4)),
    *(Slot("picture", x, 4.02, "N", 0.9, 0.1, 1.3) for x in (1.5, 7.6, 10.2)),
)
FURNITURE = (*OPEN_PLAN, *MEETING_ROOM, *SMALL_OFFICE, *KITCHEN, *LOUNGE, *CORRIDOR)

ROOMS: tuple[tuple[str, tuple[float, float, float, float], str, str], ...] = (
    ("office", (0.0, 5.7, 8.4, 10.9), "fitted carpet", "plaster"),
    ("meeting room", (8.5, 5.7, 14.0, 10.9), "fitted carpet", "stripes"),
    ("hallway", (0.0, 4.0, 14.0, 5.6), "tiles", "plaster"),
    ("office", (0.0, 0.0, 4.4, 3.9), "laminate", "plaster"),
    ("kitchen", (4.5, 0.0, 8.4, 3.9), "tiles", "plaster"),
    ("lounge", (8.5, 0.0, 14.0, 3.9), "planks", "wallpaper"),
)
"""Name; west, south, east and north wall [m]; families of floor and walls."""

DOORWAYS = (
    Opening(3.7, 5.6, 5.7, 5.7, 0.0, 2.2),
    Opening(9.1, 5.6, 10.0, 5.7),
    Opening(3.2, 3.9, 4.1, 4.0),
    Opening(5.5, 3.9, 6.4, 4.0),
    Opening(12.4, 3.9, 13.3, 4.0),
)
WINDOWS = (
    (0.9, 10.9, 4.1, 11.1),
    (5.0, 10.9, 7.6, 11.1),
    (9.4, 10.9, 12.8, 11.1),
    (1.0, -0.2, 3.4, 0.0),
    (9.3, -0.2, 10.3, 0.0),
    (12.5, -0.2, 13.3, 0.0),
)


def office(seed: int) -> House:
    """The office as `seed` draws it.

    Raises:
        ConfigError: the models drawn leave no free way.
    """
    rng = np.random.default_rng((seed, 5))
    source = furniture_source(read_catalogue(), held_out=True)
    rooms = [_room(*room, rng=rng) for room in ROOMS]
    known = [slot for slot in FURNITURE if _is_known(slot.label, source)]
    furniture = furnished([*known, *_goals(rng)], _office_source(source), rng)
    empty = House(
        rooms=tuple(room.room for room in rooms),
        structure=build_structure(rooms, _openings(rng), HEIGHT),
        instances=furniture,
        lights=np.array([(x, y, HEIGHT - 0.2) for x, y in _lamps(rooms)]),
        start=(0.0, 0.0, 0.0),
    )
    return replace(empty, start=_start(empty, rng))


def _room(
    name: str,
    walls: tuple[float, float, float, float],
    floor: str,
    wall: str,
    rng: np.random.Generator,
) -> RectangularRoom:
    ground, paper = (finish(family, rng, held_out=True) for family in (floor, wall))
    return RectangularRoom(name, *walls, ground.surface, ground.tile, paper.surface, paper.tile)


def _openings(rng: np.random.Generator) -> tuple[Opening, ...]:
    entrance = finish("door", rng, held_out=True).surface
    return (
        *DOORWAYS,
        Opening(-0.1, 4.3, 0.0, 5.2, pane=entrance, kind="door"),
        *(
            Opening(*window, 0.9, 2.2, finish("outdoors", rng, held_out=True).surface, "window")
            for window in WINDOWS
        ),
    )


def _lamps(rooms: Sequence[RectangularRoom]) -> list[tuple[float, float]]:
    """A lamp in the middle of each room, two or three in a long one."""
    lamps = []
    for room in rooms:
        count = max(1, round((room.x1 - room.x0) / 5.0))
        steps = (np.arange(count) + 0.5) / count
        lamps += [(room.x0 + (room.x1 - room.x0) * step, (room.y0 + room.y1) / 2) for step in steps]
    return lamps


def _goals(rng: np.random.Generator) -> list[Slot]:
    """The three goals, each in a room of its own; the fan stands on a cabinet."""
    chair, fan, shelf = (PLACES[int(i)] for i in rng.permutation(len(PLACES)))
    return [
        Slot("yellow chair", *chair, 0.6, 0.6),
        Slot("nightstand", *fan, 0.5, 0.45),
        Slot("electric fan", *fan, 0.45, 0.45, on="nightstand"),
        Slot("bookshelf", *shelf, 1.0, 0.4),
    ]


def _office_source(source: Source) -> Source:
    """`source`, with chairs in the colours of their labels, and a tall bookshelf."""
    paints = {"yellow chair": YELLOW, "red chair": (0.80, 0.08, 0.08)}

    def piece(label: str, rng: np.random.Generator) -> Piece:
        if label in paints:
            return painted_plain(source("chair", rng), label, paints[label])
        if label == "bookshelf":
            return max((source(label, rng) for _ in range(SHELVES)), key=lambda it: it.size[2])
        return source(label, rng)

    return piece


def _is_known(label: str, source: Source) -> bool:
    """Whether there is a model; without the catalogue an office does with less."""
    try:
        _office_source(source)(label, np.random.default_rng(0))
    except ConfigError:
        return False
    return True


def _start(house: House, rng: np.random.Generator) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad] in a room without a goal, from which none of them is in sight."""
    space = FreeSpace.from_house(house)
    walls = occupied(triangles(house.structure), *EYE, space.grid)
    goals = [instance for instance in house.instances if instance.label in GOALS]
    starts = [room for room in house.rooms if room.name in START_ROOMS]
    for _ in range(DRAWS):
        room = starts[rng.integers(len(starts))]
        x, y = rng.uniform(room.polygon.min(axis=0), room.polygon.max(axis=0))
        start = float(x), float(y), float(rng.uniform(-pi, pi))
        near = any(np.hypot(it.x - x, it.y - y) < FIRST_DISTANCE for it in goals)
        if near or space.clearance(x, y) < CLEAR:
            continue
        if any(_in_sight(x, y, goal, walls, space.grid) for goal in goals):
            continue
        if is_passable(space, start, house.rooms, goals):
            return start
    raise ConfigError("the furniture leaves no free way through the office; use smaller models")


def _in_sight(x: float, y: float, goal: Instance, walls: NDArray[np.bool_], grid: PlanGrid) -> bool:
    """Whether a straight line on the plan to a corner of the goal meets no wall.

    Furniture hides nothing here, so that this errs on the safe side.
    """
    along = np.linspace(0.0, 1.0, 1000)[:, None]
    for corner in (*goal.footprint, (goal.x, goal.y)):
        column, row = np.floor(
            grid.to_pixels(np.array([x, y]) * (1 - along) + np.asarray(corner) * along) + 0.5
        ).T
        if not walls[row.astype(int), column.astype(int)].any():
            return True
    return False
