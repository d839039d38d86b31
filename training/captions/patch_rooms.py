"""Facts of rooms: which rooms the patches of a picture show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from training.captions.facts import FACT_INDEX
from training.captions.house_facts import HouseFacts, RoomMap
from vizbot.core.home_vocabulary import ROOMS, room_of
from vizbot.core.types import SE3, Intrinsics

LARGE, MEDIUM = 0.55, 0.28
"""Widths of a patch as shares of the picture's width: the first shows a room clearly, the second
less clearly; in smaller patches the room is disputable."""
TELLING = (0.05, 0.12)
"""Least shares of a large and of a medium patch with things that identify a room."""
IN_ROOM = (0.25, 0.6)
"""Shares of a patch in a room: below the first the room is not shown, from the second on it is."""
LONG = (1.5, 3.0)
"""Lengths of a view along a hallway [m]: from the second on it shows the hallway, below the first
it shows a wall, as in any room."""
DEEP = 1.25
"""Least depth of a view of a whole room [m]."""
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
"""Labels of the things that identify a room; a hallway has none and is known by its length."""
AKIN: Mapping[str, tuple[str, ...]] = {
    "kid's room": ("bedroom",),
    "laundry room": ("bathroom",),
    "bathroom": ("laundry room",),
}
"""Other names that a room may have."""
STRIDE = 8
"""Step between the pixels whose room is looked up [px]."""
_NEARER = 0.1
"""Distance by which pixels are moved nearer [m]; a wall belongs to the room of its viewer."""


def rooms_seen(
    house_facts: HouseFacts,
    labels: Sequence[str],
    share: NDArray[np.float64],
    depth: NDArray[np.float32],
    T_world_cam: SE3,
    intrinsics: Intrinsics,
    boxes: NDArray[np.int32],
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """Strengths (P, 1) of each kind of room and of "room", with their columns in `FACTS`.

    Args:
        house_facts: Facts of the house.
        labels: Labels (V,) of the visible pieces.
        share: (P, V) share of each patch that a piece takes up.
        depth: (H, W) true depth [m].
        T_world_cam: Pose of the camera.
        intrinsics: Intrinsics of the picture.
        boxes: Boxes (P, 4) of the patches [px].
    """
    width = (boxes[:, 2] - boxes[:, 0]) / intrinsics.width
    large = width >= LARGE
    least = np.where(large, TELLING[0], np.where(width >= MEDIUM, TELLING[1], np.inf))
    coarse = depth[::STRIDE, ::STRIDE]
    rooms = _rooms_of_pixels(house_facts.rooms, coarse, T_world_cam, intrinsics)
    count = len(house_facts.house.rooms) + 1
    shares, far = np.zeros((len(boxes), count)), np.zeros(len(boxes))
    for p, (u0, v0, u1, v1) in enumerate(-(-boxes // STRIDE)):
        patch = rooms[v0:v1, u0:u1].ravel()
        shares[p] = np.bincount(patch, minlength=count) / max(len(patch), 1)
        if large[p]:
            far[p] = np.percentile(coarse[v0:v1, u0:u1], 80)
    yield np.where(far > DEEP, 1.0, np.nan)[:, None], np.array([FACT_INDEX["room"]])
    sorts = [room_of(room.name) for room in house_facts.house.rooms]
    for name in ROOMS:
        inside = shares[:, :-1] @ np.array([sort == name for sort in sorts], np.float64)
        near = shares[:, :-1] @ np.array(
            [name in AKIN.get(sort or "", ()) for sort in sorts], float
        )
        by = np.array([label in KNOWN_BY.get(name, ()) for label in labels], float)
        hallway = name == "hallway"
        shown = far > LONG[1] if hallway else share @ by >= least
        strength = np.where(shown, np.where(large, 1.0, 0.7), np.nan)
        strength[inside < IN_ROOM[1]] = np.nan
        if hallway:
            strength[large & (far < LONG[0])] = 0.0
        strength[(inside < IN_ROOM[0]) & (near < IN_ROOM[0])] = 0.0
        yield strength[:, None], np.array([FACT_INDEX[name]])


def _rooms_of_pixels(
    rooms: RoomMap, coarse: NDArray[np.float32], T_world_cam: SE3, intrinsics: Intrinsics
) -> NDArray[np.int64]:
    """Index of the room that each pixel of the coarse depth image lies in."""
    z = np.maximum(coarse.astype(np.float64) - _NEARER, 0.0)
    v, u = np.indices(z.shape) * STRIDE
    x, y = (u - intrinsics.cx) / intrinsics.fx * z, (v - intrinsics.cy) / intrinsics.fy * z
    plan = T_world_cam[:2]
    return rooms.rooms_at(np.stack([x, y, z], axis=-1) @ plan[:, :3].T + plan[:, 3])
