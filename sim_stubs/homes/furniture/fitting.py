"""Slots for furniture on a plan, and how pieces are fitted into them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.bounding_block import FACING
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.solids import Piece, stretched

Source = Callable[[str, np.random.Generator], Piece]
"""Returns one model of a class."""


@dataclass(frozen=True, slots=True)
class Slot:
    """A place for furniture.

    Attributes:
        label: Class of the piece.
        x: Middle of the piece's back [m].
        y: Middle of the piece's back [m].
        facing: Direction of its front: N, E, S or W.
        width: Largest width along its front [m]; larger pieces are scaled down.
        depth: Largest depth from back to front [m].
        elevation: Height of its underside [m].
        fill: Whether a piece of another size is stretched to just this width and depth.
        height: Largest height [m]; flat things are driven over.
        on: Label of an earlier piece that it stands on, which gives the elevation.
    """

    label: str
    x: float
    y: float
    facing: str
    width: float
    depth: float
    elevation: float = 0.0
    fill: bool = False
    height: float = inf
    on: str = ""


def furnished(
    slots: Sequence[Slot], source: Source, rng: np.random.Generator
) -> tuple[Instance, ...]:
    """A piece in each slot; equal labels share two models at most, as in a home."""
    models: dict[str, list[Piece]] = {}
    count: Counter[str] = Counter()
    newest: dict[str, Instance] = {}
    instances = []
    for slot in slots:
        drawn = models.setdefault(slot.label, [])
        many = 12 if slot.label in ("picture", "carpet", "plant") else 1
        if len(drawn) < many:
            drawn.append(source(slot.label, rng))
        piece = fitted(drawn[-1], slot.width, slot.depth, slot.height, fill=slot.fill)
        count[slot.label] += 1
        yaw = FACING[slot.facing]
        depth = piece.size[1] / 2
        x, y = slot.x + np.sin(yaw) * depth, slot.y - np.cos(yaw) * depth
        name = f"{slot.label}#{count[slot.label]}"
        elevation, on = slot.elevation, ""
        if slot.on:
            below = newest[slot.on]
            elevation, on = below.elevation + float(below.piece.size[2]), below.name
        instance = Instance(name, piece, float(x), float(y), yaw, elevation, on)
        newest[slot.label] = instance
        instances.append(instance)
    return tuple(instances)


def fitted(
    piece: Piece, width: float, depth: float, height: float = inf, *, fill: bool = False
) -> Piece:
    """The piece scaled down until it fits [m]; with `fill`, stretched to that width and depth."""
    room = np.array([width, depth, height]) / piece.size
    scale = np.array([*room[:2], min(1.0, room[2])]) if fill else np.full(3, min(1.0, room.min()))
    return stretched_piece(piece, scale)


def stretched_piece(piece: Piece, scale: NDArray[np.float64]) -> Piece:
    """The piece stretched by `scale` (3,) along x, y, z."""
    if np.allclose(scale, 1.0):
        return piece
    return replace(piece, size=piece.size * scale, parts=tuple(stretched(piece.parts, scale)))
