"""Procedural office chairs, stools and benches."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    ellipse,
    prism,
    rod,
    tilted,
    tube,
    turned,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    PAINTS,
    Random,
    Shape,
    any_metal,
    legs,
    pick,
    shade,
    upholstery,
    wood_or_paint,
)
from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import box, cushion, cylinder


def office_chair(rng: Random) -> Shape:
    """A swivel chair on five castors."""
    material, cover = upholstery(rng)
    if rng.random() < 0.5:
        cover = shade(rng, pick(rng, (BLACK, BLACK, PAINTS[1], PAINTS[0], (0.3, 0.3, 0.32))))
    frame = BLACK if rng.random() < 0.7 else any_metal(rng)
    seat, top = rng.uniform(0.43, 0.5), rng.uniform(0.85, 1.2)
    w, d, soft = rng.uniform(0.44, 0.52), rng.uniform(0.42, 0.5), rng.uniform(0.25, 0.6)
    parts = [cylinder((0, 0, 0.08), 0.03, seat - 0.12, frame)]
    for k in range(5):
        angle = k * 2 * pi / 5 + 0.3
        x, y = 0.29 * np.cos(angle), 0.29 * np.sin(angle)
        parts.append(rod((0, 0, 0.11), (x, y, 0.07), 0.025, frame, 0.016))
        parts.append(rod((x - 0.02, y, 0.028), (x + 0.02, y, 0.028), 0.028, BLACK))
    gap = rng.uniform(0.04, 0.14)
    back = cushion(
        (0, d / 2, seat + gap), (w * rng.uniform(0.8, 1.0), 0.09, top - seat - gap), cover, soft
    )
    parts += [
        cushion((0, 0, seat - 0.05), (w, d, 0.10), cover, soft),
        tilted(back, (-1, 0, 0), rng.uniform(0, 0.15), (0, d / 2, seat)),
        box((0, d / 2 + 0.03, seat - 0.03), (0.06, 0.025, gap + 0.2), frame),
    ]
    if rng.random() < 0.65:
        for side in (-1, 1):
            x = side * (w / 2 + 0.03)
            parts.append(rod((x * 0.8, 0.02, seat - 0.02), (x, 0.02, seat + 0.18), 0.016, frame))
            parts.append(cushion((x, 0.0, seat + 0.17), (0.06, 0.26, 0.035), BLACK, 0.3, 4))
    return Shape(material, parts)


def stool(rng: Random) -> Shape:
    """A seat without a back, low or as high as a bar; a bar chair has a low back."""
    high = rng.random() < 0.6
    h = rng.uniform(0.62, 0.8) if high else rng.uniform(0.42, 0.5)
    r = rng.uniform(0.15, 0.2)
    material, surface = wood_or_paint(rng)
    stand = rng.integers(3)
    if stand == 0:
        metal = any_metal(rng)
        material, top = "", upholstery(rng)[1]
        parts = [turned([(0, 0), (0.21, 0), (0.2, 0.015), (0.03, 0.04), (0.025, h), (0, h)], metal)]
        ring = arc_points((0, 0, h * 0.4), (0.15, 0, 0), (0, 0.15, 0), 0, 2 * pi, 16)
        parts.append(tube(ring, 0.011, metal, 6))
        parts.append(rod((-0.15, 0, h * 0.4), (0.15, 0, h * 0.4), 0.009, metal))
        parts.append(cushion((0, 0, h - 0.02), (2 * r, 2 * r, 0.09), top, 0.6))
    else:
        round_ = stand == 1
        parts = legs(1.6 * r, 1.6 * r, h, 0.035, surface, splay=0.05 * round_, round_=round_)
        for z in (h * 0.3, h * 0.45) if high else (h * 0.35,):
            for at in (-1, 1):
                a = at * (0.8 * r - 0.017 + 0.05 * round_ * (1 - z / h))
                parts.append(rod((-a, a, z), (a, a, z), 0.011, surface))
                parts.append(rod((a, -a, z), (a, a, z), 0.011, surface))
        plan = ellipse(2.1 * r, 2.1 * r, 20, 1.0 if rng.random() < 0.6 else 0.25)
        parts.append(prism(plan, h, 0.035, surface))
    if high and rng.random() < 0.4:
        y = r * 0.95
        parts += [
            rod((x, y, h), (x, y + 0.03, h + 0.28), 0.012, surface) for x in (-r * 0.7, r * 0.7)
        ]
        parts.append(box((0, y + 0.02, h + 0.18), (1.6 * r, 0.025, 0.1), surface))
    return Shape(material, parts)


def bench(rng: Random) -> Shape:
    """A long seat without a back, or with a slatted one."""
    material, surface = wood_or_paint(rng)
    w, d, h = rng.uniform(0.95, 1.6), rng.uniform(0.32, 0.46), rng.uniform(0.42, 0.48)
    parts: list[Part] = []
    if rng.random() < 0.5:
        parts += legs(w - 0.1, d - 0.04, h - 0.04, 0.05, surface, round_=bool(rng.random() < 0.4))
    else:
        parts += [
            box((x, 0, 0), (0.05, d - 0.04, h - 0.04), surface)
            for x in (-w / 2 + 0.12, w / 2 - 0.12)
        ]
        parts.append(box((0, 0, 0.15), (w - 0.24, 0.04, 0.08), surface))
    kind = rng.integers(3)
    if kind == 0:
        count = int(rng.integers(3, 6))
        for y in np.linspace(-d / 2 + 0.04, d / 2 - 0.04, count):
            parts.append(box((0, y, h - 0.04), (w, d / count - 0.015, 0.035), surface))
    elif kind == 1:
        plan = ellipse(w, d, 28, float(rng.choice([0.2, 0.5])))
        parts.append(prism(plan, h - 0.04, 0.045, surface))
    else:
        parts.append(box((0, 0, h - 0.06), (w, d, 0.06), surface))
        parts.append(
            cushion((0, 0, h - 0.01), (w - 0.03, d - 0.03, 0.07), upholstery(rng)[1], 0.15)
        )
    if rng.random() < 0.25:
        parts += [
            box((x, d / 2 - 0.02, h), (0.04, 0.03, 0.4), surface)
            for x in (-w / 2 + 0.1, 0, w / 2 - 0.1)
        ]
        parts += [box((0, d / 2 - 0.04, z), (w, 0.02, 0.07), surface) for z in (h + 0.16, h + 0.3)]
    return Shape(material, parts)
