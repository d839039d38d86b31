"""Small things of our own that make a home, as parts in the frame of `Piece`."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs import textures
from sim_stubs.joinery import BLACK, STEEL, Random, any_wood
from sim_stubs.piece import Part
from sim_stubs.solids import box, cushion, cylinder, moved, panel
from vizbot.core.geometry import planar

LEAF = (0.13, 0.38, 0.15)


def bookshelf(rng: Random, width: float = 0.95, height: float = 1.9) -> list[Part]:
    """Five shelves full of coloured books."""
    wood, shelves = any_wood(rng), 5
    step = (height - 0.04) / shelves
    parts = [box((s * (width - 0.03) / 2, 0, 0), (0.03, 0.3, height), wood) for s in (-1, 1)]
    parts.append(box((0, 0.14, 0), (width, 0.02, height), wood))
    for level in range(shelves + 1):
        parts.append(box((0, 0, level * step), (width, 0.3, 0.03), wood))
        if level < shelves:
            row = textures.books(int(rng.integers(1000)))
            corner = (-width / 2 + 0.03, -0.06, level * step + 0.03)
            parts.append(panel(corner, (width - 0.06, 0, 0), (0, 0, step - 0.09), row, tile=0))
            corner = (-width / 2 + 0.03, -0.06, (level + 1) * step - 0.06)
            parts.append(panel(corner, (width - 0.06, 0, 0), (0, 0.2, 0), BLACK))
    return parts


def tv(rng: Random) -> list[Part]:
    """A television on its foot."""
    screen = textures.outdoors(int(rng.integers(9)))
    return [
        box((0, 0, 0), (0.36, 0.22, 0.02), BLACK),
        box((0, 0.02, 0.02), (0.06, 0.03, 0.08), BLACK),
        box((0, 0.02, 0.08), (1.05, 0.05, 0.62), BLACK),
        panel((-0.5, -0.008, 0.11), (1.0, 0, 0), (0, 0, 0.56), screen, tile=0),
    ]


def computer(rng: Random) -> list[Part]:
    """A screen with a keyboard."""
    screen = textures.painting(int(rng.integers(9)))
    return [
        cylinder((0, 0.05, 0), 0.10, 0.015, STEEL),
        box((0, 0.07, 0), (0.05, 0.02, 0.16), STEEL),
        box((0, 0.05, 0.10), (0.54, 0.03, 0.34), BLACK),
        panel((-0.25, 0.034, 0.12), (0.5, 0, 0), (0, 0, 0.30), screen, tile=0),
        box((0, -0.15, 0), (0.42, 0.14, 0.02), BLACK),
    ]


def plant(rng: Random) -> list[Part]:
    """A leafy plant in a terracotta pot."""
    height = rng.uniform(0.9, 1.3)
    leaves = []
    for _ in range(26):
        angle, z = rng.uniform(0, 2 * pi), rng.uniform(0.45, height)
        reach = rng.uniform(0.02, 0.18)
        shade = tuple(np.array(LEAF) * rng.choice([0.7, 1.0, 1.35]))
        blade = cushion((reach, 0, z), (0.26, 0.10, 0.035), shade, 1.0, 4)
        leaves.append(moved(blade, planar(0, 0, angle)))
    return [
        cylinder((0, 0, 0), 0.12, 0.30, (0.55, 0.28, 0.22), 0.17),
        cylinder((0, 0, 0.29), 0.15, 0.02, (0.16, 0.11, 0.09)),
        cylinder((0, 0, 0.30), 0.02, height - 0.4, (0.25, 0.2, 0.13)),
        *leaves,
    ]


def lamp(rng: Random, height: float, radius: float) -> list[Part]:
    """A lamp with a white shade."""
    shade = height * 0.22 if height > 1 else height * 0.45
    return [
        cylinder((0, 0, 0), radius * 0.7, 0.025, BLACK),
        cylinder((0, 0, 0.02), 0.015, height - shade, BLACK),
        cylinder((0, 0, height - shade), radius, shade, (0.92, 0.90, 0.88), radius * 0.7, 24),
    ]


def laundry_basket(rng: Random) -> list[Part]:
    """A basket with laundry in it."""
    weave = textures.fabric(5, (0.55, 0.45, 0.40), (0.40, 0.32, 0.28))
    return [
        cylinder((0, 0, 0), 0.18, 0.5, weave, 0.23, 20),
        cushion((0.02, 0, 0.44), (0.36, 0.34, 0.14), (0.75, 0.78, 0.85), 0.8),
        cushion((-0.08, 0.05, 0.47), (0.2, 0.2, 0.12), (0.30, 0.40, 0.62), 0.8),
    ]


def carpet(rng: Random) -> list[Part]:
    """A rug, thin enough to be driven over."""
    colour = ((0.42, 0.12, 0.13), (0.14, 0.22, 0.36), (0.20, 0.30, 0.26))[rng.integers(3)]
    face = textures.carpet(int(rng.integers(9)), colour, (0.78, 0.74, 0.72))
    body = box((0, 0, 0.001), (2.0, 1.4, 0.010), colour)
    return [body, panel((-1.0, -0.7, 0.0115), (2.0, 0, 0), (0, 1.4, 0), face, tile=0)]


def picture(rng: Random) -> list[Part]:
    """A framed painting."""
    face = textures.painting(int(rng.integers(10_000)))
    return [
        box((0, 0, 0), (0.80, 0.03, 0.60), BLACK),
        panel((-0.36, -0.0155, 0.04), (0.72, 0, 0), (0, 0, 0.52), face, tile=0),
    ]


def mirror(rng: Random) -> list[Part]:
    """A framed mirror that shows plain light."""
    return [
        box((0, 0, 0), (0.60, 0.03, 0.75), STEEL),
        panel((-0.27, -0.0155, 0.03), (0.54, 0, 0), (0, 0, 0.69), (0.72, 0.80, 0.86)),
    ]
