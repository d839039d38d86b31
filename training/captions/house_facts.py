"""Facts of a house that hold from every viewpoint: classes, looks and relations of its pieces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furniture.appearance import Appearance, appearance
from sim_stubs.homes.geometry.house import House, Instance, Room
from training.captions.facts import FACT_INDEX
from vizbot.core.home_vocabulary import COLOURLESS, COLOURS, MATERIALS, akin, kinds

Relation = Literal["on", "next to", "in front of", "above"]
BESIDE = 0.5
"""Gap below which things stand next to each other [m]."""
AROUND = 1.2
"""Gap below which it is disputable whether things stand next to each other [m]."""
TUCKED = -0.35
"""Negative gap of a chair that is pushed under its table [m]."""
BEFORE = 1.0
"""Largest distance of a thing in front of another [m]."""
HANGING = 1.8
"""Largest distance of a thing that hangs above another [m]."""
TOUCHING = 0.08
"""Largest gap below a thing that stands on another [m]."""
CELL = 0.05
"""Edge of a cell of a `RoomMap` [m]."""
_TOGETHER = ({"metal", "glass"}, {"wood", "metal"}, {"metal", "plastic"}, {"fabric", "wood"},
             {"fabric", "metal"}, {"leather", "metal"}, {"leather", "wood"})  # fmt: skip
"""Materials that often occur in one piece: where one is known, the other is disputable."""


def related(house: House) -> Iterator[tuple[int, int, Relation, bool]]:
    """Pairs i, j of instances, the relation of i to j, and whether it is certain or disputable."""
    if not house.instances:
        return
    plan = _Plan.from_house(house)
    names = {it.name: i for i, it in enumerate(house.instances)}
    stands_on = {(i, names[it.on]) for i, it in enumerate(house.instances) if it.on in names}
    near = (plan.gap < BEFORE + AROUND) & plan.same_room & ~np.eye(len(names), dtype=bool)
    for i, j in np.argwhere(near):
        a, b = int(i), int(j)
        gap, rise = float(plan.gap[a, b]), float(plan.low[a] - plan.high[b])
        x, y = plan.local[a, b]
        w, d = plan.half[b]
        over = abs(x) < w and abs(y) < d
        if plan.flat[b]:
            if gap < 0 and plan.low[a] < 0.1 and not plan.flat[a]:
                yield a, b, "on", bool(over)
        elif (a, b) in stands_on or (over and abs(rise) < TOUCHING and plan.low[a] > TOUCHING):
            yield a, b, "on", True
            continue
        level = min(plan.high[a], plan.high[b]) - max(plan.low[a], plan.low[b]) > 0.05
        if (
            not (plan.flat[a] or plan.flat[b])
            and a < b
            and gap < AROUND
            and (b, a) not in stands_on
        ):
            yield a, b, "next to", bool(level and TUCKED < gap < BESIDE)
        if rise > TOUCHING and gap < 0.8:
            yield a, b, "above", bool(gap < 0.15 and abs(x) < w + 0.2 and rise < HANGING)
        elif not plan.flat[b] and gap < BEFORE + 0.5:
            yield (
                a,
                b,
                "in front of",
                bool(y < -d and abs(x) < w and gap < BEFORE and level | plan.flat[a]),
            )


@dataclass(frozen=True, slots=True, eq=False)
class _Plan:
    """Positions and sizes of N pieces.

    Attributes:
        low: (N,) heights of their undersides [m].
        high: (N,) heights of their tops [m].
        half: (N, 2) half of their width and depth [m].
        local: (N, N, 2) middle of i as j sees it: x to its left, -y before its front [m].
        gap: (N, N) between two footprints [m]; below 0 they overlap by that much.
        flat: (N,) whether it is a carpet.
        same_room: (N, N) whether no wall is between them.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    half: NDArray[np.float64]
    local: NDArray[np.float64]
    gap: NDArray[np.float64]
    flat: NDArray[np.bool_]
    same_room: NDArray[np.bool_]

    @staticmethod
    def from_house(house: House) -> _Plan:
        pieces = house.instances
        low = np.array([it.elevation for it in pieces])
        yaw = np.array([it.yaw for it in pieces])
        centre = np.array([(it.x, it.y) for it in pieces])
        half = np.array([it.piece.size[:2] for it in pieces]) / 2
        feet = np.array([it.footprint for it in pieces])
        axes = np.stack([np.stack([np.cos(yaw), np.sin(yaw)], -1),
                         np.stack([-np.sin(yaw), np.cos(yaw)], -1)], 1)  # fmt: skip
        # Corners of i along the axes of j: i, corner, j, axis.
        along = np.einsum("icx,jax->icja", feet, axes) - np.einsum("jx,jax->ja", centre, axes)
        apart = np.maximum(along.min(1) - half, -half - along.max(1))
        gap = np.where((apart > 0).all(-1), np.hypot(apart[..., 0], apart[..., 1]), apart.max(-1))
        rooms = [house.room_at(it.x, it.y) for it in pieces]
        number = np.array([-1 if room is None else house.rooms.index(room) for room in rooms])
        return _Plan(
            low=low,
            high=low + np.array([it.piece.size[2] for it in pieces]),
            half=half,
            local=np.einsum("ijx,jax->ija", centre[:, None] - centre, axes),
            gap=np.maximum(gap, gap.T),
            flat=np.array(["carpet" in kinds(it.label) for it in pieces]),
            same_room=(number[:, None] == number) | (number[:, None] < 0) | (number < 0),
        )


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
