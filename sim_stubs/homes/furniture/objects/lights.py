"""Procedural lamps."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    rod,
    shifted,
    tilted,
    tube,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    Random,
    Shape,
    any_metal,
    any_paint,
    any_wood,
    pick,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, cylinder

SHADES = (
    (0.94, 0.92, 0.86),
    (0.94, 0.92, 0.86),
    (0.88, 0.80, 0.62),
    (0.80, 0.25, 0.15),
    (0.25, 0.42, 0.30),
    (0.25, 0.32, 0.52),
    (0.85, 0.60, 0.30),
)


def _shade(
    rng: Random, radius: float, at: tuple[float, float, float], height: float, colour: Surface
) -> list[Part]:
    """A lampshade from its lower edge: a drum, a cone or a bell, open above and below."""
    top = radius * rng.choice([0.95, 0.65, 0.45])
    profile = [(radius, 0.0), (top, height)]
    if rng.random() < 0.25:
        profile = [(radius, 0.0), (radius * 0.7, height * 0.4), (radius * 0.5, height)]
    outside = turned(profile, colour, segments=20)
    inside = turned([(r * 0.98, z) for r, z in reversed(profile)], (0.97, 0.95, 0.88), segments=20)
    return [shifted(part, at) for part in (outside, inside)]


def floor_lamp(rng: Random) -> Shape:
    """A lamp on a pole: shaded, bent over, an uplighter, a tripod, or with a small table."""
    metal: Surface = any_metal(rng) if rng.random() < 0.75 else any_wood(rng)
    colour, h, r = shade(rng, pick(rng, SHADES)), rng.uniform(1.35, 1.8), rng.uniform(0.14, 0.26)
    style, foot_r = rng.random(), rng.uniform(0.12, 0.17)
    foot = turned([(0, 0), (foot_r, 0), (foot_r, 0.015), (0.02, 0.035), (0, 0.035)], metal)
    if style < 0.5:
        tall = rng.uniform(0.2, 0.34)
        stem = turned(
            [
                (0.012, 0.03),
                (0.014, h * 0.4),
                (0.03, h * 0.42),
                (0.012, h * 0.45),
                (0.012, h - tall * 0.3),
            ],
            metal,
            segments=8,
        )
        parts = [foot, stem, *_shade(rng, r, (0, 0, h - tall), tall, colour)]
        if rng.random() < 0.3:
            parts.append(cylinder((0, 0, h * 0.38), 0.2, 0.02, any_wood(rng), segments=20))
    elif style < 0.65:
        reach = rng.uniform(0.4, 0.8)
        path = [
            (0, 0, 0.02),
            (0, 0, h * 0.7),
            *arc_points((reach / 2, 0, h * 0.75), (-reach / 2, 0, 0), (0, 0, h * 0.25), 0, pi, 10),
        ]
        parts = [
            foot,
            tube(path, 0.012, metal, 6),
            *_shade(rng, r * 0.9, (reach, 0, h * 0.75 - 0.16), 0.18, colour),
        ]
    elif style < 0.8:
        parts = [
            foot,
            rod((0, 0, 0.02), (0, 0, h), 0.012, metal),
            turned([(0.02, h - 0.02), (0.12, h + 0.05), (0.16, h + 0.1)], colour),
            turned([(0.155, h + 0.1), (0.11, h + 0.05), (0, h + 0.02)], (0.97, 0.95, 0.88)),
        ]
    else:
        tall = rng.uniform(0.24, 0.34)
        parts = [
            rod(
                (0.02 * np.cos(a), 0.02 * np.sin(a), h - tall),
                (0.3 * np.cos(a), 0.3 * np.sin(a), 0),
                0.016,
                metal,
            )
            for a in (pi / 2, pi / 2 + 2 * pi / 3, pi / 2 + 4 * pi / 3)
        ]
        parts += _shade(rng, r * 1.1, (0, 0, h - tall - 0.03), tall, colour)
    return Shape("", parts)


def table_lamp(rng: Random) -> Shape:
    """A lamp on a turned or round base with a shade, or a jointed desk lamp."""
    colour, h = shade(rng, pick(rng, SHADES)), rng.uniform(0.35, 0.62)
    if rng.random() < 0.3:
        return _desk_lamp(rng)
    base: Surface = pick(rng, (any_paint(rng), any_wood(rng), any_metal(rng), (0.85, 0.86, 0.88)))
    r, tall = rng.uniform(0.1, 0.17), h * rng.uniform(0.36, 0.52)
    low = h - tall
    style = rng.integers(4)
    if style == 0:
        profile = [
            (0, 0),
            (0.07, 0),
            (0.07, 0.02),
            (0.03, 0.04),
            (0.055, low * 0.35),
            (0.025, low * 0.7),
            (0.03, low * 0.75),
            (0.01, low + 0.06),
        ]
    elif style == 1:
        profile = [
            (0, 0),
            (0.05, 0),
            (0.085, low * 0.3),
            (0.08, low * 0.55),
            (0.03, low * 0.85),
            (0.012, low + 0.06),
        ]
    elif style == 2:
        profile = [(0, 0), (0.08, 0), (0.08, 0.015), (0.012, 0.025), (0.012, low + 0.06)]
    else:
        profile = [(0, 0), (0.06, 0.0), (0.06, low * 0.9), (0.012, low * 0.92), (0.012, low + 0.06)]
    parts = [turned(profile, base, segments=16), *_shade(rng, r, (0, 0, low), tall, colour)]
    return Shape("", parts)


def _desk_lamp(rng: Random) -> Shape:
    paint: Surface = pick(rng, (BLACK, any_paint(rng), any_metal(rng)))
    a, b = rng.uniform(0.18, 0.26), rng.uniform(0.16, 0.24)
    knee, head = np.array([0, 0.1, a]), np.array([0, -0.08, a + b * 0.6])
    hood = turned([(0.02, 0.1), (0.035, 0.08), (0.075, 0)], paint, segments=14)
    inside = turned([(0.07, 0.001), (0.03, 0.07), (0, 0.075)], (0.97, 0.95, 0.88), segments=14)
    parts = [
        turned([(0, 0), (0.085, 0), (0.08, 0.02), (0, 0.03)], paint),
        rod((0, 0, 0.02), knee, 0.008, paint),
        rod(knee, head, 0.008, paint),
    ]
    parts += [
        shifted(tilted(part, (-1, 0, 0), 0.5), head + vec(0, -0.02, -0.08))
        for part in (hood, inside)
    ]
    return Shape("metal", parts)


def ceiling_lamp(rng: Random) -> Shape:
    """A pendant, a chandelier, a flat bowl, or a bar of spots; its top is at the ceiling."""
    metal, colour = any_metal(rng), shade(rng, pick(rng, SHADES))
    style, drop = rng.random(), rng.uniform(0.4, 0.9)
    rose = turned(
        [(0, drop - 0.03), (0.05, drop - 0.03), (0.05, drop), (0, drop)], metal, segments=12
    )
    if style < 0.4:
        r, tall = rng.uniform(0.15, 0.3), rng.uniform(0.14, 0.28)
        return Shape(
            "",
            [
                rose,
                rod((0, 0, tall * 0.9), (0, 0, drop), 0.004, BLACK, segments=5),
                *_shade(rng, r, (0, 0, 0), tall, colour),
            ],
        )
    if style < 0.6:
        globe = turned(
            [(0, 0), (0.1, 0.02), (0.15, 0.1), (0.15, 0.2), (0.1, 0.28), (0, 0.3)],
            (0.96, 0.95, 0.92),
        )
        return Shape(
            "glass", [rose, rod((0, 0, 0.28), (0, 0, drop), 0.006, metal, segments=5), globe]
        )
    if style < 0.78:
        r = rng.uniform(0.15, 0.24)
        bowl = turned(
            [(0, 0), (r * 0.6, 0.02), (r * 0.95, 0.06), (r, 0.09)], (0.96, 0.95, 0.92), segments=24
        )
        return Shape(
            "", [bowl, turned([(r * 1.05, 0.07), (r * 1.05, 0.1), (0, 0.1)], metal, segments=24)]
        )
    count = int(rng.integers(3, 7))
    parts = [
        rose,
        rod((0, 0, 0.1), (0, 0, drop), 0.01, metal),
        turned([(0, 0.02), (0.03, 0.05), (0.05, 0.1), (0.02, 0.16)], metal),
    ]
    for k in range(count):
        angle = 2 * pi * k / count
        way = np.array([np.cos(angle), np.sin(angle), 0])
        path = arc_points(way * 0.15 + vec(0, 0, 0.12), way * -0.15, (0, 0, -0.09), 0, pi, 8)
        parts.append(tube(path, 0.008, metal, 5))
        end = way * 0.3 + vec(0, 0, 0.12)
        parts.append(
            shifted(
                turned([(0, 0), (0.03, 0.01), (0.055, 0.08)], (0.96, 0.94, 0.86), segments=10), end
            )
        )
        parts.append(shifted(cylinder((0, 0, 0), 0.012, 0.08, (0.97, 0.96, 0.92), segments=6), end))
    return Shape("metal", parts)
