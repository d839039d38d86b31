"""What patches of a picture of a home truly show, as atoms: the truth that captions are told by.

A thing counts the more clearly the more of the patch it takes up, because the robot drives to where
the patch is; what is too small, or too little of it in the patch, counts neither way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from sim_stubs.clip.training.captions.facts import ATOM_INDEX, ATOMS, COUNTED, Facts
from sim_stubs.clip.training.captions.house_facts import FactTable, HouseFacts
from sim_stubs.clip.training.captions.patch_rooms import rooms_seen
from vizbot.core.types import SE3, Intrinsics

__all__ = ["Facts", "seen"]

FAINT, CLEAR, FULL = 0.003, 0.015, 0.25
"""Share of a patch: below the first a thing is not shown, from the second on it is, from the third
on as clearly as can be."""
WEAKEST = 0.3
"""Strength of what is just shown."""
SLIVER, MUCH = (0.12, 0.05), (0.1, 0.3)
"""Part of a whole thing that is in the patch: below this it may be anything. The first holds where
it takes up little of the patch (the first share), the second where much."""
MOST = 0.4
"""Part of a whole thing that is as clear as can be."""
OPEN_WORK = 2.0
"""A thing with gaps takes up its bounding box, at most this many times its pixels."""
COLOURED = 0.5
"""The colour of what is shown less clearly may be any: half of it may be of another."""
WITHIN = (0.8, 0.5)
"""A patch that is filled to the first part by less than the second part of a thing shows no
outline: it may be anything."""

_DEEPEST = -0.4
"""What lies lower is hidden by the floor [m]."""
_NEAREST = 0.3
"""Corners beside or behind the camera count as so far before it [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class _Glimpse:
    """V pieces that are in sight, in P patches.

    Attributes:
        pieces: (V,) int64, index in `House.instances`.
        share: (P, V) part of each patch that a piece takes up.
        whole: (P, V) part of each piece, seen in full, that is in the patch; 0 where the patch lies
            within it.
    """

    pieces: NDArray[np.int64]
    share: NDArray[np.float64]
    whole: NDArray[np.float64]


def seen(
    facts: HouseFacts,
    segmentation: NDArray[np.int32],
    depth: NDArray[np.float32],
    T_world_cam: SE3,
    intrinsics: Intrinsics,
    boxes: NDArray[np.int32],
) -> Facts:
    """How clearly each patch shows each atom.

    Args:
        facts: Of the house, by `HouseFacts.of(house)`: once for all of its pictures.
        segmentation: (H, W), index in `House.instances`, -1 for structure.
        depth: (H, W) true depth [m], 0 where nothing is.
        T_world_cam: Where the picture was taken.
        intrinsics: Of the picture.
        boxes: (P, 4) u0, v0, u1, v1 of the patches [px], the end not included.
    """
    glimpse = _glimpse(facts, segmentation, T_world_cam, intrinsics, boxes)
    labels = [facts.house.instances[i].label for i in glimpse.pieces]
    facets = [
        _things(facts.things, glimpse),
        _relations(facts.relations, glimpse),
        *_counts(facts.things, glimpse),
        *rooms_seen(facts, labels, glimpse.share, depth, T_world_cam, intrinsics, boxes),
    ]
    return Facts.from_dense(
        np.hstack([strengths for strengths, _ in facets]).astype(np.float32),
        np.concatenate([atoms for _, atoms in facets]),
    )


def _glimpse(
    facts: HouseFacts,
    segmentation: NDArray[np.int32],
    T_world_cam: SE3,
    intrinsics: Intrinsics,
    boxes: NDArray[np.int32],
) -> _Glimpse:
    spans = find_objects(segmentation + 1)
    found = [i for i, span in enumerate(spans) if span is not None]
    count = len(facts.house.instances) + 1
    areas = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
    pixels = np.array(
        [np.bincount(segmentation[v0:v1, u0:u1].ravel() + 1, minlength=count)[1:]
         for u0, v0, u1, v1 in boxes]
    ).reshape(len(boxes), count - 1)[:, found]  # fmt: skip
    visible = np.bincount(segmentation.ravel() + 1, minlength=count)[1:][found]
    extent = [(spans[i][0].stop - spans[i][0].start) * (spans[i][1].stop - spans[i][1].start)
              for i in found]  # fmt: skip
    spread = np.clip(np.array(extent) / visible, 1.0, OPEN_WORK)
    whole = [_projected_area(facts.corners[i], T_world_cam, intrinsics) for i in found]
    taken = pixels * spread
    part = np.minimum(taken / np.maximum(whole, 1.0), 1.0)
    part[(pixels > WITHIN[0] * areas[:, None]) & (part < WITHIN[1])] = 0.0
    share = np.minimum(taken / areas[:, None], 1.0)
    return _Glimpse(np.array(found, np.int64), share, part)


def _projected_area(
    corners: NDArray[np.float64], T_world_cam: SE3, intrinsics: Intrinsics
) -> float:
    """Of a box (8, 3) in a picture twice as wide and high, were nothing before it [px].

    A carpet that the robot stands on reaches beyond it, and what lies there is not waited for.
    """
    corners = np.column_stack([corners[:, :2], np.maximum(corners[:, 2], _DEEPEST)])
    points = (corners - T_world_cam[:3, 3]) @ T_world_cam[:3, :3]
    depth = np.maximum(points[:, 2:], _NEAREST)
    size = np.array([intrinsics.width, intrinsics.height])
    pixels = np.clip(points[:, :2] / depth * (intrinsics.fx, intrinsics.fy), -size, size)
    return float(cv2.contourArea(cv2.convexHull(pixels.astype(np.float32))))


def _clearness(share: NDArray[np.float64], whole: NDArray[np.float64]) -> NDArray[np.float64]:
    """Strengths of what takes up this share of a patch: 0, NaN where open to dispute, up to 1."""
    grade = (np.sqrt(share) - np.sqrt(CLEAR)) / (np.sqrt(FULL) - np.sqrt(CLEAR))
    part = np.clip((whole - SLIVER[1]) / (MOST - SLIVER[1]), 0.0, 1.0)
    strength = WEAKEST + (1 - WEAKEST) * np.clip(grade, 0.0, 1.0) * (0.4 + 0.6 * part)
    strength[(share < CLEAR) | (whole < np.interp(share, MUCH, SLIVER))] = np.nan
    strength[share < FAINT] = 0.0
    return np.asarray(strength)


def _in_sight(told: FactTable, glimpse: _Glimpse) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Column in the glimpse of each fact's pieces, and which facts are about pieces in sight."""
    last = int(max(told.pieces.max(initial=0), glimpse.pieces.max(initial=0)))
    column_of = np.full(last + 1, -1)
    column_of[glimpse.pieces] = np.arange(len(glimpse.pieces))
    columns = column_of[told.pieces]
    kept: NDArray[np.bool_] = columns >= 0
    if kept.ndim == 2:
        kept = kept[:, 0] & kept[:, 1]
    return columns, kept


Facet = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Strengths (P, C) of some atoms, and the atoms' columns in `ATOMS` (C,)."""


def _things(things: FactTable, glimpse: _Glimpse) -> Facet:
    """Things with their colours and materials; equal ones count together."""
    columns, kept = _in_sight(things, glimpse)
    atoms, of = np.unique(things.atoms[kept], return_inverse=True)
    said = np.zeros((2, len(glimpse.pieces), len(atoms)))
    said[things.certain[kept].astype(int), columns[kept], of] = 1.0
    maybe, certain = glimpse.share @ said
    whole = np.zeros_like(certain)
    for piece, is_one in enumerate(said[1] > 0):
        whole[:, is_one] = np.maximum(whole[:, is_one], glimpse.whole[:, piece, None])
    strengths = _clearness(np.minimum(certain, 1.0), whole)
    strengths[(maybe >= FAINT) & (maybe > certain)] = np.nan
    coloured = np.array([bool(ATOMS[atom].colour) for atom in atoms], bool)
    strengths[(strengths > 0) & (strengths < COLOURED) & coloured] = np.nan
    return strengths, atoms


def _relations(relations: FactTable, glimpse: _Glimpse) -> Facet:
    """Relations whose two pieces are both shown; as clear as both are together."""
    columns, kept = _in_sight(relations, glimpse)
    order = np.flatnonzero(kept)[np.argsort(relations.atoms[kept], kind="stable")]
    atoms, first = np.unique(relations.atoms[order], return_index=True)
    if len(atoms) == 0:
        return np.zeros((len(glimpse.share), 0)), atoms
    a, b = columns[order].T
    lesser = np.minimum(glimpse.share[:, a], glimpse.share[:, b])
    both = np.minimum(glimpse.share[:, a] + glimpse.share[:, b], 1.0)
    strengths = _clearness(both, np.minimum(glimpse.whole[:, a], glimpse.whole[:, b]))
    strengths[(lesser < CLEAR) | ~relations.certain[order]] = np.nan
    strengths[lesser < FAINT] = 0.0
    best = np.fmax.reduceat(strengths, first, axis=1)
    disputed = np.logical_or.reduceat(np.isnan(strengths), first, axis=1)
    return np.where(disputed & ~(best > 0), np.nan, best), atoms


def _counts(things: FactTable, glimpse: _Glimpse) -> Iterator[Facet]:
    """Two of a kind; three or more."""
    columns, kept = _in_sight(things, glimpse)
    clear = (glimpse.share >= CLEAR) & (glimpse.whole >= SLIVER[0])
    for thing in COUNTED:
        those = kept & (things.atoms == ATOM_INDEX[thing])
        if np.count_nonzero(those) < 2:
            continue
        certain = clear[:, columns[those & things.certain]].sum(axis=1)
        possible = (glimpse.share[:, columns[those]] >= FAINT / 2).sum(axis=1)
        together = np.minimum(glimpse.share[:, columns[those & things.certain]].sum(axis=1), 1.0)
        strength = _clearness(together, np.ones_like(together))
        two = np.where((certain == 2) & (possible == 2), strength, np.nan)
        several = np.where(certain >= 3, strength, np.nan)
        two[possible < 2], several[possible < 3] = 0.0, 0.0
        named = [ATOM_INDEX[f"two {thing}"], ATOM_INDEX[f"several {thing}"]]
        yield np.column_stack([two, several]), np.array(named)
