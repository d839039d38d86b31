"""Procedural things of a household, with its textiles."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    ellipse,
    prism,
    rod,
    sheet,
    tube,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
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
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder, flat_panel
from sim_stubs.homes.textures import patterns


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


RUGS = (
    (0.45, 0.10, 0.12),
    (0.14, 0.20, 0.38),
    (0.55, 0.40, 0.26),
    (0.20, 0.32, 0.26),
    (0.62, 0.58, 0.52),
    (0.30, 0.16, 0.12),
    (0.75, 0.62, 0.42),
    (0.82, 0.80, 0.75),
    (0.30, 0.30, 0.33),
    (0.60, 0.22, 0.15),
)


def carpet(rng: Random) -> Shape:
    """A rug, thin enough to be driven over: square, round or oval; plain or patterned."""
    kind = rng.random()
    w, d = rng.uniform(1.2, 2.4), rng.uniform(0.8, 1.7)
    colour, other = (shade(rng, pick(rng, RUGS)) for _ in range(2))
    if kind < 0.3:
        w = d = rng.uniform(0.9, 1.8) if kind < 0.2 else d
        plan = ellipse(w, d if kind < 0.2 else d * 0.65, 40)
        parts = [prism(plan, 0.001, 0.010, colour)]
        for scale in sorted(rng.uniform(0.2, 0.95, int(rng.integers(0, 6))), reverse=True):
            ring = shade(rng, pick(rng, RUGS))
            parts.append(
                prism(plan * scale, 0.011 + 0.0002 * (1 - scale), 0.0006 * (2 - scale), ring)
            )
        if rng.random() < 0.6:
            for k in range(12):
                x, y = plan[k * 40 // 12 % 40] * 0.75
                spot = prism(ellipse(0.12, 0.12, 10) + vec(x, y), 0.0116, 0.001, other)
                parts.append(spot)
        return Shape("fabric", parts)
    if kind < 0.65:
        if rng.random() < 0.5:
            face = patterns.medallion_rug(rng.texture(rng.integers(9)), colour, other)
        else:
            face = patterns.oriental_rug(rng.texture(rng.integers(60)))
    elif kind < 0.8:
        face = patterns.fabric(rng.texture(rng.integers(4)), colour, other)
    else:
        face = patterns.fabric(rng.texture(rng.integers(4)), colour)
    parts = [
        box((0, 0, 0.001), (w, d, 0.010), colour),
        flat_panel((-w / 2, -d / 2, 0.0115), (w, 0, 0), (0, d, 0), face, tile=0),
    ]
    if rng.random() < 0.35:
        fringe = (0.85, 0.82, 0.74)
        parts += [
            box((s * (w / 2 + 0.02), y, 0.001), (0.05, 0.012, 0.006), fringe)
            for s in (-1, 1)
            for y in np.arange(-d / 2 + 0.02, d / 2, 0.05)
        ]
    return Shape("fabric", parts)


def curtain(rng: Random) -> Shape:
    """Cloth in folds on a rod: drawn, or in two halves to the sides."""
    w, h, cloth = rng.uniform(1.0, 1.9), rng.uniform(1.6, 2.35), any_cloth(rng)
    bar = any_metal(rng) if rng.random() < 0.5 else any_wood(rng)
    parts = [rod((-w / 2 - 0.08, 0, h), (w / 2 + 0.08, 0, h), 0.015, bar)]
    parts += [
        turned(
            [(0, 0), (0.03, 0.02), (0.03, 0.05), (0, 0.07)],
            bar,
            (s * (w / 2 + 0.08), 0, h - 0.035),
            8,
        )
        for s in (-1, 1)
    ]
    halves = rng.random() < 0.6
    share = rng.uniform(0.25, 0.5) if halves else 1.0
    for s in (-1, 1) if halves else (0,):
        span = w * share
        x = np.linspace(-span / 2, span / 2, 36) + s * (w - span) / 2
        tied = halves and rng.random() < 0.35
        rows = []
        for t in np.linspace(0, 1, 8):
            tight = 1 - 0.5 * np.exp(-(((t - 0.4) / 0.12) ** 2)) if tied else 1.0
            edge = s * w / 2
            waves = 0.03 * np.sin(2 * pi * x / rng.uniform(0.095, 0.105)) * (1 - 0.3 * t)
            rows.append(
                np.column_stack(
                    [edge + (x - edge) * tight, waves, np.full(36, 0.01 + t * (h - 0.02))]
                )
            )
        parts.append(sheet(np.array(rows), cloth, both=True))
    return Shape("fabric", parts)


def drying_rack(rng: Random) -> Shape:
    """Rails between crossed legs, some with laundry over them."""
    metal = any_metal(rng)
    w, d, h = rng.uniform(0.55, 0.7), rng.uniform(0.9, 1.2), rng.uniform(0.85, 1.05)
    parts: list[Part] = []
    for x in (-w / 2, w / 2):
        parts += [
            rod((x, -d * 0.3, 0), (x, d * 0.3, h), 0.01, metal),
            rod((x, d * 0.3, 0), (x, -d * 0.3, h), 0.01, metal),
        ]
        parts.append(rod((x, -d / 2, h), (x, d / 2, h), 0.01, metal))
        wings = [
            rod((x, s * d * 0.5, h), (x, s * d * 0.72, h + 0.15), 0.009, metal) for s in (-1, 1)
        ]
        parts += wings
    for y in np.linspace(-d / 2, d / 2, 9):
        parts.append(rod((-w / 2, y, h), (w / 2, y, h), 0.005, metal, segments=5))
        if rng.random() < 0.4:
            drop, cloth, half = rng.uniform(0.2, 0.5), any_cloth(rng), rng.uniform(0.12, w * 0.45)
            parts += [
                box((0, y + k * 0.012, h - drop), (2 * half, 0.008, drop + 0.008), cloth)
                for k in (-1, 1)
            ]
    for s in (-1, 1):
        parts.append(
            rod((-w / 2, s * d * 0.72, h + 0.15), (w / 2, s * d * 0.72, h + 0.15), 0.006, metal)
        )
    parts += [
        rod((-w / 2, s * d * 0.3, 0.01), (w / 2, s * d * 0.3, 0.01), 0.01, metal) for s in (-1, 1)
    ]
    return Shape("metal", parts)
