"""Procedural kitchen cabinets."""

from __future__ import annotations

import numpy as np

from sim_stubs.homes.furniture.shapes.appliances import casing
from sim_stubs.homes.furniture.shapes.curved_solids import sheet, shifted, tilted, translucent
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    GLASS,
    STEEL,
    Random,
    Shape,
    any_metal,
    any_paint,
    cabinet,
    pick,
    shade,
    wood_or_paint,
)
from sim_stubs.homes.geometry.solids import box, cylinder
from sim_stubs.homes.textures import patterns

WORKTOPS = ((0.25, 0.25, 0.27), (0.80, 0.79, 0.77), (0.60, 0.42, 0.25), (0.55, 0.55, 0.57))


def kitchen_cabinet(rng: Random) -> Shape:
    """A lower cabinet with a worktop."""
    material, front = wood_or_paint(rng)
    body = front if rng.random() < 0.6 else (0.9, 0.9, 0.88)
    columns = int(rng.integers(1, 4))
    w, d, h = columns * rng.uniform(0.4, 0.6), rng.uniform(0.56, 0.62), rng.uniform(0.82, 0.88)
    handle, knobs = any_metal(rng), bool(rng.random() < 0.4)
    parts = [box((0, 0.04, 0), (w, d - 0.1, 0.1), BLACK)]
    style = rng.integers(3)
    if style == 0:
        parts += cabinet(body, (w, d, h), (1, columns), front, handle, knobs=knobs, base=0.1)
    elif style == 1:
        parts += cabinet(
            body,
            (w, d, h),
            (int(rng.integers(3, 5)), columns),
            front,
            handle,
            knobs=knobs,
            base=0.1,
        )
    else:
        parts += cabinet(body, (w, d, h - 0.17), (1, columns), front, handle, knobs=knobs, base=0.1)
        upper = cabinet(body, (w, d, 0.19), (1, columns), front, handle, knobs=knobs)
        parts += [shifted(part, (0, 0, h - 0.19)) for part in upper]
    top = (
        patterns.wood(rng.texture(1), (0.6, 0.42, 0.25))
        if rng.random() < 0.3
        else shade(rng, pick(rng, WORKTOPS))
    )
    parts.append(box((0, -0.01, h), (w + 0.01, d + 0.03, rng.uniform(0.025, 0.045)), top))
    return Shape(material, parts)


def wall_cabinet(rng: Random) -> Shape:
    """An upper cabinet with doors, of glass now and then."""
    material, front = wood_or_paint(rng)
    columns = int(rng.integers(1, 4))
    w, d, h = columns * rng.uniform(0.34, 0.5), rng.uniform(0.3, 0.4), rng.uniform(0.55, 0.8)
    handle = any_metal(rng)
    if rng.random() < 0.65:
        parts = cabinet(
            front, (w, d, h), (1, columns), front, handle, knobs=bool(rng.random() < 0.5)
        )
        return Shape(material, parts)
    t = 0.02
    parts = [box((0, 0, z), (w, d, t), front) for z in (0, h / 3, 2 * h / 3, h - t)]
    parts += [box((s * (w - t) / 2, 0, 0), (t, d, h), front) for s in (-1, 1)]
    parts.append(box((0, d / 2 - 0.01, 0), (w, t, h), front))
    for i in range(columns):
        x, cw = (i + 0.5 - columns / 2) * w / columns, w / columns - 0.01
        y = -d / 2 - 0.01
        parts += [box((x, y, z), (cw, t, 0.05), front) for z in (0, h - 0.05)]
        parts += [box((x + s * (cw - 0.05) / 2, y, 0), (0.05, t, h), front) for s in (-1, 1)]
        parts.append(translucent(box((x, y, 0.04), (cw - 0.08, 0.006, h - 0.08), GLASS), 0.3))
    for level in range(3):
        for x in np.linspace(-w / 2 + 0.08, w / 2 - 0.08, 3):
            cup = cylinder((x, 0.02, t + level * h / 3), 0.03, 0.09, any_paint(rng), segments=8)
            parts.append(cup)
    return Shape(material, parts)


def kitchen_island(rng: Random) -> Shape:
    """A free-standing block of cabinets with an overhanging worktop."""
    material, body = wood_or_paint(rng)
    w, d, h = rng.uniform(0.9, 1.6), rng.uniform(0.6, 0.9), 0.88
    top = pick(rng, ((0.25, 0.25, 0.27), (0.85, 0.84, 0.82), (0.6, 0.42, 0.25), (0.7, 0.7, 0.72)))
    parts = cabinet(
        body, (w, d, h), (int(rng.integers(1, 3)), int(rng.integers(2, 4))), body, any_metal(rng)
    )
    parts.append(box((0, 0.08, h), (w + 0.1, d + 0.25, 0.04), shade(rng, top)))
    return Shape(material, parts)


def range_hood(rng: Random) -> Shape:
    """A hood: a canopy under a chimney, or a flat box, or a slanted sheet of glass."""
    metal = casing(rng) if rng.random() < 0.5 else STEEL
    w, d = rng.uniform(0.6, 1.0), rng.uniform(0.4, 0.5)
    kind = rng.random()
    if kind < 0.6:
        h, low = rng.uniform(0.2, 0.3), 0.05
        rows = [
            np.array(
                [
                    (-w / 2, -d / 2, low),
                    (w / 2, -d / 2, low),
                    (w / 2, d / 2, low),
                    (-w / 2, d / 2, low),
                    (-w / 2, -d / 2, low),
                ]
            )
        ]
        top = np.array(
            [(-0.14, 0, h), (0.14, 0, h), (0.14, d / 2, h), (-0.14, d / 2, h), (-0.14, 0, h)]
        )
        faces = [sheet(np.array([rows[0][i : i + 2], top[i : i + 2]]), metal) for i in range(4)]
        parts = [
            box((0, 0, 0), (w, d, low), metal),
            *faces,
            box((0, d / 4, h - 0.02), (0.28, d / 2, rng.uniform(0.3, 0.6)), metal),
        ]
    elif kind < 0.85:
        parts = [
            box((0, 0, 0), (w, d, 0.14), metal),
            box((0, -d / 2 - 0.004, 0.04), (w * 0.4, 0.01, 0.05), BLACK),
        ]
    else:
        plate = box((0, 0, 0), (w, 0.04, 0.45), BLACK)
        parts = [tilted(plate, (-1, 0, 0), -0.6), box((0, 0.12, 0.1), (0.3, 0.26, 0.6), metal)]
    parts += [
        box((x, -d / 2 - 0.004 if kind < 0.85 else -0.03, 0.015), (0.02, 0.01, 0.02), BLACK)
        for x in (0.1, 0.15, 0.2)
    ]
    return Shape("metal", parts)
