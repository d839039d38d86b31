"""Facts of a house that hold from every viewpoint: classes, looks and relations of its pieces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furniture.appearance import Appearance, appearance
from sim_stubs.homes.geometry.house import House, Instance, Room
from training.captions.facts import FACT_INDEX
from training.captions.spatial_relations import related
from vizbot.core.home_vocabulary import COLOURLESS, COLOURS, MATERIALS, akin, kinds

CELL = 0.05
"""Edge of a cell of a `RoomMap` [m]."""
_TOGETHER = ({"metal", "glass"}, {"wood", "metal"}, {"metal", "plastic"}, {"fabric", "wood"},
             {"fabric", "metal"}, {"leather", "metal"}, {"leather", "wood"})  # fmt: skip
"""Materials that often occur in one piece: where one is known, the other is disputable."""


@dataclass(frozen=True, slots=True, eq=False)
class FactTable:
    """E facts about one piece each, or about two.

    Attributes:
        pieces: (E,) or (E, 2) int64, indices in `House.instances`.
        facts: (E,) int64, columns in `FACTS`.
        certain: (E,) bool, False where the fact is disputable.
    """

    pieces: NDArray[np.int64]
    facts: NDArray[np.int64]
    certain: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class RoomMap:
    """Rooms on the plan.

    Attributes:
        origin: (2,) x, y of the corner of cell [0, 0] [m].
        room: (rows, cols) int64, index in `House.rooms`; their number where there is none.
    """

    origin: NDArray[np.float64]
    room: NDArray[np.int64]

    def rooms_at(self, xy: NDArray[np.float64]) -> NDArray[np.int64]:
        """Indices (...) of the rooms at places (..., 2) [m]."""
        cells = np.floor((xy - self.origin) / CELL).astype(np.int64)
        size = np.array(self.room.shape[::-1])
        inside = ((cells >= 0) & (cells < size)).all(axis=-1)
        column, row = np.moveaxis(np.clip(cells, 0, size - 1), -1, 0)
        return np.asarray(np.where(inside, self.room[row, column], self.room[-1, -1]))


@dataclass(frozen=True, slots=True, eq=False)
class HouseFacts:
    """Facts of a house for captions.

    Attributes:
        house: The house.
        things: Class, colour and material of each piece.
        relations: Relations of two pieces.
        corners: Corners (N, 8, 3) of the pieces' bounding boxes in the world [m].
        rooms: Rooms on the plan.
    """

    house: House
    things: FactTable
    relations: FactTable
    corners: NDArray[np.float64]
    rooms: RoomMap

    @staticmethod
    def from_house(house: House) -> HouseFacts:
        """Compute the facts of a house."""
        looks: dict[int, Appearance] = {}
        for it in house.instances:
            if id(it.piece) not in looks:
                looks[id(it.piece)] = appearance(it.piece)
        things = [
            (i, FACT_INDEX[key], certain)
            for i, it in enumerate(house.instances)
            for key, certain in piece_facts(it.label, looks[id(it.piece)]).items()
            if key in FACT_INDEX
        ]
        pairs = [
            ((i, j), FACT_INDEX[key], certain)
            for i, j, key, certain in _pairs(house)
        ]  # fmt: skip
        corners = [_corners(it) for it in house.instances]
        return HouseFacts(
            house,
            _fact_table(things, (0,)),
            _fact_table(pairs, (0, 2)),
            np.array(corners).reshape(-1, 8, 3),
            _room_map(house.rooms),
        )


def piece_facts(label: str, look: Appearance) -> dict[str, bool]:
    """Keys of all facts of a piece alone; False where a fact is disputable."""
    known = () if label in COLOURLESS else look.colours
    # From near by a cushion or a leg may be all that is seen of a piece.
    colours = dict.fromkeys(look.traces if known else COLOURS, False)
    for colour in known:
        colours |= dict.fromkeys(COLOURS[colour], False)
    colours |= {colour: i == 0 for i, colour in enumerate(known)}
    materials = {
        word: name == look.material
        for name, word in MATERIALS.items()
        if look.material in (None, name) or {look.material, name} in _TOGETHER
    }
    adjectives = {"": True, **colours, **materials}
    said: dict[str, bool] = {}
    for thing, is_one in [
        *((near, False) for near in akin(label)),
        *((k, True) for k in kinds(label)),
    ]:
        for word, fits in adjectives.items():
            key = f"{word} {thing}".lstrip()
            said[key] = said.get(key, False) or (fits and is_one)
    return said


def _pairs(house: House) -> Iterator[tuple[int, int, str, bool]]:
    """Instances, key and certainty of every relation, in every wording."""
    names = [
        {**dict.fromkeys(akin(it.label), False), **dict.fromkeys(kinds(it.label), True)}
        for it in house.instances
    ]
    for i, j, relation, certain in related(house):
        for a, is_a in names[i].items():
            for b, is_b in names[j].items():
                first, second = sorted((a, b)) if relation == "next to" else (a, b)
                key = f"{first} {relation} {second}"
                if key in FACT_INDEX:
                    yield i, j, key, certain and is_a and is_b


def _fact_table(entries: Sequence[tuple[object, int, bool]], shape: tuple[int, ...]) -> FactTable:
    pieces = [piece for piece, _, _ in entries]
    return FactTable(
        np.array(pieces, np.int64) if entries else np.zeros(shape, np.int64),
        np.array([fact for _, fact, _ in entries], np.int64),
        np.array([certain for _, _, certain in entries], np.bool_),
    )


def _corners(it: Instance) -> NDArray[np.float64]:
    low, high = it.elevation, it.elevation + float(it.piece.size[2])
    return np.vstack([np.column_stack([it.footprint, np.full(4, z)]) for z in (low, high)])


def _room_map(rooms: Sequence[Room]) -> RoomMap:
    corners = np.vstack([np.zeros((1, 2)), *(room.polygon for room in rooms)])
    origin, far = corners.min(axis=0) - 2 * CELL, corners.max(axis=0) + 2 * CELL
    columns, rows = np.ceil((far - origin) / CELL).astype(int)
    drawn = np.full((rows, columns), len(rooms), np.int32)
    for i, room in enumerate(rooms):
        cells = np.round((room.polygon - origin) / CELL - 0.5).astype(np.int32)
        cv2.fillPoly(drawn, [cells], i)
    return RoomMap(origin, drawn.astype(np.int64))
