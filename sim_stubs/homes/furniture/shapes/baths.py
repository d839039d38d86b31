"""Procedural bathtubs, showers, towel racks and water heaters."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    ellipse,
    facing,
    prism,
    rod,
    sheet,
    translucent,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    CHROME,
    GLASS,
    STEEL,
    WATER,
    Random,
    Shape,
    any_cloth,
    any_metal,
    any_white,
    any_wood,
    shade,
)
from sim_stubs.homes.furniture.shapes.sanitary import BASIN
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder


def bathtub(rng: Random) -> Shape:
    """A tub: built in, free-standing, on claws, or in a corner; empty or full."""
    white, kind = any_white(rng), rng.random()
    full = rng.random() < 0.4
    metal = CHROME if rng.random() < 0.8 else any_metal(rng)
    if kind < 0.2:
        return _corner_tub(rng, white, metal, full)
    w, d, h = rng.uniform(1.5, 1.85), rng.uniform(0.68, 0.85), rng.uniform(0.5, 0.65)
    built_in = kind < 0.55
    plan = ellipse(1, 1, 33, 0.25 if built_in else float(rng.choice([0.45, 0.7])))
    plan = np.vstack([plan, plan[:1]]) * (w, d)
    foot = 0.0 if built_in or rng.random() < 0.5 else 0.14
    rise = 0.0 if built_in else float(rng.choice([0.0, 0.12]))

    def ring(scale: float, z: float, lift: float = 0.0) -> np.ndarray:
        heights = z + lift * (2 * plan[:, 0] / w) ** 2
        return np.column_stack([plan * (scale + (1 - scale) * 0.35, scale), heights])

    outer = 1.0 if built_in else rng.uniform(0.62, 0.85)
    rows = [
        ring(outer, foot),
        ring((1 + outer) / 2 + 0.03, (foot + h) / 2, rise / 2),
        ring(1.0, h, rise),
    ]
    parts: list[Part] = [sheet(np.array(rows), white)]
    if built_in:
        panel_: Surface = white if rng.random() < 0.6 else any_wood(rng)
        parts = [
            *[box((0, k * (d / 2 - 0.01), 0), (w, 0.02, h - 0.05), panel_) for k in (-1, 1)],
            *[box((k * (w / 2 - 0.01), 0, 0), (0.02, d, h - 0.05), panel_) for k in (-1, 1)],
            sheet(np.array([ring(1.0, h - 0.06), ring(1.0, h)]), white),
        ]
    rim = 0.86 if built_in else 0.92
    parts.append(sheet(np.array([ring(1.0, h, rise), ring(rim, h, rise)]), white))
    deep = 0.14 + foot
    parts.append(
        sheet(
            np.array(
                [ring(rim, h, rise), ring(rim - 0.05, (h + deep) / 2), ring(rim - 0.22, deep)]
            ),
            BASIN,
        )
    )
    level = h - 0.14 if full else deep + 0.005
    surface = WATER if full else BASIN
    parts.append(prism(plan[:-1] * (rim - (0.03 if full else 0.2)), level - 0.01, 0.012, surface))
    if foot:
        parts += [
            turned(
                [(0.02, 0), (0.035, 0.03), (0.03, 0.09), (0.06, 0.2)],
                metal,
                (sx * w * 0.32, sy * d * 0.27, 0),
                8,
            )
            for sx in (-1, 1)
            for sy in (-1, 1)
        ]
    if built_in and rng.random() < 0.3:
        screen = box((-w / 4, -d / 2 + 0.02, h), (w / 2, 0.01, 1.3), GLASS)
        parts += [
            translucent(screen, 0.35),
            box((-w / 2, -d / 2 + 0.02, h), (0.03, 0.03, 1.3), CHROME),
        ]
    x, side = (w / 2 - 0.04, 0.0) if rng.random() < 0.6 else (0.0, d / 2 - 0.04)
    parts += [
        rod((x, side, h - 0.02 + rise * (x > 0)), (x, side, h + 0.2), 0.018, metal),
        rod(
            (x, side, h + 0.16),
            (x - 0.16 * (x > 0), side - 0.16 * (side > 0), h + 0.14),
            0.014,
            metal,
        ),
    ]
    return Shape("porcelain" if not built_in else "", parts)


def _corner_tub(rng: Random, white: Surface, metal: Surface, full: bool) -> Shape:
    """A quarter of a circle with its corner at the back right."""
    r, h = rng.uniform(1.25, 1.5), rng.uniform(0.5, 0.6)
    curve = arc_points((0, 0, 0), (-r, 0, 0), (0, -r, 0), 0, pi / 2, 14)[:, :2]
    plan = np.vstack([curve, [(0, 0)]])
    basin = ellipse(r * 1.0, r * 0.68, 26, 0.8)
    turn = np.array([[np.cos(-pi / 4), -np.sin(-pi / 4)], [np.sin(-pi / 4), np.cos(-pi / 4)]])
    basin = basin @ turn.T + vec(-r * 0.43, -r * 0.43)
    parts = [
        prism(plan, 0, h, white),
        prism(basin, h, 0.004, BASIN),
        prism(
            (basin - basin.mean(axis=0)) * 0.86 + basin.mean(axis=0),
            h + 0.004,
            0.003,
            WATER if full else (0.6, 0.63, 0.66),
        ),
        rod((-0.15, -0.15, h), (-0.15, -0.15, h + 0.2), 0.018, metal),
        rod((-0.15, -0.15, h + 0.18), (-0.28, -0.28, h + 0.15), 0.014, metal),
    ]
    return Shape("", parts)


def shower(rng: Random) -> Shape:
    """A stall with a tray, panes of glass in frames, and a shower head on its pole."""
    w, d, h = rng.uniform(0.8, 1.2), rng.uniform(0.8, 1.0), rng.uniform(1.9, 2.1)
    frame, tray = any_metal(rng), any_white(rng)
    rounded = rng.random() < 0.4
    parts: list[Part] = []
    if rounded:
        r = min(w, d)
        w = d = r
        front = arc_points((r / 2, r / 2, 0), (-r, 0, 0), (0, -r, 0), 0, pi / 2, 10)
        parts.append(prism(np.vstack([front[:, :2], [(r / 2, r / 2)]]), 0, 0.13, tray))
        for z0, z1 in ((0.13, 0.17), (h - 0.04, h)):
            parts.append(
                sheet(np.array([front + vec(0, 0, z0), front + vec(0, 0, z1)]), frame, both=True)
            )
        pane = sheet(
            np.array([front + vec(0, 0, 0.17), front + vec(0, 0, h - 0.04)]), GLASS, both=True
        )
        parts.append(translucent(pane, 0.35))
        posts = [front[i][:2] for i in (0, 5, 10)]
    else:
        parts.append(box((0, 0, 0), (w, d, 0.12), tray))
        posts = [np.array([sx * w / 2, -d / 2]) for sx in (-1, 0, 1)] + [np.array([-w / 2, d / 2])]
        for z in (0.12, h - 0.04):
            parts += [
                box((0, -d / 2, z), (w, 0.03, 0.04), frame),
                box((-w / 2, 0, z), (0.03, d, 0.04), frame),
            ]
        parts += [
            translucent(box((0, -d / 2, 0.16), (w, 0.008, h - 0.2), GLASS), 0.35),
            translucent(box((-w / 2, 0, 0.16), (0.008, d, h - 0.2), GLASS), 0.35),
        ]
    parts += [box((x, y, 0.1), (0.035, 0.035, h - 0.1), frame) for x, y in posts]
    wall = shade(rng, (0.82, 0.86, 0.88))
    if rng.random() < 0.6:
        parts += [box((0, d / 2, 0), (w, 0.02, h), wall), box((w / 2, 0, 0), (0.02, d, h), wall)]
    x, y = w / 2 - 0.3, d / 2 - 0.04
    parts += [
        rod((x, y, 0.9), (x, y, h - 0.05), 0.012, CHROME),
        rod((x, y, h - 0.05), (x, y - 0.2, h - 0.03), 0.01, CHROME),
        cylinder((x, y - 0.22, h - 0.06), 0.09, 0.02, CHROME),
        box((x, y, 1.0), (0.25, 0.05, 0.05), CHROME),
        box((0.06, -d / 2 - 0.025, 1.0), (0.02, 0.03, 0.25), frame),
    ]
    return Shape("glass", parts)


def towel_rack(rng: Random) -> Shape:
    """Rails at the wall with towels over them."""
    metal, w, count = any_metal(rng), rng.uniform(0.5, 0.7), int(rng.integers(1, 4))
    parts: list[Part] = []
    drops = rng.uniform(0.3, 0.5)
    top = drops + 0.02 + 0.12 * (count - 1)
    for i in range(count):
        y, z = -0.07 - 0.06 * i, top - 0.12 * i
        parts.append(rod((-w / 2, y, z), (w / 2, y, z), 0.009, metal))
        parts += [rod((s * w / 2, 0, z), (s * w / 2, y, z), 0.008, metal) for s in (-1, 1)]
        if i == count - 1 or rng.random() < 0.5:
            cloth, x = any_cloth(rng), rng.uniform(-0.1, 0.1)
            half = rng.uniform(0.14, 0.2)
            long = drops if i == count - 1 else 0.1
            parts += [
                cushion((x, y - 0.014, z - long), (2 * half, 0.016, long + 0.01), cloth, 0.1, 4),
                cushion(
                    (x, y + 0.014, z - long * 0.9),
                    (2 * half, 0.016, long * 0.9 + 0.01),
                    cloth,
                    0.1,
                    4,
                ),
            ]
    return Shape("metal", parts)


def water_heater(rng: Random) -> Shape:
    """A boiler: a round or flat body with pipes below it."""
    white = any_white(rng)
    h = rng.uniform(0.6, 1.0)
    if rng.random() < 0.65:
        r = rng.uniform(0.2, 0.25)
        body = turned(
            [
                (0, 0.12),
                (r * 0.8, 0.12),
                (r, 0.17),
                (r, h + 0.05),
                (r * 0.8, h + 0.12),
                (0, h + 0.13),
            ],
            white,
            segments=24,
        )
        front = -r
    else:
        body, front = box((0, 0, 0.12), (0.42, 0.34, h), white), -0.17
    dial = facing(cylinder((0, 0, 0), 0.035, 0.02, BLACK), (0, front + 0.005, 0.3))
    parts = [
        body,
        dial,
        *[rod((x, 0, 0), (x, 0, 0.14), 0.012, (0.7, 0.45, 0.3)) for x in (-0.08, 0.08)],
    ]
    parts.append(
        cylinder((0, 0, 0.1), 0.05, 0.03, STEEL)
        if rng.random() < 0.5
        else box((0, front - 0.002, h * 0.8), (0.12, 0.006, 0.04), (0.2, 0.35, 0.7))
    )
    return Shape("", parts)
