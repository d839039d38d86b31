"""Seats, beds, tables and cupboards of our own, as parts in the frame of `Piece`."""

from __future__ import annotations

from math import pi

from sim_stubs import textures
from sim_stubs.joinery import BLACK, PORCELAIN, STEEL, Random, any_cloth, any_wood, cabinet, legs
from sim_stubs.piece import Part
from sim_stubs.solids import box, cushion, cylinder, moved
from vizbot.core.geometry import planar

BLANKETS = ((0.22, 0.34, 0.55), (0.55, 0.24, 0.28), (0.28, 0.46, 0.44), (0.50, 0.38, 0.55))


def chair(rng: Random) -> list[Part]:
    """A wooden chair."""
    surface = any_wood(rng)
    posts = [box((x, 0.21, 0.44), (0.04, 0.04, 0.44), surface) for x in (-0.2, 0.2)]
    return [
        *legs(0.44, 0.46, 0.42, 0.04, surface),
        *posts,
        box((0, 0, 0.42), (0.46, 0.48, 0.05), surface),
        box((0, 0.21, 0.60), (0.40, 0.03, 0.26), surface),
    ]


def office_chair(rng: Random) -> list[Part]:
    """An upholstered chair on five legs."""
    cloth = any_cloth(rng)
    arms = [moved(box((0.14, 0, 0.0), (0.3, 0.05, 0.07), BLACK), planar(0, 0, k * 2 * pi / 5))
            for k in range(5)]  # fmt: skip
    return [
        *arms,
        cylinder((0, 0, 0.05), 0.03, 0.36, STEEL),
        cushion((0, 0, 0.40), (0.50, 0.48, 0.11), cloth),
        cushion((0, 0.22, 0.52), (0.46, 0.10, 0.52), cloth),
    ]


def sofa(rng: Random, width: float = 1.9, seats: int = 2) -> list[Part]:
    """A sofa, or with one seat an armchair."""
    cloth, inner = any_cloth(rng), width - 0.4
    pillows = [
        cushion(((i + 0.5) * inner / seats - inner / 2, -0.08, 0.26), (inner / seats, 0.7, 0.2),
                cloth, 0.25)
        for i in range(seats)
    ]  # fmt: skip
    return [
        *legs(width - 0.1, 0.8, 0.08, 0.05, BLACK),
        box((0, 0, 0.06), (width, 0.86, 0.22), cloth),
        cushion((0, 0.34, 0.2), (width - 0.1, 0.24, 0.66), cloth, 0.3),
        *[cushion((x, 0, 0.1), (0.22, 0.88, 0.52), cloth, 0.3)
          for x in (-(width - 0.2) / 2, (width - 0.2) / 2)],
        *pillows,
        cushion((inner / 2 - 0.2, 0.14, 0.44), (0.4, 0.16, 0.38),
                BLANKETS[rng.integers(len(BLANKETS))], 0.5),
    ]  # fmt: skip


def bed(rng: Random, width: float = 1.6) -> list[Part]:
    """A bed with its head at the back."""
    wood, pillows = any_wood(rng), 2 if width > 1.2 else 1
    cover = textures.fabric(int(rng.integers(9)), BLANKETS[rng.integers(len(BLANKETS))], PORCELAIN)
    return [
        box((0, 0, 0.0), (width, 2.0, 0.28), wood),
        box((0, 1.0, 0.0), (width + 0.06, 0.06, 1.0), wood),
        cushion((0, 0, 0.24), (width - 0.06, 1.96, 0.24), PORCELAIN, 0.12),
        cushion((0, -0.24, 0.3), (width + 0.02, 1.52, 0.22), cover, 0.1),
        *[cushion(((i + 0.5) * width / pillows - width / 2, 0.72, 0.44),
                  (width / pillows * 0.8, 0.42, 0.16), PORCELAIN, 0.6) for i in range(pillows)],
    ]  # fmt: skip


def table(rng: Random, width: float, depth: float, height: float) -> list[Part]:
    """A table on four legs."""
    wood = any_wood(rng)
    return [
        *legs(width - 0.06, depth - 0.06, height - 0.04, 0.06, wood),
        box((0, 0, height - 0.04), (width, depth, 0.04), wood),
    ]


def desk(rng: Random) -> list[Part]:
    """A desk with three drawers."""
    wood = any_wood(rng)
    drawers = [box((0.38, -0.27, z), (0.38, 0.02, 0.18), PORCELAIN) for z in (0.06, 0.27, 0.48)]
    return [
        *[box((x, 0, 0), (0.03, 0.56, 0.70), wood) for x in (-0.58, 0.17, 0.58)],
        *drawers,
        box((0, 0, 0.70), (1.2, 0.6, 0.04), wood),
    ]


def wardrobe(rng: Random) -> list[Part]:
    """A wardrobe with three doors."""
    wood = any_wood(rng)
    return cabinet(wood, 1.6, 0.58, 2.0, 1, 3, wood)
