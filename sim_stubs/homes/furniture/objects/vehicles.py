"""Procedural bicycles and other things on wheels, and the high chair."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    ellipse,
    prism,
    rod,
    sheet,
    tilted,
    tube,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    PAINTS,
    STEEL,
    Random,
    Shape,
    any_cloth,
    any_metal,
    any_paint,
    any_wood,
    pick,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion


def wheel(
    centre: ArrayLike,
    radius: float,
    spokes: int,
    tyre: Surface,
    metal: Surface,
    thick: float = 0.018,
) -> list[Part]:
    """A wheel that rolls along y."""
    c = np.asarray(centre, np.float64)
    parts = [
        tube(
            arc_points(c, (0, radius - thick, 0), (0, 0, radius - thick), 0, 2 * pi, 20),
            thick,
            tyre,
            5,
        ),
        rod(c - vec(0.04, 0, 0), c + vec(0.04, 0, 0), 0.015, metal, segments=6),
    ]
    for k in range(spokes):
        angle = 2 * pi * k / spokes
        rim = c + (radius - thick) * np.array([0, np.cos(angle), np.sin(angle)])
        parts.append(rod(c, rim, 0.0025, metal, segments=3))
    return parts


def bicycle(rng: Random) -> Shape:
    """A bicycle, its front wheel at the front."""
    paint, metal = any_paint(rng), shade(rng, STEEL)
    r = rng.uniform(0.28, 0.34)
    half = r * 1.55
    parts = [*wheel((0, -half, r), r, 14, BLACK, metal), *wheel((0, half, r), r, 14, BLACK, metal)]
    crank, seat, head = (
        np.array([0, 0.05, r * 0.95]),
        np.array([0, half * 0.38, r * 2.3]),
        np.array([0, -half * 0.66, r * 2.35]),
    )
    step_through = rng.random() < 0.3
    middle = (crank + seat) / 2 if step_through else seat - vec(0, 0, 0.06)
    front, back = np.array([0, -half, r]), np.array([0, half, r])
    low = head - vec(0, 0.03, 0.12)
    parts += [
        rod(a, b, t, paint)
        for a, b, t in (
            (crank, seat, 0.017),
            (crank, low, 0.02),
            (middle, head if not step_through else low, 0.017),
            (low, head + vec(0, 0.02, 0.1), 0.018),
        )
    ]
    for s in (-0.035, 0.035):
        parts += [
            rod(low, front + vec(s, 0, 0), 0.012, paint),
            rod(crank, back + vec(s, 0, 0), 0.01, paint),
            rod(seat - vec(0, 0, 0.08), back + vec(s, 0, 0), 0.01, paint),
        ]
    top = head + vec(0, 0.02, 0.12)
    parts += [
        rod(top - vec(0.26, -0.08, 0), top, 0.012, metal),
        rod(top + vec(0.26, 0.08, 0), top, 0.012, metal),
        *[
            rod(top + vec(s * 0.2, 0.065, 0), top + vec(s * 0.29, 0.09, 0), 0.018, BLACK)
            for s in (-1, 1)
        ],
        rod(seat, seat + vec(0, 0.01, 0.08), 0.013, metal),
        cushion(seat + vec(0, 0.01, 0.07), (0.14, 0.26, 0.06), BLACK, 0.8, 6),
        rod(crank - vec(0.03, 0, 0), crank + vec(0.03, 0, 0), 0.09, metal, segments=16),
        *[
            rod(crank + vec(s * 0.05, 0, 0), crank + vec(s * 0.07, s * 0.1, -s * 0.13), 0.01, metal)
            for s in (-1, 1)
        ],
        *[
            box(crank + vec(s * 0.11, s * 0.1, -s * 0.13), (0.09, 0.07, 0.02), BLACK)
            for s in (-1, 1)
        ],
    ]
    return Shape("metal", parts)


def pushchair(rng: Random) -> Shape:
    """A seat with a hood on wheels."""
    cloth, metal = any_cloth(rng), any_metal(rng)
    parts: list[Part] = []
    for s in (-1, 1):
        x = s * 0.2
        parts += [
            rod((x, -0.35, 0.1), (x, 0.3, 1.0), 0.013, metal),
            rod((x, 0.34, 0.1), (x, -0.18, 0.62), 0.013, metal),
        ]
        for y in (-0.36, 0.36):
            parts += wheel((x, y, 0.1), 0.1, 5, BLACK, metal, 0.02)
    hood = [
        np.array(
            [
                arc_points((x, 0.12, 0.66), (0, -0.3, 0), (0, 0, 0.3), a, a + 0.0, 1)[0]
                for x in np.linspace(-0.2, 0.2, 5)
            ]
        )
        for a in np.linspace(0.25, 2.4, 9)
    ]
    parts += [
        sheet(np.array(hood), cloth, both=True),
        cushion((0, -0.05, 0.42), (0.38, 0.34, 0.08), cloth, 0.3),
        tilted(
            cushion((0, 0.12, 0.45), (0.38, 0.08, 0.48), cloth, 0.3),
            (-1, 0, 0),
            0.35,
            (0, 0.12, 0.45),
        ),
        tilted(
            cushion((0, -0.24, 0.2), (0.34, 0.05, 0.26), cloth, 0.3),
            (-1, 0, 0),
            -0.3,
            (0, -0.24, 0.44),
        ),
        rod((-0.2, 0.3, 1.0), (0.2, 0.3, 1.0), 0.018, BLACK),
        rod((-0.2, -0.24, 0.62), (0.2, -0.24, 0.62), 0.014, BLACK),
    ]
    return Shape("fabric", parts)


def wheelchair(rng: Random) -> Shape:
    """A chair between two large wheels."""
    cloth, metal = shade(rng, pick(rng, (BLACK, BLACK, PAINTS[1], PAINTS[0]))), any_metal(rng)
    parts: list[Part] = []
    for s in (-1, 1):
        x = s * 0.26
        parts += wheel((x + s * 0.03, 0.08, 0.3), 0.3, 12, BLACK, metal)
        parts += wheel((x * 0.85, -0.32, 0.08), 0.08, 4, BLACK, metal, 0.016)
        parts += [
            rod((x, 0.22, 0.2), (x, 0.28, 0.95), 0.013, metal),
            rod((x, 0.28, 0.93), (x, 0.42, 0.95), 0.018, BLACK),
            rod((x, 0.2, 0.48), (x, -0.24, 0.48), 0.013, metal),
            rod((x, -0.24, 0.48), (x * 0.8, -0.42, 0.1), 0.013, metal),
            rod((x, 0.2, 0.25), (x * 0.9, -0.3, 0.2), 0.012, metal),
            box((x, -0.02, 0.68), (0.06, 0.3, 0.03), BLACK),
            rod((x, -0.14, 0.48), (x, -0.14, 0.68), 0.012, metal),
            box((x * 0.6, -0.45, 0.08), (0.15, 0.14, 0.015), BLACK),
        ]
    parts += [
        cushion((0, -0.02, 0.45), (0.46, 0.44, 0.06), cloth, 0.2),
        tilted(
            cushion((0, 0.22, 0.5), (0.46, 0.04, 0.42), cloth, 0.2),
            (-1, 0, 0),
            0.08,
            (0, 0.22, 0.5),
        ),
    ]
    return Shape("metal", parts)


def high_chair(rng: Random) -> Shape:
    """A child's seat on long splayed legs, with a tray."""
    wooden = rng.random() < 0.5
    frame = any_wood(rng) if wooden else any_metal(rng)
    cloth = any_cloth(rng)
    h = rng.uniform(0.5, 0.6)
    tray: Surface = frame if wooden and rng.random() < 0.5 else (0.93, 0.93, 0.91)
    parts = [
        rod((sx * 0.15, sy * 0.14, h), (sx * 0.25, sy * 0.26, 0), 0.018, frame)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    parts += [
        cushion((0, 0, h - 0.02), (0.36, 0.34, 0.07), cloth, 0.3),
        tilted(
            cushion((0, 0.16, h), (0.36, 0.07, 0.45), cloth, 0.3), (-1, 0, 0), 0.12, (0, 0.16, h)
        ),
        *[box((s * 0.18, -0.02, h + 0.04), (0.04, 0.32, 0.14), frame) for s in (-1, 1)],
        prism(ellipse(0.5, 0.32, 24, 0.5) + np.array([0, -0.22]), h + 0.18, 0.025, tray),
        rod((-0.2, -0.2, 0.22), (0.2, -0.2, 0.22), 0.014, frame),
        box((0, -0.22, 0.2), (0.36, 0.12, 0.02), frame),
    ]
    return Shape("wooden" if wooden else "plastic", parts)
