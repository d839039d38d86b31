"""Materials and components that our own furniture shares."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sim_stubs import textures
from sim_stubs.piece import Part
from sim_stubs.solids import Surface, box

Random = np.random.Generator

PORCELAIN = (0.86, 0.87, 0.88)
STEEL = (0.62, 0.64, 0.67)
BLACK = (0.07, 0.07, 0.08)
WOODS = ((0.42, 0.27, 0.18), (0.30, 0.19, 0.13), (0.58, 0.42, 0.32))
CLOTHS = ((0.30, 0.36, 0.45), (0.45, 0.28, 0.26), (0.36, 0.42, 0.38), (0.50, 0.47, 0.46))


def any_wood(rng: Random) -> Path:
    """The grain of one of the woods."""
    return textures.wood(int(rng.integers(4)), WOODS[rng.integers(len(WOODS))])


def any_cloth(rng: Random) -> Path:
    """One of the plain cloths."""
    return textures.fabric(int(rng.integers(4)), CLOTHS[rng.integers(len(CLOTHS))])


def legs(width: float, depth: float, height: float, thick: float, surface: Surface) -> list[Part]:
    """Four legs under the corners."""
    x, y = (width - thick) / 2, (depth - thick) / 2
    return [
        box((sx * x, sy * y, 0), (thick, thick, height), surface)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]


def cabinet(
    surface: Surface, width: float, depth: float, height: float, rows: int, columns: int,
    front: Surface, handle: Surface = STEEL,
) -> list[Part]:  # fmt: skip
    """A body with a grid of doors or drawers, each with a handle."""
    parts = [box((0, 0, 0), (width, depth, height), surface)]
    w, h = width / columns, (height - 0.08) / rows
    for row in range(rows):
        for column in range(columns):
            x, z = (column + 0.5) * w - width / 2, 0.06 + row * h
            parts.append(box((x, -depth / 2 - 0.008, z), (w - 0.015, 0.016, h - 0.015), front))
            grip = (0.14, 0.02, 0.02) if h < w else (0.02, 0.02, 0.14)
            side = 0.0 if h < w else (w / 2 - 0.06) * (-1 if column % 2 else 1)
            parts.append(box((x + side, -depth / 2 - 0.026, z + h * 0.55), grip, handle))
    return parts
