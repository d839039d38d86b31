"""Starts of the robot for a goal: free, far from the goal and outside its room."""

from __future__ import annotations

import re
from math import pi

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import House, Instance, Room
from sim_stubs.homes.geometry.occupancy_slice import CELL, FreeSpace, clearance
from sim_stubs.homes.goal_chair import FIRST_DISTANCE, GOAL
from vizbot.core.home_vocabulary import class_of, kinds

ROOM_DISTANCES = (FIRST_DISTANCE, 1.5)
"""Least distances of a start from the floor of every room asked for [m]: the first where there is
such a place, else the second. Within 1 m a robot may count as arrived."""
CLEARANCE = 0.30
"""Least distance of a start from everything around [m]."""
_LEAD = re.compile(
    r"(?:(?:find|go to|drive to|look for|show me|where is) )?(?:(?:an?|the|some) )?(?=.)"
)
"""Words that may come before the name of a goal."""


def start_for(
    house: House, text: str, rng: np.random.Generator, space: FreeSpace | None = None
) -> tuple[float, float, float] | None:
    """A start x, y [m], yaw [rad] of a search for `text`; None where there is none.

    It is free, in the part of the house that can be driven to from `house.start`, over 3 m on the
    plan from every instance of what is asked for, and outside every room asked for. The yellow
    chair of a home is asked for at `house.start`, from which it is out of sight.

    Args:
        house: The house.
        text: The goal in words: a class, a synonym of one, a label, or the name of a room.
        rng: Chooses one of the places.
        space: The plan of the house, where it is at hand.
    """
    things, rooms = things_named(house, text)
    if things and all(it.label == GOAL for it in things):
        return house.start
    space = space or FreeSpace.from_house(house)
    xy = starts(space, standing_room(space, house.start), things, rooms)
    if len(xy) == 0:
        return None
    x, y = xy[rng.integers(len(xy))]
    return float(x), float(y), float(rng.uniform(-pi, pi))


def names_meant(text: str) -> set[str]:
    """The classes, labels or rooms that a goal in words may mean."""
    said = _LEAD.sub("", " ".join(text.casefold().rstrip(" .!?").split()), count=1)
    forms = (said, said.removesuffix("s"))
    return {name for form in forms for name in (form, class_of(form)) if name}


def things_named(house: House, text: str) -> tuple[list[Instance], list[Room]]:
    """The instances and the rooms that `text` asks for."""
    wanted = names_meant(text)
    things = [it for it in house.instances if wanted.intersection(kinds(it.label))]
    return things, [room for room in house.rooms if room.name in wanted]


def standing_room(space: FreeSpace, start: tuple[float, float, float]) -> NDArray[np.float64]:
    """x, y (N, 2) of all places with CLEARANCE [m] that can be driven to from `start`."""
    free = space.reached(start[0], start[1]) & (space.clear > CLEARANCE)
    rows, columns = np.nonzero(free)
    return space.grid.pixels_to_xy(np.column_stack([columns, rows]))


def starts(
    space: FreeSpace,
    places: NDArray[np.float64],
    things: list[Instance],
    rooms: list[Room],
) -> NDArray[np.float64]:
    """The places (M, 2) among `places` (N, 2) from which these may be searched for [m]."""
    for thing in things:
        places = places[distances(places, thing) > FIRST_DISTANCE]
    if not rooms or not len(places):
        return places
    floor = np.any([space.inside(room) for room in rooms], axis=0)
    column, row = np.round(space.grid.to_pixels(places)).astype(int).T
    to_floor = clearance(floor, space.grid)[row, column]
    far = [places[to_floor > distance + CELL] for distance in ROOM_DISTANCES]
    return next((these for these in far if len(these)), places[:0])


def distances(places: NDArray[np.float64], thing: Instance) -> NDArray[np.float64]:
    """Distances (N,) of places (N, 2) from the rectangle around a thing on the plan [m].

    No point of the thing's mesh is nearer.
    """
    T = thing.T_world_piece
    local = (places - T[:2, 3]) @ T[:2, :2]
    beyond = np.maximum(np.abs(local) - thing.piece.size[:2] / 2, 0.0)
    return np.asarray(np.hypot(beyond[:, 0], beyond[:, 1]))
