"""Procedural desks, dressing tables and billiard tables."""

from __future__ import annotations

from sim_stubs.homes.furniture.shapes.curved_solids import ellipse, facing, prism, shifted, turned
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    Random,
    Shape,
    any_metal,
    any_wood,
    cabinet,
    legs,
    pick,
    shade,
    wood_or_paint,
)
from sim_stubs.homes.geometry.solids import Surface, box, cylinder


def desk(rng: Random) -> Shape:
    """A table to work at, mostly with drawers at one side or both."""
    material, wood = wood_or_paint(rng)
    w, d, h = rng.uniform(1.0, 1.7), rng.uniform(0.55, 0.8), rng.uniform(0.72, 0.76)
    front = wood if rng.random() < 0.5 else wood_or_paint(rng)[1]
    parts = [box((0, 0, h - 0.03), (w, d, 0.03), wood)]
    sides = pick(rng, ((), (1,), (1,), (-1,), (-1, 1)))
    block = rng.uniform(0.36, 0.42)
    rows = int(rng.integers(2, 5))
    for side in sides:
        drawers = cabinet(wood, (block, d - 0.06, h - 0.03), (rows, 1), front, any_metal(rng))
        parts += [shifted(part, (side * (w / 2 - block / 2 - 0.01), 0, 0)) for part in drawers]
    if rng.random() < 0.5:
        for s in (-1, 1):
            if s not in sides:
                parts.append(box((s * (w / 2 - 0.02), 0, 0), (0.03, d - 0.04, h - 0.03), wood))
        parts.append(box((0, d / 2 - 0.05, h * 0.35), (w - 0.04, 0.02, h * 0.6), wood))
    else:
        stand = any_metal(rng) if rng.random() < 0.5 else wood
        for x in (-1, 1):
            if x not in sides:
                parts += [
                    box((x * (w / 2 - 0.05), y, 0), (0.045, 0.045, h - 0.03), stand)
                    for y in (-d / 2 + 0.05, d / 2 - 0.05)
                ]
    if rng.random() < 0.3:
        top = h + rng.uniform(0.3, 0.55)
        parts += [
            box((x, d / 2 - 0.12, h), (0.02, 0.22, top - h), wood)
            for x in (-w / 2 + 0.02, 0, w / 2 - 0.02)
        ]
        parts += [box((0, d / 2 - 0.12, z), (w, 0.22, 0.02), wood) for z in (top, (h + top) / 2)]
    return Shape(material, parts)


def dressing_table(rng: Random) -> Shape:
    """A small table with drawers and a mirror."""
    material, wood = wood_or_paint(rng)
    w, d, h = rng.uniform(0.8, 1.15), rng.uniform(0.4, 0.5), rng.uniform(0.72, 0.78)
    parts = [
        *legs(w - 0.06, d - 0.04, h - 0.15, 0.045, wood, round_=bool(rng.random() < 0.5)),
        *[
            shifted(part, (0, 0, h - 0.16))
            for part in cabinet(
                wood,
                (w - 0.02, d, 0.15),
                (1, int(rng.integers(2, 4))),
                wood,
                any_metal(rng),
                knobs=True,
            )
        ],
        box((0, 0, h - 0.02), (w + 0.02, d + 0.02, 0.025), wood),
    ]
    y, tall, wide = d / 2 - 0.04, rng.uniform(0.5, 0.75), w * rng.uniform(0.45, 0.75)
    oval = rng.random() < 0.6
    power = 1.0 if oval else 0.15
    for grow, depth, surface in ((0.05, 0.02, wood), (0.0, 0.026, (0.74, 0.82, 0.87))):
        plate = prism(ellipse(wide + grow, tall + grow, 28, power), 0, depth, surface)
        parts.append(facing(plate, (0, y, h + 0.08 + tall / 2)))
    parts += [box((s * (wide / 2 + 0.04), y, h), (0.03, 0.03, tall * 0.7), wood) for s in (-1, 1)]
    if rng.random() < 0.6:
        for s in (-1, 1):
            block = cabinet(wood, (w * 0.2, 0.18, 0.12), (1, 1), wood, any_metal(rng), knobs=True)
            parts += [shifted(part, (s * w * 0.39, 0, h)) for part in block]
    return Shape(material, parts)


def pool_table(rng: Random) -> Shape:
    """A billiard table with balls on it."""
    wood = any_wood(rng)
    w, d, h = rng.uniform(2.0, 2.6), rng.uniform(1.1, 1.4), 0.8
    cloth = shade(
        rng, pick(rng, ((0.08, 0.42, 0.2), (0.08, 0.42, 0.2), (0.1, 0.25, 0.6), (0.5, 0.08, 0.1)))
    )
    parts = [
        *legs(w - 0.3, d - 0.2, h - 0.2, 0.15, wood, round_=bool(rng.random() < 0.5)),
        box((0, 0, h - 0.3), (w - 0.08, d - 0.08, 0.24), wood),
        box((0, 0, h - 0.08), (w - 0.2, d - 0.2, 0.05), cloth),
        *[box((0, s * (d - 0.1) / 2, h - 0.08), (w, 0.12, 0.1), wood) for s in (-1, 1)],
        *[box((s * (w - 0.1) / 2, 0, h - 0.08), (0.12, d, 0.1), wood) for s in (-1, 1)],
        *[
            cylinder((x * (w / 2 - 0.09), y * (d / 2 - 0.09), h + 0.001), 0.06, 0.021, BLACK)
            for x in (-1, 0, 1)
            for y in (-1, 1)
        ],
    ]
    colours: tuple[Surface, ...] = (
        (0.9, 0.9, 0.88),
        (0.8, 0.1, 0.1),
        (0.1, 0.2, 0.7),
        (0.9, 0.7, 0.1),
        BLACK,
    )
    for i in range(8):
        x, y = rng.uniform(-w * 0.35, w * 0.35), rng.uniform(-d * 0.3, d * 0.3)
        ball = turned(
            [(0, 0), (0.022, 0.008), (0.03, 0.03), (0.022, 0.052), (0, 0.06)],
            colours[i % 5],
            (x, y, h - 0.03),
            10,
        )
        parts.append(ball)
    return Shape("wooden", parts)
