"""Procedural wardrobes, chests of drawers and the like."""

from __future__ import annotations

import numpy as np

from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    PAINTS,
    STEEL,
    Random,
    Shape,
    any_metal,
    any_paint,
    cabinet,
    legs,
    pick,
    shade,
    wood_or_paint,
)
from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import box, cushion, flat_panel


def wardrobe(rng: Random) -> Shape:
    """Tall, with hinged or sliding doors, perhaps with a mirror or drawers below."""
    material, wood = wood_or_paint(rng)
    front = wood if rng.random() < 0.6 else wood_or_paint(rng)[1]
    doors = int(rng.integers(1, 5))
    w, d, h = doors * rng.uniform(0.44, 0.6), rng.uniform(0.5, 0.65), rng.uniform(1.8, 2.25)
    below = rng.uniform(0.3, 0.5) if rng.random() < 0.3 else 0.06
    parts = [
        box((0, 0, 0), (w, d, h), wood),
        *cabinet(
            wood,
            (w, d, h - 0.02),
            (1, doors),
            front,
            any_metal(rng),
            knobs=bool(rng.random() < 0.3),
            base=below,
        ),
    ]
    if below > 0.1:
        parts += cabinet(wood, (w, d, below), (1, max(1, doors // 2)), front, STEEL)
    if rng.random() < 0.3:
        i = int(rng.integers(doors))
        x, y = (i + 0.5 - doors / 2) * w / doors, -d / 2 - 0.018
        size = ((w / doors - 0.1), 0, 0)
        parts.append(
            flat_panel(
                (x - size[0] / 2, y, below + 0.1),
                size,
                (0, 0, h - below - 0.25),
                (0.74, 0.82, 0.87),
            )
        )
    if rng.random() < 0.3:
        parts.append(box((0, -0.01, h), (w + 0.06, d + 0.06, 0.06), wood))
    return Shape(material, parts)


def chest_of_drawers(rng: Random) -> Shape:
    """Waist-high, with rows of drawers."""
    material, wood = wood_or_paint(rng)
    front = wood if rng.random() < 0.7 else wood_or_paint(rng)[1]
    columns = int(rng.integers(1, 4))
    w = rng.uniform(0.5, 0.8) if columns == 1 else rng.uniform(0.9, 1.6)
    d, h, rows = rng.uniform(0.4, 0.52), rng.uniform(0.7, 1.15), int(rng.integers(3, 6))
    raised = rng.random() < 0.4
    parts = cabinet(
        wood,
        (w, d, h),
        (rows, columns),
        front,
        any_metal(rng),
        knobs=bool(rng.random() < 0.5),
        base=0.12 if raised else 0.0,
    )
    if raised:
        parts += legs(w, d, 0.12, 0.05, wood)
    parts.append(box((0, -0.01, h), (w + 0.03, d + 0.04, 0.025), wood))
    return Shape(material, parts)


def nightstand(rng: Random) -> Shape:
    """Knee-high, with drawers or an open compartment."""
    material, wood = wood_or_paint(rng)
    w, d, h = rng.uniform(0.38, 0.52), rng.uniform(0.36, 0.46), rng.uniform(0.42, 0.6)
    rows = int(rng.integers(1, 4))
    base = float(rng.choice([0.0, 0.12, h * 0.5]))
    parts = cabinet(
        wood,
        (w, d, h - 0.02),
        (rows if base < 0.2 else 1, 1),
        wood,
        any_metal(rng),
        knobs=bool(rng.random() < 0.5),
        base=base,
    )
    if base:
        parts += legs(w, d, base, 0.04, wood)
        if base > 0.2:
            parts.append(box((0, 0, 0.1), (w - 0.02, d - 0.02, 0.02), wood))
    parts.append(box((0, -0.01, h - 0.02), (w + 0.02, d + 0.03, 0.022), wood))
    return Shape(material, parts)


def tv_stand(rng: Random) -> Shape:
    """Low and wide, with doors, drawers or open compartments."""
    material, wood = wood_or_paint(rng)
    front = wood if rng.random() < 0.5 else wood_or_paint(rng)[1]
    w, d, h = rng.uniform(1.1, 1.9), rng.uniform(0.36, 0.5), rng.uniform(0.38, 0.6)
    t, base = 0.03, float(rng.choice([0.0, 0.06, 0.14]))
    parts: list[Part] = []
    if base:
        parts += legs(w - 0.1, d - 0.06, base, 0.05, wood, round_=base > 0.1)
    if rng.random() < 0.5:
        parts += cabinet(
            wood,
            (w, d, h),
            (int(rng.integers(1, 3)), int(rng.integers(2, 5))),
            front,
            any_metal(rng),
            base=base,
        )
    else:
        columns = int(rng.integers(2, 4))
        parts += [box((0, 0, z), (w, d, t), wood) for z in (base, base + (h - base) * 0.5, h - t)]
        parts += [
            box((x, 0, base), (t, d, h - base), wood)
            for x in np.linspace(-(w - t) / 2, (w - t) / 2, columns + 1)
        ]
        parts.append(box((0, d / 2 - 0.01, base), (w, 0.015, h - base), wood))
        parts.append(box((0, -0.02, base + t), (w / columns * 0.7, d * 0.7, 0.07), BLACK))
        if rng.random() < 0.6:
            for s in (-1, 1):
                x = s * (w / 2 - w / columns / 2)
                parts.append(
                    box((x, -d / 2, base + t), (w / columns - 0.03, 0.02, h - base - 2 * t), front)
                )
    parts.append(box((0, 0, h), (w + 0.02, d + 0.02, 0.02), wood))
    return Shape(material, parts)


def filing_cabinet(rng: Random) -> Shape:
    """Steel drawers for hanging files."""
    paint = shade(rng, pick(rng, (STEEL, (0.75, 0.72, 0.62), (0.3, 0.32, 0.35), *PAINTS[:3])))
    rows = int(rng.integers(2, 5))
    w, d, h = rng.uniform(0.38, 0.48), rng.uniform(0.5, 0.62), rows * rng.uniform(0.3, 0.34)
    parts = cabinet(paint, (w, d, h), (rows, 1), paint, any_metal(rng))
    for row in range(rows):
        z = 0.02 + (row + 0.72) * (h - 0.04) / rows
        parts.append(box((0, -d / 2 - 0.018, z), (0.09, 0.006, 0.045), (0.93, 0.93, 0.9)))
    return Shape("metal", parts)


def changing_table(rng: Random) -> Shape:
    """A chest with a raised rim and a soft mat for a baby."""
    material, wood = wood_or_paint(rng)
    w, d, h = rng.uniform(0.8, 1.25), rng.uniform(0.48, 0.6), rng.uniform(0.82, 0.95)
    if rng.random() < 0.7:
        parts = cabinet(
            wood, (w, d, h), (3, int(rng.integers(1, 3))), wood, any_metal(rng), knobs=True
        )
    else:
        parts = [
            *legs(w, d, h, 0.05, wood),
            *[box((0, 0, z), (w, d, 0.03), wood) for z in (0.15, 0.45, h - 0.03)],
        ]
    parts += [box((s * (w - 0.03) / 2, 0, h), (0.03, d, 0.13), wood) for s in (-1, 1)]
    parts.append(box((0, (d - 0.03) / 2, h), (w, 0.03, 0.13), wood))
    mat = any_paint(rng)
    parts.append(cushion((0, 0, h), (w * 0.85, d * 0.85, 0.06), mat, 0.3))
    parts += [
        cushion((0, s * d * 0.34, h + 0.02), (w * 0.85, 0.1, 0.08), mat, 0.6) for s in (-1, 1)
    ]
    return Shape(material, parts)
