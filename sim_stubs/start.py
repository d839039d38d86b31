"""Where the robot starts when it is asked for something: free, far from it and outside its room."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np
from numpy.typing import NDArray

from sim_stubs.free_space import CELL, FreeSpace, shadow
from sim_stubs.house import House, Instance, Room
from sim_stubs.occupancy_slice import PlanGrid, clearance
from sim_stubs.vocabulary import class_of, kinds

FIRST_DISTANCE = 3.0
"""A start is farther than this from every instance of the goal [m] (the benchmark's rule)."""
ROOM_DISTANCES = (FIRST_DISTANCE, 1.5)
"""A start is farther than this from the floor of every room asked for [m]: than the first where
there is such a place, else than the second. Within 1 m a robot may count as arrived."""
CLEARANCE = 0.30
"""Of a start from everything around [m]."""
_MARGIN = 2 * CELL
"""Cells are as wide as that; distances hold for what is in them."""


def start_for(
    house: House, text: str, rng: np.random.Generator
) -> tuple[float, float, float] | None:
    """A pose x, y [m], yaw [rad] to look for `text` from; None where there is none.

    It is free, in the part of the house that can be driven to from `house.start`, over 3 m on the
    plan from the nearest point of every instance's true mesh, and outside every room asked for.

    Args:
        house: Where.
        text: The goal in words: a class, a synonym of one, a label, or the name of a room.
        rng: Draws one of the places.
    """
    space = FreeSpace.of(house)
    fit = starts(house, space, space.reached(*house.start[:2]), text)
    rows, columns = np.nonzero(fit)
    if len(rows) == 0:
        return None
    chosen = rng.integers(len(rows))
    x, y = space.grid.to_xy(np.array([columns[chosen], rows[chosen]]))
    return float(x), float(y), float(rng.uniform(-pi, pi))


def starts(
    house: House, space: FreeSpace, reached: NDArray[np.bool_], text: str
) -> NDArray[np.bool_]:
    """Cells (rows, cols) of `space` that fit for a start, among those `reached`."""
    free = reached & (space.clear > CLEARANCE)
    things, rooms = named(house, text)
    for thing in things:
        free &= away_from(thing, space.grid) > FIRST_DISTANCE + _MARGIN
    if not rooms:
        return free
    floor = np.any([space.inside(room) for room in rooms], axis=0)
    for distance in ROOM_DISTANCES:
        far = free & (clearance(floor, space.grid) > distance + _MARGIN)
        if far.any():
            break
    return far


def named(house: House, text: str) -> tuple[list[Instance], list[Room]]:
    """The instances and the rooms that `text` asks for."""
    words = " ".join(text.casefold().split())
    wanted = {words, class_of(words) or words}
    things = [it for it in house.instances if wanted.intersection(kinds(it.label))]
    return things, [room for room in house.rooms if room.name in wanted]


def away_from(instance: Instance, grid: PlanGrid) -> NDArray[np.float32]:
    """(rows, cols) distance on the plan to the nearest point of an instance's mesh [m]."""
    return clearance(shadow(instance, -10.0, 10.0, grid), grid)


def exists(house: House, text: str) -> bool:
    """Whether the house has what `text` asks for."""
    return any(named(house, text))


def names_of(instances: Sequence[Instance]) -> list[str]:
    """Their names."""
    return [instance.name for instance in instances]
