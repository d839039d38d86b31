"""A home with bare walls: what makes the eyes of a robot lose hold in real ones.

Pictures are gone from the walls, doors are white, and one tall mirror hangs at a wall. Only what a
camera sees changes: the rooms, the furniture, the floor and everything that a robot can touch stay.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furniture.paint import COLOURS, painted_plain
from sim_stubs.homes.geometry.bounding_block import Block
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.mirror import Mirror
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.world.visibility import opaque_walls

WIDTH, LOWER, UPPER = 0.9, 0.1, 1.8
"""Width of the mirror, heights of its lower and its upper edge [m]."""
OFF_THE_WALL = 0.008
"""Thickness of the mirror [m]: what the renderer draws of the wall lies behind its plane."""
FREE_BEFORE = (3.0, 2.0, 1.0, 0.5)
"""Depth of the space before the mirror in which nothing stands [m]; the first that a wall has."""
_STEP = 0.1
"""Distance between the places that are tried on a wall [m]."""


def bare(house: House) -> House:
    """The house without pictures, with white doors and, where a wall has room for it, a mirror."""
    instances = tuple(
        replace(it, piece=painted_plain(it.piece, it.label, COLOURS["white"]))
        if it.label == "door"
        else it
        for it in house.instances
        if it.label != "picture"
    )
    emptied = replace(house, instances=instances)
    return replace(emptied, mirror=_mirror(emptied))


def _mirror(house: House) -> Mirror | None:
    """A mirror at a wall of a room, where it is seen from far; None without a place for one."""
    blocks = [Block.around(it) for it in house.instances]
    places = list(_places(house))
    for depth in FREE_BEFORE:
        for mirror in places:
            if _is_free(mirror, depth, house, blocks):
                return mirror
    return None


def _places(house: House) -> Iterator[Mirror]:
    """Mirrors at walls without an opening: the longest wall first, from its middle outwards."""
    corners = triangles([part for part in house.structure if part.rgba[3] >= 1.0])
    walls = opaque_walls(corners, float(corners[..., 2].max(initial=0.0)))
    lengths = np.linalg.norm(walls[:, 1] - walls[:, 0], axis=1)
    for wall in np.argsort(-lengths, kind="stable"):
        if lengths[wall] < WIDTH:
            return
        # On the way from its end to its start, the visible side is to the right.
        start, end = walls[wall, 1], walls[wall, 0]
        along = (end - start) / lengths[wall]
        before = np.array([along[1], -along[0]])
        offsets = np.arange(0.0, lengths[wall] - WIDTH + 1e-9, _STEP)
        for offset in offsets[np.argsort(np.abs(offsets - offsets.mean()), kind="stable")]:
            foot = start + offset * along + OFF_THE_WALL * before
            yield Mirror(
                np.array([*foot, LOWER]),
                np.array([*(WIDTH * along), 0.0]),
                np.array([0.0, 0.0, UPPER - LOWER]),
            )


def _is_free(mirror: Mirror, depth: float, house: House, blocks: list[Block]) -> bool:
    """Whether one room, and nothing that stands in it, fills the space before a mirror."""
    ends = np.array([mirror.corner[:2], mirror.corner[:2] + mirror.along[:2]])
    outline: NDArray[np.float64] = np.concatenate([ends, ends + depth * mirror.normal[:2]])
    rooms = [house.room_at(float(x), float(y)) for x, y in outline]
    if rooms[0] is None or any(room is not rooms[0] for room in rooms):
        return False
    (x0, y0), (x1, y1) = outline.min(axis=0), outline.max(axis=0)
    space = Block(float(x0), float(y0), float(x1), float(y1), LOWER, UPPER)
    return not any(space.overlaps(block) for block in blocks)
