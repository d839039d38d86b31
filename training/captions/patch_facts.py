"""True facts of patches of a picture of a home, on which the truth of captions rests.

A thing is shown the more clearly, the more of the patch it takes up, because the robot drives to
where the patch is. A thing that is too small, or of which the patch shows too little, is
disputable.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from training.captions.facts import COUNTED, FACT_INDEX, FACTS, Facts
from training.captions.house_facts import FactTable, HouseFacts, RoomMap
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
__all__ = ["Facts", "seen"]
FAINT, CLEAR, FULL = 0.003, 0.015, 0.25
"""Shares of a patch: below the first a thing is not shown, from the second on it is, from the third
on with strength 1."""
WEAKEST = 0.3
"""Strength of a thing that is just shown."""
SLIVER, MUCH = (0.12, 0.05), (0.1, 0.3)
"""Parts of a whole thing below which it is disputable. The first holds where it takes up little of
the patch (the first share), the second where it takes up much."""
MOST = 0.4
"""Part of a whole thing from which it is shown with full strength."""
OPEN_WORK = 2.0
"""Largest ratio of the area of a thing with gaps to its pixels."""
COLOURED = 0.5
"""Strength below which the colour of a thing is disputable: half of it may be another thing."""
WITHIN = (0.8, 0.5)
"""A patch that less than the second part of a thing fills to the first part shows no outline: the
thing is disputable."""
_DEEPEST = -0.4
"""Height below which the floor hides everything [m]."""
_NEAREST = 0.3
"""Depth that corners beside or behind the camera get [m]."""


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


@dataclass(frozen=True, slots=True, eq=False)
class _Glimpse:
    """V visible pieces in P patches.

    Attributes:
        pieces: (V,) int64, index in `House.instances`.
        share: (P, V) share of each patch that a piece takes up.
        whole: (P, V) share of each piece's full view that is in the patch; 0 where the patch lies
            within the piece.
    """

    pieces: NDArray[np.int64]
    share: NDArray[np.float64]
    whole: NDArray[np.float64]


def seen(
    house_facts: HouseFacts,
    segmentation: NDArray[np.int32],
    depth: NDArray[np.float32],
    T_world_cam: SE3,
    intrinsics: Intrinsics,
    boxes: NDArray[np.int32],
) -> Facts:
    """Compute how clearly each patch shows each fact.

    Args:
        house_facts: Facts of the house, computed once for all of its pictures.
        segmentation: (H, W), index in `House.instances`, -1 for structure.
        depth: (H, W) true depth [m], 0 where nothing is.
        T_world_cam: Pose of the camera.
        intrinsics: Intrinsics of the picture.
        boxes: (P, 4) u0, v0, u1, v1 of the patches [px], ends excluded.
    """
    glimpse = _glimpse(house_facts, segmentation, T_world_cam, intrinsics, boxes)
    labels = [house_facts.house.instances[i].label for i in glimpse.pieces]
    facets = [
        _things(house_facts.things, glimpse),
        _relations(house_facts.relations, glimpse),
        *_counts(house_facts.things, glimpse),
        *rooms_seen(house_facts, labels, glimpse.share, depth, T_world_cam, intrinsics, boxes),
    ]
    return Facts.from_dense(
        np.hstack([strengths for strengths, _ in facets]).astype(np.float32),
        np.concatenate([facts for _, facts in facets]),
    )


def _glimpse(
    house_facts: HouseFacts,
    segmentation: NDArray[np.int32],
    T_world_cam: SE3,
    intrinsics: Intrinsics,
    boxes: NDArray[np.int32],
) -> _Glimpse:
    spans = find_objects(segmentation + 1)
    found = [i for i, span in enumerate(spans) if span is not None]
    count = len(house_facts.house.instances) + 1
    areas = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
    pixels = np.array(
        [np.bincount(segmentation[v0:v1, u0:u1].ravel() + 1, minlength=count)[1:]
         for u0, v0, u1, v1 in boxes]
    ).reshape(len(boxes), count - 1)[:, found]  # fmt: skip
    visible = np.bincount(segmentation.ravel() + 1, minlength=count)[1:][found]
    extent = [(spans[i][0].stop - spans[i][0].start) * (spans[i][1].stop - spans[i][1].start)
              for i in found]  # fmt: skip
    spread = np.clip(np.array(extent) / visible, 1.0, OPEN_WORK)
    whole = [_projected_area(house_facts.corners[i], T_world_cam, intrinsics) for i in found]
    taken = pixels * spread
    part = np.minimum(taken / np.maximum(whole, 1.0), 1.0)
    part[(pixels > WITHIN[0] * areas[:, None]) & (part < WITHIN[1])] = 0.0
    share = np.minimum(taken / areas[:, None], 1.0)
    return _Glimpse(np.array(found, np.int64), share, part)


def _projected_area(
    corners: NDArray[np.float64], T_world_cam: SE3, intrinsics: Intrinsics
) -> float:
    """Area of a box (8, 3) in a picture twice as wide and high, if nothing hid it [px].

    The limit of the picture matters for carpets that the robot stands on.
    """
    corners = np.column_stack([corners[:, :2], np.maximum(corners[:, 2], _DEEPEST)])
    points = (corners - T_world_cam[:3, 3]) @ T_world_cam[:3, :3]
    depth = np.maximum(points[:, 2:], _NEAREST)
    size = np.array([intrinsics.width, intrinsics.height])
    pixels = np.clip(points[:, :2] / depth * (intrinsics.fx, intrinsics.fy), -size, size)
    return float(cv2.contourArea(cv2.convexHull(pixels.astype(np.float32))))


def _clearness(share: NDArray[np.float64], whole: NDArray[np.float64]) -> NDArray[np.float64]:
    """Strengths of things with this share of a patch: 0, NaN where disputable, up to 1."""
    grade = (np.sqrt(share) - np.sqrt(CLEAR)) / (np.sqrt(FULL) - np.sqrt(CLEAR))
    part = np.clip((whole - SLIVER[1]) / (MOST - SLIVER[1]), 0.0, 1.0)
    strength = WEAKEST + (1 - WEAKEST) * np.clip(grade, 0.0, 1.0) * (0.4 + 0.6 * part)
    strength[(share < CLEAR) | (whole < np.interp(share, MUCH, SLIVER))] = np.nan
    strength[share < FAINT] = 0.0
    return np.asarray(strength)


def _in_sight(table: FactTable, glimpse: _Glimpse) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Columns in the glimpse of each fact's pieces, and which facts are about visible pieces."""
    last = int(max(table.pieces.max(initial=0), glimpse.pieces.max(initial=0)))
    column_of = np.full(last + 1, -1)
    column_of[glimpse.pieces] = np.arange(len(glimpse.pieces))
    columns = column_of[table.pieces]
    kept: NDArray[np.bool_] = columns >= 0
    if kept.ndim == 2:
        kept = kept[:, 0] & kept[:, 1]
    return columns, kept


