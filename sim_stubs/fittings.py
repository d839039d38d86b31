"""Kitchen and bathroom of our own, as parts in the frame of `Piece`."""

from __future__ import annotations

import numpy as np

from sim_stubs.joinery import BLACK, PORCELAIN, STEEL, Random, cabinet
from sim_stubs.piece import Part
from sim_stubs.solids import Surface, box, cushion, cylinder, moved


def kitchen_cabinet(rng: Random) -> list[Part]:
    """A lower cabinet with a dark worktop."""
    return [
        *cabinet(PORCELAIN, 1.2, 0.58, 0.86, 1, 2, (0.72, 0.76, 0.80)),
        box((0, -0.01, 0.86), (1.22, 0.62, 0.04), (0.25, 0.25, 0.27)),
    ]


def sink_cabinet(rng: Random) -> list[Part]:
    """A basin with a tap on a small cabinet."""
    return [
        *cabinet(PORCELAIN, 0.6, 0.45, 0.76, 1, 2, (0.55, 0.42, 0.36)),
        cylinder((0, -0.02, 0.76), 0.16, 0.09, PORCELAIN, 0.24, 24),
        cylinder((0, -0.02, 0.852), 0.20, 0.002, (0.75, 0.78, 0.80), segments=24),
        cylinder((0, 0.19, 0.76), 0.018, 0.24, STEEL),
        box((0, 0.12, 0.98), (0.03, 0.16, 0.025), STEEL),
    ]


def refrigerator(rng: Random) -> list[Part]:
    """A tall refrigerator with notes on its door."""
    return [
        *cabinet(STEEL, 0.66, 0.62, 1.75, 1, 1, (0.80, 0.82, 0.84), BLACK),
        box((0, -0.33, 1.18), (0.66, 0.012, 0.012), BLACK),
        box((0.12, -0.332, 1.38), (0.10, 0.01, 0.14), (0.7, 0.2, 0.2)),
        box((-0.02, -0.332, 1.44), (0.08, 0.01, 0.10), (0.2, 0.4, 0.6)),
    ]


def oven(rng: Random) -> list[Part]:
    """An oven with a hob."""
    knobs = [cylinder((x, -0.31, 0.78), 0.022, 0.04, BLACK) for x in (-0.2, -0.07, 0.07, 0.2)]
    rings = [
        cylinder((x, y, 0.885), 0.08, 0.012, (0.28, 0.12, 0.1))
        for x in (-0.14, 0.14)
        for y in (-0.13, 0.13)
    ]
    return [
        box((0, 0, 0), (0.6, 0.6, 0.88), PORCELAIN),
        box((0, -0.3, 0.15), (0.5, 0.03, 0.5), BLACK),
        box((0, -0.33, 0.66), (0.46, 0.03, 0.025), STEEL),
        box((0, 0, 0.88), (0.58, 0.56, 0.008), BLACK),
        *knobs,
        *rings,
    ]


def microwave(rng: Random) -> list[Part]:
    """A microwave."""
    return [
        box((0, 0, 0), (0.48, 0.34, 0.28), STEEL),
        box((-0.06, -0.17, 0.04), (0.32, 0.012, 0.20), BLACK),
        box((0.18, -0.17, 0.05), (0.08, 0.012, 0.18), (0.2, 0.22, 0.25)),
    ]


def washing_machine(rng: Random) -> list[Part]:
    """A front loader."""
    return [
        box((0, 0, 0), (0.6, 0.56, 0.85), PORCELAIN),
        box((0, -0.28, 0.72), (0.58, 0.015, 0.11), (0.55, 0.58, 0.62)),
        *[_disc((0, -0.281 - i * 0.012, 0.4), r, c)
          for i, (r, c) in enumerate(((0.21, STEEL), (0.17, BLACK), (0.12, (0.25, 0.3, 0.36))))],
    ]  # fmt: skip


def _disc(centre: tuple[float, float, float], radius: float, surface: Surface) -> Part:
    """A thick disc that faces -y."""
    stood = np.eye(4)
    stood[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    stood[:3, 3] = centre
    return moved(cylinder((0, 0, 0), radius, 0.012, surface, segments=28), stood)


def toilet(rng: Random) -> list[Part]:
    """A toilet with its cistern at the back."""
    return [
        cylinder((0, -0.10, 0), 0.13, 0.36, PORCELAIN, 0.18, 24),
        cushion((0, -0.12, 0.33), (0.38, 0.50, 0.09), PORCELAIN, 0.7),
        cylinder((0, -0.14, 0.415), 0.12, 0.01, (0.55, 0.58, 0.60), segments=24),
        box((0, 0.24, 0.34), (0.38, 0.18, 0.42), PORCELAIN),
        box((0, 0.24, 0.76), (0.40, 0.20, 0.03), PORCELAIN),
        cylinder((0, 0.24, 0.79), 0.03, 0.015, STEEL),
        moved(cushion((0, 0.10, 0.40), (0.37, 0.05, 0.42), PORCELAIN, 0.7), np.eye(4)),
    ]


def bathtub(rng: Random) -> list[Part]:
    """A bathtub full of water."""
    w, d, h, rim = 1.65, 0.74, 0.56, 0.07
    walls = [box((0, s * (d - rim) / 2, 0), (w, rim, h), PORCELAIN) for s in (-1, 1)]
    ends = [box((s * (w - rim) / 2, 0, 0), (rim, d, h), PORCELAIN) for s in (-1, 1)]
    return [
        *walls,
        *ends,
        box((0, 0, 0), (w, d, 0.1), PORCELAIN),
        box((0, 0, 0.1), (w - 2 * rim, d - 2 * rim, 0.24), (0.62, 0.78, 0.85)),
        cylinder((w / 2 - 0.04, 0, h), 0.02, 0.18, STEEL),
        box((w / 2 - 0.12, 0, h + 0.15), (0.16, 0.03, 0.03), STEEL),
    ]
