"""What changes in a home between two visits: a rule that draws it from the things that are there.

Of the things that the first map answers rightly one is moved within its room, one into another
room, and one is taken away. Fixtures stay, and so does what something stands on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import hypot, pi
from typing import Literal

import numpy as np

from sim_stubs.homes.geometry.bounding_block import Block
from sim_stubs.homes.geometry.house import House, Instance, Room
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.start_pose import things_named

ChangeKind = Literal["within its room", "to another room", "gone"]
CHANGES: tuple[ChangeKind, ...] = "within its room", "to another room", "gone"
"""The changes of a home, in the order in which they are drawn."""
FIXTURES = frozenset(
    {
        "door", "window", "stairs", "oven", "refrigerator", "toilet", "bathtub", "shower", "bidet",
        "sink", "washing machine", "dryer", "fireplace", "radiator", "mirror", "picture", "curtain",
        "carpet", "kitchen cabinet", "wall cabinet", "range hood", "microwave", "ceiling lamp",
    }
)  # fmt: skip
"""Labels of what nobody moves from one day to the next."""
AWAY = 1.5
"""Least distance of a new place from the old one [m]."""
_APART = 0.05
"""Least distance between a moved thing and others [m]."""
_TRIES = 400
"""Most new places that are tried for a thing."""
_KEPT_WAYS = 0.95
"""Least share of the floor that is still reached from the entrance, without what is stood on."""


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """One change.

    Attributes:
        text: What the thing is asked for by; there was one of it.
        kind: What happened to it.
        before: The thing in its old place.
        after: The thing in its new place; None where it is gone.
    """

    text: str
    kind: ChangeKind
    before: Instance
    after: Instance | None


def movable(house: House) -> list[Instance]:
    """The things that may be moved: on the floor, with nothing on them, the only ones of a name."""
    holding = {each.on for each in house.instances}
    return [
        each
        for each in house.instances
        if each.label not in FIXTURES
        and each.elevation < _APART
        and not each.on
        and each.name not in holding
        and len(things_named(house, each.label)[0]) == 1
    ]


def draw_changes(
    house: House, answered: Sequence[str], rng: np.random.Generator
) -> tuple[tuple[Change, ...], House]:
    """The changes of a home and the home after them; fewer where too few things can be changed.

    `answered` are the labels of the things that the first map answers rightly.
    """
    things = [each for each in movable(house) if each.label in answered]
    left = [things[i] for i in rng.permutation(len(things))]
    changes: list[Change] = []
    for kind in CHANGES:
        for thing in left:
            after = None if kind == "gone" else _moved(house, thing, kind, rng)
            if kind == "gone" or after is not None:
                changes.append(Change(thing.label, kind, thing, after))
                house = _with(house, thing, after)
                left.remove(thing)
                break
    return tuple(changes), house


def _moved(
    house: House, thing: Instance, kind: ChangeKind, rng: np.random.Generator
) -> Instance | None:
    """A thing in a new place, to which the robot still comes; None where there is none."""
    own = house.room_at(thing.x, thing.y)
    rooms = [room for room in house.rooms if (room is own) == (kind == "within its room")]
    before = FreeSpace.from_house(house).reached(*house.start[:2])
    for after in _places(house, thing, rooms, rng):
        changed = FreeSpace.from_house(_with(house, thing, after))
        reached = changed.reached(*house.start[:2])
        if np.count_nonzero(reached & before) >= _KEPT_WAYS * np.count_nonzero(before):
            return after
    return None


def _places(
    house: House, thing: Instance, rooms: Sequence[Room], rng: np.random.Generator
) -> Iterator[Instance]:
    """The thing in places on the floor of rooms where it has space."""
    others = [Block.around(each) for each in house.instances if each is not thing]
    solid = [each for each in others if each.z1 > _APART]
    for _ in range(_TRIES if rooms else 0):
        room = rooms[int(rng.integers(len(rooms)))]
        (x0, y0), (x1, y1) = room.polygon.min(axis=0), room.polygon.max(axis=0)
        x, y = float(rng.uniform(x0, x1)), float(rng.uniform(y0, y1))
        after = replace(thing, x=x, y=y, yaw=float(rng.integers(4)) * pi / 2)
        block = Block.around(after).grown(_APART)
        if (
            hypot(x - thing.x, y - thing.y) >= AWAY
            and all(room.contains(*corner) for corner in after.footprint.tolist())
            and not any(block.overlaps(each) for each in solid)
        ):
            yield after


def _with(house: House, thing: Instance, after: Instance | None) -> House:
    """The house with a thing in another place, or without it."""
    instances = [after if each is thing else each for each in house.instances]
    return replace(house, instances=tuple(each for each in instances if each is not None))