Facet = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Strengths (P, C) of some facts, and the facts' columns in `FACTS` (C,)."""


def _things(things: FactTable, glimpse: _Glimpse) -> Facet:
    """Facts of things with their colours and materials; equal things count together."""
    columns, kept = _in_sight(things, glimpse)
    facts, inverse = np.unique(things.facts[kept], return_inverse=True)
    said = np.zeros((2, len(glimpse.pieces), len(facts)))
    said[things.certain[kept].astype(int), columns[kept], inverse] = 1.0
    maybe, certain = glimpse.share @ said
    whole = np.zeros_like(certain)
    for piece, is_one in enumerate(said[1] > 0):
        whole[:, is_one] = np.maximum(whole[:, is_one], glimpse.whole[:, piece, None])
    strengths = _clearness(np.minimum(certain, 1.0), whole)
    strengths[(maybe >= FAINT) & (maybe > certain)] = np.nan
    coloured = np.array([bool(FACTS[fact].colour) for fact in facts], bool)
    strengths[(strengths > 0) & (strengths < COLOURED) & coloured] = np.nan
    return strengths, facts


def _relations(relations: FactTable, glimpse: _Glimpse) -> Facet:
    """Facts of relations whose two pieces are both shown, as clearly as both together."""
    columns, kept = _in_sight(relations, glimpse)
    order = np.flatnonzero(kept)[np.argsort(relations.facts[kept], kind="stable")]
    facts, first = np.unique(relations.facts[order], return_index=True)
    if len(facts) == 0:
        return np.zeros((len(glimpse.share), 0)), facts
    a, b = columns[order].T
    lesser = np.minimum(glimpse.share[:, a], glimpse.share[:, b])
    both = np.minimum(glimpse.share[:, a] + glimpse.share[:, b], 1.0)
    strengths = _clearness(both, np.minimum(glimpse.whole[:, a], glimpse.whole[:, b]))
    strengths[(lesser < CLEAR) | ~relations.certain[order]] = np.nan
    strengths[lesser < FAINT] = 0.0
    best = np.fmax.reduceat(strengths, first, axis=1)
    disputed = np.logical_or.reduceat(np.isnan(strengths), first, axis=1)
    return np.where(disputed & ~(best > 0), np.nan, best), facts


def _counts(things: FactTable, glimpse: _Glimpse) -> Iterator[Facet]:
    """Facts of two of a kind, and of three or more."""
    columns, kept = _in_sight(things, glimpse)
    clear = (glimpse.share >= CLEAR) & (glimpse.whole >= SLIVER[0])
    for thing in COUNTED:
        those = kept & (things.facts == FACT_INDEX[thing])
        if np.count_nonzero(those) < 2:
            continue
        certain = clear[:, columns[those & things.certain]].sum(axis=1)
        possible = (glimpse.share[:, columns[those]] >= FAINT / 2).sum(axis=1)
        together = np.minimum(glimpse.share[:, columns[those & things.certain]].sum(axis=1), 1.0)
        strength = _clearness(together, np.ones_like(together))
        two = np.where((certain == 2) & (possible == 2), strength, np.nan)
        several = np.where(certain >= 3, strength, np.nan)
        two[possible < 2], several[possible < 3] = 0.0, 0.0
        named = [FACT_INDEX[f"two {thing}"], FACT_INDEX[f"several {thing}"]]
        yield np.column_stack([two, several]), np.array(named)
