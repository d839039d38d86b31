"""Procedural baskets, bins, boxes and bags."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    ellipse,
    prism,
    rod,
    sheet,
    shifted,
    tube,
    turned,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    STEEL,
    Random,
    Shape,
    any_cloth,
    any_leather,
    any_metal,
    any_paint,
    any_wood,
    pick,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder
from sim_stubs.homes.textures import patterns

WICKER = ((0.62, 0.45, 0.26), (0.78, 0.64, 0.42), (0.40, 0.26, 0.15), (0.88, 0.84, 0.76))


def laundry_basket(rng: Random) -> Shape:
    """A basket of wicker, mesh or cloth, round or square, with a lid or laundry in it."""
    style = rng.random()
    if style < 0.3:
        return _hamper(rng)
    h, w = rng.uniform(0.38, 0.65), rng.uniform(0.36, 0.5)
    round_ = rng.random() < 0.55
    wicker = rng.random() < 0.6
    colour = shade(rng, pick(rng, WICKER))
    wall: Surface = (
        patterns.fabric(rng.texture(5), colour, shade(rng, pick(rng, WICKER)))
        if wicker and rng.random() < 0.5
        else colour
    )
    if not wicker:
        wall = any_paint(rng)
    plan = ellipse(w, w * (1.0 if round_ else rng.uniform(0.7, 1.0)), 24, 1.0 if round_ else 0.25)
    plan = np.vstack([plan, plan[:1]])
    narrow = rng.uniform(0.75, 1.0)
    levels = np.linspace(0, 1, 7)
    rows = np.array(
        [np.column_stack([plan * (narrow + (1 - narrow) * t), np.full(25, t * h)]) for t in levels]
    )
    parts = [prism(plan[:-1] * narrow, 0.0, 0.02, wall), sheet(rows, wall, both=True)]
    if wicker:
        ribs = shade(rng, colour, 0.3)
        for t in levels[1::2]:
            ring = np.column_stack([plan * (narrow + (1 - narrow) * t) * 1.01, np.full(25, t * h)])
            parts.append(tube(ring, 0.01, ribs, 4))
    else:
        holes = tuple(0.35 * c for c in wall) if not isinstance(wall, Path) else BLACK
        for t in (0.25, 0.45, 0.65, 0.85):
            for k in range(0, 24, 2):
                x, y = plan[k] * (narrow + (1 - narrow) * t) * 1.01
                slot = box((0, 0, t * h - 0.02), (0.025, 0.004, 0.05), holes)
                parts.append(shifted(slot, (x, y, 0), float(np.arctan2(y, x)) + pi / 2))
    rim = np.column_stack([plan * 1.01, np.full(25, h)])
    parts.append(tube(rim, 0.014, wall if wicker else any_paint(rng), 6))
    if rng.random() < 0.35:
        parts.append(prism(plan[:-1] * 1.02, h, 0.03, wall))
        parts.append(
            tube(arc_points((0, 0, h + 0.03), (0.05, 0, 0), (0, 0, 0.03), 0, pi, 6), 0.008, wall, 5)
        )
    else:
        parts += _laundry(rng, w, h)
    return Shape("wicker" if wicker else "plastic", parts)


def _laundry(rng: Random, w: float, h: float) -> list[Part]:
    heap = []
    for _ in range(int(rng.integers(2, 6))):
        x, y = rng.uniform(-0.2, 0.2, 2) * w
        size = (w * rng.uniform(0.35, 0.6), w * rng.uniform(0.3, 0.5), rng.uniform(0.1, 0.18))
        lump = cushion((0, 0, 0), size, any_cloth(rng), 0.8, 6)
        heap.append(shifted(lump, (x, y, h - 0.1), rng.uniform(0, 3)))
    return heap


def _hamper(rng: Random) -> Shape:
    """A cloth bag hung in a crossed frame of wood."""
    wood: Surface = any_wood(rng) if rng.random() < 0.8 else any_metal(rng)
    cloth: Surface = shade(rng, (0.86, 0.80, 0.66)) if rng.random() < 0.6 else any_cloth(rng)
    w, d, h = rng.uniform(0.42, 0.58), rng.uniform(0.36, 0.54), rng.uniform(0.58, 0.72)
    parts: list[Part] = []
    for y in (-d / 2, d / 2):
        for s in (-1, 1):
            parts.append(rod((s * w / 2, y, 0), (-s * w / 2, y, h), 0.015, wood))
    parts += [
        rod((s * w / 2, -d / 2, z), (s * w / 2, d / 2, z), 0.014, wood)
        for s in (-1, 1)
        for z in (0.012, h)
    ]
    t = 0.05
    plan = ellipse(w - t, d - t, 24, 0.2)
    plan = np.vstack([plan, plan[:1]])
    rows = [
        np.column_stack([plan * s, np.full(25, z)])
        for s, z in ((0.72, 0.1), (0.82, h * 0.5), (1.0, h - 0.01))
    ]
    parts += [sheet(np.array(rows), cloth, both=True), prism(plan[:-1] * 0.72, 0.09, 0.012, cloth)]
    if rng.random() < 0.5:
        parts += _laundry(rng, w * 0.9, h - 0.06)
    return Shape("fabric", parts)


def suitcase(rng: Random) -> Shape:
    """A case on wheels with a pulled handle, or one to carry, standing up."""
    shell: Surface = any_paint(rng) if rng.random() < 0.7 else any_leather(rng)
    w, d, h = rng.uniform(0.4, 0.55), rng.uniform(0.2, 0.3), rng.uniform(0.55, 0.78)
    dark = shade(rng, (0.2, 0.2, 0.22))
    if rng.random() < 0.6:
        pull = rng.uniform(0.02, 0.45)
        parts = [
            cushion((0, 0, 0.05), (w, d, h), shell, 0.22),
            *[
                box((x, -d / 2 + 0.008, 0.12), (0.02, 0.02, h - 0.14), dark)
                for x in np.linspace(-w * 0.36, w * 0.36, int(rng.integers(2, 6)))
            ],
            *[
                cylinder((sx * w * 0.38, sy * d * 0.3, 0), 0.03, 0.06, BLACK, segments=8)
                for sx in (-1, 1)
                for sy in (-1, 1)
            ],
            *[
                rod((s * 0.1, d * 0.35, h), (s * 0.1, d * 0.35, h + pull + 0.05), 0.009, STEEL)
                for s in (-1, 1)
            ],
            box((0, d * 0.35, h + pull + 0.04), (0.24, 0.03, 0.03), BLACK),
            cushion((0, 0, h + 0.04), (0.16, 0.03, 0.035), BLACK, 0.5, 4),
        ]
        return Shape("plastic", parts)
    w, h = h * 1.1, w * 1.15
    parts = [
        cushion((0, 0, 0), (w, d, h), shell, 0.15),
        box((0, 0, h * 0.02), (w + 0.004, 0.016, h * 0.96), dark),
        tube(arc_points((0, 0, h - 0.01), (0.09, 0, 0), (0, 0, 0.06), 0, pi, 8), 0.014, dark, 6),
        *[box((s * w * 0.3, -d / 2, h * 0.05), (0.05, 0.012, h * 0.9), dark) for s in (-1, 1)],
        *[box((s * w * 0.3, -0.01, h - 0.01), (0.06, 0.05, 0.02), STEEL) for s in (-1, 1)],
    ]
    return Shape("leather", parts)


def backpack(rng: Random) -> Shape:
    """A bag with a flap, pockets and straps."""
    cloth = any_cloth(rng)
    second = any_cloth(rng) if rng.random() < 0.5 else cloth
    w, d, h = rng.uniform(0.28, 0.36), rng.uniform(0.16, 0.24), rng.uniform(0.4, 0.52)
    parts = [
        cushion((0, 0, 0), (w, d, h), cloth, 0.4),
        cushion((0, -d * 0.45, 0.03), (w * 0.75, 0.1, h * 0.42), second, 0.4),
        cushion((0, -d * 0.1, h * 0.62), (w * 0.98, d * 1.05, h * 0.4), second, 0.5),
        box((0, -d * 0.62, h * 0.5), (0.03, 0.012, h * 0.2), (0.2, 0.15, 0.1)),
        tube(arc_points((0, 0.05, h), (0.04, 0, 0), (0, 0, 0.05), 0, pi, 6), 0.008, cloth, 5),
    ]
    parts += [
        cushion((s * w * 0.52, 0, 0.04), (0.07, d * 0.6, h * 0.35), second, 0.5, 6) for s in (-1, 1)
    ]
    for s in (-1, 1):
        strap = arc_points(
            (s * w * 0.28, d / 2, h * 0.5), (0, 0.08, 0), (0, 0, h * 0.4), -pi / 2, pi / 2, 8
        )
        parts.append(tube(strap, 0.018, cloth, 5))
    return Shape("fabric", parts)


def cardboard_box(rng: Random) -> Shape:
    """Closed with tape, or with its flaps open."""
    paper = shade(rng, (0.72, 0.54, 0.36))
    w, d, h = rng.uniform(0.35, 0.7), rng.uniform(0.3, 0.5), rng.uniform(0.25, 0.45)
    if rng.random() < 0.5:
        tape = (0.82, 0.72, 0.52)
        parts = [
            box((0, 0, 0), (w, d, h), paper),
            box((0, 0, h), (w + 0.002, 0.05, 0.002), tape),
            *[box((s * w / 2, 0, h - 0.08), (0.003, 0.05, 0.08), tape) for s in (-1, 1)],
        ]
        return Shape("", parts)
    t, dark = 0.008, shade(rng, (0.52, 0.38, 0.25))
    parts = [
        box((0, 0, 0), (w, d, t), dark),
        *[box((0, s * (d - t) / 2, 0), (w, t, h), paper) for s in (-1, 1)],
        *[box((s * (w - t) / 2, 0, 0), (t, d, h), paper) for s in (-1, 1)],
    ]
    lift = rng.uniform(-0.1, 0.12)
    for s in (-1, 1):
        a, b = np.array([-w / 2, s * d / 2, h]), np.array([w / 2, s * d / 2, h])
        out = np.array([0, s * d * 0.4, lift])
        parts.append(sheet(np.array([[a, b], [a + out, b + out]]), paper, both=True))
        a, b = np.array([s * w / 2, -d / 2, h]), np.array([s * w / 2, d / 2, h])
        out = np.array([s * d * 0.4, 0, lift + 0.05])
        parts.append(sheet(np.array([[a, b], [a + out, b + out]]), paper, both=True))
    return Shape("", parts)


def trash_can(rng: Random) -> Shape:
    """A bin: open, with a swing or pedal lid, round or square, for paper or recycling."""
    skin: Surface = pick(
        rng, (STEEL, shade(rng, BLACK), any_paint(rng), any_paint(rng), (0.85, 0.85, 0.86))
    )
    r, h, kind = rng.uniform(0.12, 0.19), rng.uniform(0.28, 0.7), rng.random()
    wide = rng.uniform(0.75, 1.0)
    if kind < 0.3:
        plan = ellipse(2 * r, 1.5 * r, 24, 0.2)
        closed = np.vstack([plan, plan[:1]])
        rows = [np.column_stack([closed * s, np.full(25, z)]) for s, z in ((wide, 0.0), (1.0, h))]
        parts = [
            sheet(np.array(rows), skin, both=True),
            prism(plan * wide, 0, 0.01, skin),
            prism(plan * 0.97, h * 0.55, 0.01, (0.12, 0.12, 0.13)),
        ]
        parts.append(tube(np.column_stack([closed * 1.02, np.full(25, h)]), 0.012, skin, 5))
    elif kind < 0.6:
        walls = turned([(r * wide, 0), (r, h)], skin, segments=24)
        inner = turned(
            [(r * 0.99, h), (r * wide * 0.99, 0.02), (0, 0.02)], (0.15, 0.15, 0.16), segments=24
        )
        rim = tube(arc_points((0, 0, h), (r, 0, 0), (0, r, 0), 0, 2 * pi, 24), 0.008, skin, 5)
        parts = [
            walls,
            inner,
            rim,
            cushion((0, 0, h * 0.4), (r, r, h * 0.3), (0.9, 0.9, 0.88), 1.0, 6),
        ]
    else:
        lid: Surface = skin if rng.random() < 0.5 else pick(rng, (BLACK, STEEL))
        bullet = rng.random() < 0.5
        top = (
            [(r * 1.02, h), (r * 0.95, h + r * 0.45), (r * 0.6, h + r * 0.8), (0, h + r * 0.95)]
            if bullet
            else [(r * 1.03, h), (r, h + 0.03), (r * 0.5, h + 0.06), (0, h + 0.065)]
        )
        parts = [
            turned([(0, 0), (r * wide, 0), (r, h)], skin, segments=24),
            turned([(r * 1.02, h - 0.015), *top], lid, segments=24),
            box((0, -r - 0.02, 0.01), (0.09, 0.07, 0.02), BLACK),
        ]
        if bullet:
            parts.append(
                box((0, -r * 0.9, h + r * 0.1), (r * 1.1, 0.08, r * 0.3), (0.1, 0.1, 0.11))
            )
    return Shape("metal" if skin == STEEL else "plastic", parts)
