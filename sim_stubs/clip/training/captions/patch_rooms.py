"""Which rooms the patches of a picture show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from sim_stubs.clip.training.captions.facts import ATOM_INDEX
from sim_stubs.clip.training.captions.house_facts import HouseFacts, RoomMap
from sim_stubs.homes.vocabulary import ROOMS, room_of
from vizbot.core.types import SE3, Intrinsics

LARGE, MEDIUM = 0.55, 0.28
"""Widths of a patch as parts of the picture's: a room is told by the first, and less clearly by the
second; what is smaller can be any room."""
TELLING = (0.05, 0.12)
"""Share of a large and of a medium patch with things that a room is known by, at least."""
IN_ROOM = (0.25, 0.6)
"""Share of a patch in a room: below the first it is not shown, from the second on it is."""
LONG = (1.5, 3.0)
"""A hallway is told by a look along it: from the second on it is, and what ends before the first
is a wall, as any room has them [m]."""
DEEP = 1.25
"""A room is seen as a whole from farther than this [m]."""
KNOWN_BY: Mapping[str, frozenset[str]] = {
    "living room": frozenset({
        "sofa", "armchair", "tv", "tv stand", "coffee table", "fireplace", "piano", "aquarium",
    }),
    "kitchen": frozenset({
        "kitchen cabinet", "wall cabinet", "oven", "refrigerator", "range hood", "microwave",
        "dishwasher", "hob", "sink", "coffee machine", "kitchen island", "dining table", "toaster",
    }),
    "bathroom": frozenset({"bathtub", "toilet", "sink", "shower", "bidet", "towel", "towel rack"}),
    "bedroom": frozenset({
        "bed", "single bed", "nightstand", "wardrobe", "dressing table",
    }),
    "kid's room": frozenset({
        "bunk bed", "single bed", "crib", "teddy bear", "toy", "rocking horse", "doll",
    }),
    "laundry room": frozenset({"washing machine", "dryer", "laundry basket", "ironing board"}),
    "study": frozenset({"desk", "computer", "office chair", "bookshelf", "laptop", "printer"}),
}  # fmt: skip
"""Labels of the things that a room is known by; a hallway has none and is told by its length."""
AKIN: Mapping[str, tuple[str, ...]] = {
    "kid's room": ("bedroom",),
    "laundry room": ("bathroom",),
    "bathroom": ("laundry room",),
}
"""What a room may be called as well."""
STRIDE = 8
"""Every so many pixels, the room is looked up."""
_NEARER = 0.1
"""A wall belongs to the room it is seen from: pixels are taken nearer by this [m]."""


def rooms_seen(
    facts: HouseFacts,
    labels: Sequence[str],
    share: NDArray[np.float64],
    depth: NDArray[np.float32],
    T_world_cam: SE3,
    intrinsics: Intrinsics,
    boxes: NDArray[np.int32],
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """Strengths (P, 1) of each sort of room and of "room", with their columns in `ATOMS`.

    Args:
        facts: Of the house.
        labels: (V,) of the pieces that are in sight.
        share: (P, V) part of each patch that a piece takes up.
        depth: (H, W) true depth [m].
        T_world_cam: Where the picture was taken.
        intrinsics: Of the picture.
        boxes: (P, 4) of the patches [px].
    """
    width = (boxes[:, 2] - boxes[:, 0]) / intrinsics.width
    large = width >= LARGE
    least = np.where(large, TELLING[0], np.where(width >= MEDIUM, TELLING[1], np.inf))
    coarse = depth[::STRIDE, ::STRIDE]
    rooms = _rooms_of_pixels(facts.rooms, coarse, T_world_cam, intrinsics)
    count = len(facts.house.rooms) + 1
    shares, far = np.zeros((len(boxes), count)), np.zeros(len(boxes))
    for p, (u0, v0, u1, v1) in enumerate(-(-boxes // STRIDE)):
        patch = rooms[v0:v1, u0:u1].ravel()
        shares[p] = np.bincount(patch, minlength=count) / max(len(patch), 1)
        if large[p]:
            far[p] = np.percentile(coarse[v0:v1, u0:u1], 80)
    yield np.where(far > DEEP, 1.0, np.nan)[:, None], np.array([ATOM_INDEX["room"]])
    sorts = [room_of(room.name) for room in facts.house.rooms]
    for name in ROOMS:
        inside = shares[:, :-1] @ np.array([sort == name for sort in sorts], np.float64)
        near = shares[:, :-1] @ np.array(
            [name in AKIN.get(sort or "", ()) for sort in sorts], float
        )
        by = np.array([label in KNOWN_BY.get(name, ()) for label in labels], float)
        hallway = name == "hallway"
        told = far > LONG[1] if hallway else share @ by >= least
        strength = np.where(told, np.where(large, 1.0, 0.7), np.nan)
        strength[inside < IN_ROOM[1]] = np.nan
        if hallway:
            strength[large & (far < LONG[0])] = 0.0
        strength[(inside < IN_ROOM[0]) & (near < IN_ROOM[0])] = 0.0
        yield strength[:, None], np.array([ATOM_INDEX[name]])


def _rooms_of_pixels(
    rooms: RoomMap, coarse: NDArray[np.float32], T_world_cam: SE3, intrinsics: Intrinsics
) -> NDArray[np.int64]:
    """Index of the room that each pixel of the coarse depth image lies in."""
    z = np.maximum(coarse.astype(np.float64) - _NEARER, 0.0)
    v, u = np.indices(z.shape) * STRIDE
    x, y = (u - intrinsics.cx) / intrinsics.fx * z, (v - intrinsics.cy) / intrinsics.fy * z
    plan = T_world_cam[:2]
    return rooms.at(np.stack([x, y, z], axis=-1) @ plan[:, :3].T + plan[:, 3])
