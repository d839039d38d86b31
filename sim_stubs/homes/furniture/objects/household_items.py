"""Procedural household items: ladders, racks, cleaners."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import arc_points, prism, rod, tube, turned, vec
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    STEEL,
    Random,
    Shape,
    any_cloth,
    any_metal,
    any_paint,
    any_wood,
)
from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import Surface, box, cushion, cylinder


def ladder(rng: Random) -> Shape:
    """A step ladder."""
    wooden = rng.random() < 0.45
    frame: Surface = any_wood(rng) if wooden else any_metal(rng)
    h, w = rng.uniform(0.8, 1.8), rng.uniform(0.36, 0.46)
    spread = h * 0.3
    steps = max(2, round(h / 0.24))
    parts: list[Part] = []
    for s in (-1, 1):
        parts += [
            rod((s * w * 0.5, -spread, 0), (s * w * 0.38, 0, h), 0.022, frame, segments=6),
            rod((s * w * 0.5, spread, 0), (s * w * 0.38, 0.04, h * 0.97), 0.016, frame, segments=6),
        ]
    for k in range(1, steps + 1):
        t = k / (steps + 0.2)
        y, half = -spread * (1 - t), w * (0.5 - 0.12 * t)
        parts.append(box((0, y, h * t - 0.02), (2 * half, 0.09, 0.025), frame))
    parts += [
        box((0, 0, h - 0.01), (w * 0.82, 0.2, 0.03), frame if wooden else BLACK),
        rod((-w * 0.45, spread * 0.6, h * 0.4), (w * 0.45, spread * 0.6, h * 0.4), 0.01, frame),
    ]
    return Shape("wooden" if wooden else "metal", parts)


def coat_rack(rng: Random) -> Shape:
    """A pole with hooks, and coats on some."""
    wooden = rng.random() < 0.6
    frame: Surface = any_wood(rng) if wooden else any_metal(rng)
    h = rng.uniform(1.6, 1.85)
    parts = [rod((0, 0, 0.05), (0, 0, h), 0.022, frame)]
    for k in range(4):
        angle = k * pi / 2 + pi / 4
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        parts.append(
            tube(
                np.array(
                    [
                        way * 0.02 + vec(0, 0, 0.12),
                        way * 0.15 + vec(0, 0, 0.08),
                        way * 0.26 + vec(0, 0, 0.015),
                    ]
                ),
                0.016,
                frame,
                6,
            )
        )
    hooks = int(rng.integers(4, 8))
    for k in range(hooks):
        angle = 2 * pi * k / hooks
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        z = h - 0.08 - 0.2 * (k % 2)
        parts.append(rod(way * 0.01 + vec(0, 0, z), way * 0.14 + vec(0, 0, z + 0.08), 0.01, frame))
        if rng.random() < 0.35:
            drop = rng.uniform(0.6, 0.95)
            x, y = way[:2] * 0.14
            parts.append(
                cushion((x, y, z - drop + 0.03), (0.22, 0.2, drop), any_cloth(rng), 0.6, 6)
            )
    return Shape("wooden" if wooden else "metal", parts)


def ironing_board(rng: Random) -> Shape:
    """A padded board on crossed legs, with an iron now and then."""
    metal, cloth, h = any_metal(rng), any_cloth(rng), rng.uniform(0.82, 0.92)
    outline = [
        (-0.62, 0.0),
        (-0.55, -0.1),
        (-0.3, -0.17),
        (0.6, -0.19),
        (0.64, 0.0),
        (0.6, 0.19),
        (-0.3, 0.17),
        (-0.55, 0.1),
    ]
    parts = [prism(np.array(outline), h - 0.04, 0.04, cloth)]
    for s in (-1, 1):
        parts += [
            rod((-0.35, s * 0.05, h - 0.04), (0.4, s * 0.16, 0.012), 0.012, metal),
            rod((0.35, s * 0.05, h - 0.04), (-0.4, s * 0.16, 0.012), 0.012, metal),
        ]
    parts += [rod((x, -0.2, 0.012), (x, 0.2, 0.012), 0.014, metal) for x in (-0.4, 0.4)]
    if rng.random() < 0.5:
        parts += [
            cushion((0.42, 0, h), (0.24, 0.11, 0.06), any_paint(rng), 0.5, 6),
            cushion((0.42, 0, h + 0.09), (0.18, 0.03, 0.03), BLACK, 0.5, 4),
            rod((0.34, 0, h + 0.04), (0.34, 0, h + 0.1), 0.012, BLACK),
            rod((0.5, 0, h + 0.04), (0.5, 0, h + 0.1), 0.012, BLACK),
        ]
    return Shape("", parts)


def vacuum_cleaner(rng: Random) -> Shape:
    """A cylinder cleaner with hose and nozzle, or an upright one."""
    paint = any_paint(rng)
    if rng.random() < 0.6:
        hose = [
            (0, -0.15, 0.18),
            (0.0, -0.3, 0.4),
            (0.12, -0.3, 0.6),
            (0.25, -0.15, 0.75),
            (0.3, -0.05, 0.8),
        ]
        parts = [
            cushion((0, 0.05, 0.04), (0.28, 0.42, 0.22), paint, 0.6),
            cushion((0, 0.0, 0.16), (0.2, 0.26, 0.12), BLACK, 0.6, 6),
            tube(np.array(hose), 0.02, (0.25, 0.25, 0.27), 6),
            rod((0.3, -0.05, 0.82), (0.3, -0.45, 0.06), 0.017, STEEL),
            box((0.3, -0.48, 0), (0.28, 0.1, 0.05), BLACK),
            *[
                rod((s * 0.14, 0.16, 0.08), (s * 0.17, 0.16, 0.08), 0.08, BLACK, segments=12)
                for s in (-1, 1)
            ],
        ]
    else:
        parts = [
            box((0, -0.1, 0), (0.3, 0.26, 0.1), BLACK),
            cushion((0, -0.12, 0.04), (0.28, 0.22, 0.1), paint, 0.4, 6),
            rod((0, -0.02, 0.08), (0, 0.22, 1.0), 0.018, STEEL),
            rod((0, 0.02, 0.16), (0, 0.15, 0.62), 0.075, paint, 0.06, 14),
            tube(
                arc_points((0, 0.24, 1.02), (0, 0.05, 0), (0, 0, 0.06), -pi / 2, pi, 8),
                0.014,
                BLACK,
                5,
            ),
        ]
    return Shape("plastic", parts)


def umbrella(rng: Random) -> Shape:
    """Folded, on its tip."""
    cloth, h = any_cloth(rng), rng.uniform(0.75, 0.9)
    handle: Surface = any_wood(rng) if rng.random() < 0.6 else BLACK
    hook = arc_points((0.04, 0, h), (-0.04, 0, 0), (0, 0, 0.05), 0, pi * 1.1, 8)
    parts = [
        turned(
            [
                (0, 0.0),
                (0.006, 0.0),
                (0.008, 0.06),
                (0.03, 0.1),
                (0.045, h * 0.45),
                (0.05, h * 0.62),
                (0.015, h * 0.66),
                (0, h * 0.67),
            ],
            cloth,
            segments=10,
        ),
        cylinder((0, 0, h * 0.6), 0.007, h * 0.4, STEEL, segments=6),
        tube(hook, 0.012, handle, 6),
    ]
    return Shape("", parts)
