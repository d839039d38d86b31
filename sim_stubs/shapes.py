"""Furniture of our own: plain shapes, recognisable and metric, for homes without a catalogue."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from sim_stubs import decor, fittings, woodwork
from sim_stubs.joinery import PORCELAIN, STEEL, Random, any_wood, cabinet
from sim_stubs.piece import Part, Piece
from sim_stubs.solids import by_material, cylinder, moved, triangles
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import planar


def piece(label: str, rng: Random) -> Piece:
    """One model of the class `label`, in a size and colour drawn by `rng`.

    Raises:
        ConfigError: there is no shape for `label`.
    """
    if label not in SHAPES:
        raise ConfigError(f"no shape for {label!r}; take one of {', '.join(sorted(SHAPES))}")
    parts = by_material(SHAPES[label](rng))
    corners = triangles(parts).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y = (low + high)[:2] / 2
    centred = planar(-x, -y, 0.0)
    return Piece(label, label, high - low, tuple(moved(part, centred) for part in parts), "")


def recoloured(piece: Piece, label: str, rgb: tuple[float, float, float]) -> Piece:
    """`piece` in one plain colour, as an instance of `label`."""
    rgba = np.array([*rgb, 1.0], np.float32)
    parts = by_material([replace(part, rgba=rgba, texture=None) for part in piece.parts])
    return replace(piece, label=label, parts=parts)


SHAPES: Mapping[str, Callable[[Random], list[Part]]] = {
    "armchair": lambda rng: woodwork.sofa(rng, 0.9, 1),
    "bathtub": fittings.bathtub,
    "bed": woodwork.bed,
    "bookshelf": decor.bookshelf,
    "carpet": decor.carpet,
    "chair": woodwork.chair,
    "chest of drawers": lambda rng: cabinet(s := any_wood(rng), 0.9, 0.42, 0.85, 4, 1, s),
    "coffee table": lambda rng: woodwork.table(rng, 1.0, 0.55, 0.42),
    "computer": decor.computer,
    "desk": woodwork.desk,
    "dining table": lambda rng: woodwork.table(rng, 1.3, 0.8, 0.75),
    "floor lamp": lambda rng: decor.lamp(rng, 1.6, 0.2),
    "kitchen cabinet": fittings.kitchen_cabinet,
    "laundry basket": decor.laundry_basket,
    "microwave": fittings.microwave,
    "mirror": decor.mirror,
    "nightstand": lambda rng: cabinet(s := any_wood(rng), 0.42, 0.38, 0.5, 2, 1, s),
    "office chair": woodwork.office_chair,
    "oven": fittings.oven,
    "picture": decor.picture,
    "plant": decor.plant,
    "refrigerator": fittings.refrigerator,
    "single bed": lambda rng: woodwork.bed(rng, 0.95),
    "sink": fittings.sink_cabinet,
    "sofa": woodwork.sofa,
    "table lamp": lambda rng: decor.lamp(rng, 0.42, 0.13),
    "toilet": fittings.toilet,
    "trash can": lambda rng: [cylinder((0, 0, 0), 0.12, 0.34, STEEL, 0.15)],
    "tv": decor.tv,
    "tv stand": lambda rng: cabinet(any_wood(rng), 1.5, 0.4, 0.45, 1, 3, PORCELAIN),
    "wardrobe": woodwork.wardrobe,
    "washing machine": fittings.washing_machine,
}
"""Shapes by label, in the words of the catalogue's classes."""
