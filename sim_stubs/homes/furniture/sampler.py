"""A sampler of furniture for homes: of sensible size, a third of it painted in one colour."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from sim_stubs.homes.furniture.fitting import Source, fitted
from sim_stubs.homes.furniture.paint import COLOURS, painted_in_shades
from sim_stubs.homes.geometry.solids import Piece
from vizbot.core.errors import ConfigError

ModelSampler = Callable[[str], Piece | None]
"""Returns one model of a class in a size for homes; None when there is none."""

DRAWS = 5
"""Most models drawn to find one that need not be made much smaller."""
SHRUNK = 0.8
"""Least scale at which a model still looks right."""
COLOURED = 1 / 3
"""Share of the pieces of a coloured class that are painted."""

LIMITS: Mapping[str, tuple[float, float, float]] = {
    "aquarium": (0.9, 0.4, 0.6),
    "armchair": (1.0, 0.95, 1.1),
    "bathtub": (1.75, 1.3, 0.85),
    "bed": (1.85, 2.15, 1.2),
    "bookshelf": (1.3, 0.42, 2.1),
    "bunk bed": (1.2, 2.2, 1.9),
    "ceiling lamp": (0.7, 0.7, 0.6),
    "chair": (0.6, 0.62, 1.1),
    "chest of drawers": (1.2, 0.5, 1.0),
    "coffee table": (1.2, 0.7, 0.5),
    "computer": (0.6, 0.5, 0.5),
    "crib": (0.75, 1.25, 1.1),
    "desk": (1.5, 0.8, 1.3),
    "dining table": (1.7, 1.0, 0.8),
    "dryer": (0.64, 0.64, 0.9),
    "electric fan": (0.4, 0.4, 0.5),
    "fireplace": (1.25, 0.45, 2.3),
    "flowers": (0.4, 0.4, 0.6),
    "kitchen cabinet": (0.9, 0.64, 0.92),
    "laundry basket": (0.5, 0.5, 0.65),
    "mirror": (0.8, 0.1, 1.2),
    "nightstand": (0.55, 0.5, 0.6),
    "office chair": (0.66, 0.66, 1.2),
    "oven": (0.75, 0.66, 1.0),
    "piano": (1.5, 1.75, 1.8),
    "picture": (0.9, 0.06, 0.8),
    "plant": (0.55, 0.55, 1.4),
    "radiator": (1.3, 0.16, 0.72),
    "range hood": (0.75, 0.5, 0.6),
    "refrigerator": (0.8, 0.75, 1.9),
    "shelf": (1.2, 0.42, 2.0),
    "shower": (0.95, 1.0, 2.1),
    "single bed": (1.0, 2.05, 1.1),
    "sink": (0.9, 0.62, 1.25),
    "sofa": (2.2, 1.1, 1.0),
    "stairs": (1.8, 1.8, 4.0),
    "suitcase": (0.7, 0.35, 0.75),
    "table lamp": (0.32, 0.32, 0.55),
    "teddy bear": (0.45, 0.4, 0.5),
    "trash can": (0.35, 0.35, 0.6),
    "tv": (1.2, 0.35, 0.75),
    "tv stand": (1.6, 0.5, 0.6),
    "vase": (0.22, 0.22, 0.38),
    "wall cabinet": (0.9, 0.4, 0.75),
    "wardrobe": (1.8, 0.66, 2.2),
    "washing machine": (0.64, 0.64, 0.9),
}
"""Largest size of a piece along x, y, z [m]; larger ones are scaled down."""

PAINTED = (
    "armchair", "bed", "bench", "bookshelf", "bunk bed", "carpet", "chair", "chest of drawers",
    "coffee table", "curtain", "desk", "kitchen cabinet", "laundry basket", "nightstand",
    "office chair", "single bed", "sofa", "stool", "suitcase", "trash can", "tv stand", "vase",
    "wardrobe",
)  # fmt: skip
"""Classes whose pieces may be painted."""


def model_sampler(source_of: Callable[[str], Source], rng: np.random.Generator) -> ModelSampler:
    """A sampler that fits pieces and paints some, as `rng` draws."""

    def piece(label: str) -> Piece | None:
        limit = np.array(LIMITS.get(label, (2.0, 2.0, 2.3)))
        best: tuple[float, Piece] | None = None
        source = source_of(label)
        for _ in range(DRAWS):
            try:
                drawn = source(label, rng)
            except ConfigError:  # neither a model nor a shape of this class
                return None
            scale = float((limit / drawn.size).min())
            if best is None or scale > best[0]:
                best = scale, drawn
            if scale >= SHRUNK:
                break
        assert best is not None
        fit = fitted(best[1], *limit)
        if label in PAINTED and rng.random() < COLOURED:
            rgb = list(COLOURS.values())[rng.integers(len(COLOURS))]
            return painted_in_shades(fit, (*rgb, 1.0))
        return fit

    return piece
