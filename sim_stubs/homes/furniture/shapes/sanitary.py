"""Procedural sinks, toilets and what belongs to them."""

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
    shifted,
    tilted,
    tube,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    CHROME,
    STEEL,
    Random,
    Shape,
    any_cloth,
    any_metal,
    any_white,
    any_wood,
    cabinet,
    pick,
    shade,
    wood_or_paint,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder, stretched

BASIN = (0.70, 0.73, 0.76)
"""The shaded inside of white basins."""


def sink(rng: Random) -> Shape:
    """A washbasin on a pedestal, at the wall, or in a cabinet; or a steel sink in a worktop."""
    kind = rng.random()
    if kind < 0.25:
        return _pedestal_basin(rng)
    if kind < 0.42:
        return _hung_basin(rng)
    if kind < 0.75:
        return _vanity(rng)
    return _kitchen_sink(rng)


def tap(rng: Random, at: tuple[float, float, float], height: float) -> list[Part]:
    """A tap whose spout reaches to the front."""
    x, y, z = at
    metal: Surface = CHROME if rng.random() < 0.8 else any_metal(rng)
    reach = rng.uniform(0.10, 0.16)
    if rng.random() < 0.5:
        path = [
            (x, y, z),
            *arc_points(
                (x, y - reach / 2, z + height - reach / 2),
                (0, reach / 2, 0),
                (0, 0, reach / 2),
                0,
                pi,
                8,
            ),
        ]
        parts = [tube(path, 0.011, metal, 6)]
    else:
        parts = [
            cylinder((x, y, z), 0.02, height * 0.8, metal, segments=10),
            rod((x, y, z + height * 0.7), (x, y - reach, z + height * 0.6), 0.012, metal),
        ]
    if rng.random() < 0.5:
        parts += [cylinder((x + s * 0.08, y, z), 0.02, 0.05, metal, segments=8) for s in (-1, 1)]
    else:
        parts.append(rod((x, y, z + height * 0.8), (x, y + 0.02, z + height), 0.008, metal))
    return parts


def _basin(rng: Random, w: float, d: float, top: float, deep: float, white: Surface) -> list[Part]:
    """A round or squarish bowl with its rim at `top` [m], about the origin."""
    power = float(rng.choice([1.0, 0.6, 0.25]))
    rings = (
        (0.55, top - deep),
        (0.9, top - deep * 0.5),
        (1.0, top - 0.02),
        (1.0, top),
        (0.86, top),
    )
    plan = ellipse(w, d, 28, power)
    plan = np.vstack([plan, plan[:1]])
    rows = [np.column_stack([plan * r, np.full(len(plan), z)]) for r, z in rings]
    inside = [
        np.column_stack([plan * r, np.full(len(plan), z)])
        for r, z in ((0.86, top), (0.7, top - deep * 0.5), (0.02, top - deep * 0.75))
    ]
    return [sheet(np.array(rows[i : i + 2]), white) for i in range(4)] + [
        sheet(np.array(inside[i : i + 2]), BASIN) for i in range(2)
    ]


def _pedestal_basin(rng: Random) -> Shape:
    white = any_white(rng)
    w, d, top = rng.uniform(0.5, 0.68), rng.uniform(0.42, 0.5), rng.uniform(0.8, 0.88)
    column = turned(
        [(0.14, 0), (0.12, 0.06), (0.08, 0.3), (0.09, top - 0.15), (0.16, top - 0.06)], white
    )
    parts = [
        shifted(column, (0, 0.03, 0)),
        *_basin(rng, w, d, top, 0.17, white),
        box((0, d / 2 - 0.05, top - 0.08), (w * 0.8, 0.12, 0.085), white),
        *tap(rng, (0, d / 2 - 0.06, top), rng.uniform(0.12, 0.18)),
    ]
    return Shape("porcelain", parts)


def _hung_basin(rng: Random) -> Shape:
    white = any_white(rng)
    w, d, top = rng.uniform(0.42, 0.7), rng.uniform(0.36, 0.48), rng.uniform(0.82, 0.88)
    parts = [
        *_basin(rng, w, d, top, 0.16, white),
        box((0, d / 2 - 0.05, top - 0.12), (w * 0.9, 0.12, 0.12), white),
        *tap(rng, (0, d / 2 - 0.06, top), 0.15),
        rod((0, 0, top - 0.15), (0, 0, 0.45), 0.02, CHROME),
        rod((0, 0, 0.46), (0, d / 2, 0.46), 0.02, CHROME),
        box((0, d / 2 + 0.002, 0), (0.1, 0.004, 0.5), white),
    ]
    if rng.random() < 0.4:
        parts.append(
            rod((-w / 2, -d / 2 - 0.02, top - 0.1), (w / 2, -d / 2 - 0.02, top - 0.1), 0.01, CHROME)
        )
        parts.append(
            box((w * 0.1, -d / 2 - 0.03, top - 0.45), (w * 0.5, 0.02, 0.36), any_cloth(rng))
        )
    return Shape("porcelain", parts)


def _vanity(rng: Random) -> Shape:
    material, wood = wood_or_paint(rng)
    double = rng.random() < 0.25
    w = rng.uniform(1.2, 1.7) if double else rng.uniform(0.55, 1.0)
    d, top = rng.uniform(0.42, 0.55), rng.uniform(0.76, 0.86)
    base = float(rng.choice([0.0, 0.1, 0.25]))
    white = any_white(rng)
    columns = 4 if double else int(rng.integers(1, 3))
    parts = cabinet(
        wood,
        (w, d, top - 0.04),
        (int(rng.integers(1, 4)), columns),
        wood,
        any_metal(rng),
        knobs=bool(rng.random() < 0.5),
        base=base,
    )
    if base:
        parts += [
            box((s * (w / 2 - 0.03), y, 0), (0.05, 0.05, base), wood)
            for s in (-1, 1)
            for y in (-d / 2 + 0.04, d / 2 - 0.04)
        ]
    worktop = (
        white
        if rng.random() < 0.6
        else shade(rng, pick(rng, ((0.3, 0.3, 0.32), (0.7, 0.65, 0.58))))
    )
    parts.append(box((0, -0.01, top - 0.04), (w + 0.03, d + 0.03, 0.04), worktop))
    for x in (-w / 4, w / 4) if double else (0.0,):
        if rng.random() < 0.5:
            bowl_ = _basin(rng, 0.42, 0.34, top + 0.12, 0.13, white)
        else:
            plan = ellipse(0.44, 0.32, 24, float(rng.choice([1.0, 0.3])))
            bowl_ = [prism(plan * 1.08, top, 0.012, white), prism(plan, top + 0.001, 0.014, BASIN)]
        parts += [shifted(part, (x, -0.03, 0)) for part in bowl_]
        parts += tap(rng, (x, d / 2 - 0.06, top), rng.uniform(0.16, 0.26))
    if rng.random() < 0.3:
        tall = rng.uniform(0.6, 0.9)
        parts += [
            box((0, d / 2 - 0.01, top + 0.15), (w * 0.8, 0.02, tall), STEEL),
            box(
                (0, d / 2 - 0.022, top + 0.18),
                (w * 0.8 - 0.06, 0.006, tall - 0.06),
                (0.74, 0.82, 0.87),
            ),
            box((0, d / 2 - 0.01, top - 0.02), (w * 0.1, 0.02, 0.2), STEEL),
        ]
    return Shape(material, parts)


def _kitchen_sink(rng: Random) -> Shape:
    material, front = wood_or_paint(rng)
    w, d, top = rng.uniform(0.6, 1.2), rng.uniform(0.56, 0.62), rng.uniform(0.85, 0.9)
    columns = 2 if w < 0.9 else 3
    steel: Surface = STEEL if rng.random() < 0.75 else any_white(rng)
    dark = (0.42, 0.44, 0.46) if steel == STEEL else BASIN
    worktop = shade(rng, pick(rng, ((0.25, 0.25, 0.27), (0.8, 0.79, 0.77), (0.6, 0.42, 0.25))))
    parts = [
        *cabinet(front, (w, d, top - 0.04), (1, columns), front, any_metal(rng), base=0.08),
        box((0, 0.04, 0), (w, d - 0.1, 0.08), BLACK),
        box((0, -0.01, top - 0.04), (w + 0.01, d + 0.03, 0.04), worktop),
    ]
    bowls, span = (2 if w > 0.9 else 1), min(w - 0.1, 0.85)
    parts.append(box((0, -0.02, top), (span, d * 0.8, 0.008), steel))
    drainer = bowls == 1 and w > 0.8
    for i in range(bowls):
        x = ((i + 0.5) / bowls - 0.5) * span if bowls > 1 else (-span / 4 if drainer else 0.0)
        size = span / (2 if bowls > 1 or drainer else 1) - 0.08
        parts.append(
            prism(ellipse(size, d * 0.58, 24, 0.25) + vec(x, -0.03), top + 0.008, 0.003, dark)
        )
        parts.append(cylinder((x, -0.03, top + 0.011), 0.03, 0.002, BLACK, segments=12))
    if drainer:
        parts += [
            box((span / 4 + dx, -0.03, top + 0.008), (0.012, d * 0.55, 0.006), dark)
            for dx in np.linspace(-span * 0.18, span * 0.18, 6)
        ]
    parts += tap(rng, (0, d / 2 - 0.08, top), rng.uniform(0.24, 0.36))
    return Shape(material if rng.random() < 0.5 else "metal", parts)


def toilet(rng: Random) -> Shape:
    """A bowl on the floor or at the wall, its cistern behind it or in the wall, lid up or down."""
    white = any_white(rng)
    seat: Surface = white if rng.random() < 0.75 else any_wood(rng)
    w, d = rng.uniform(0.34, 0.41), rng.uniform(0.48, 0.58)
    rim, power = rng.uniform(0.38, 0.43), rng.uniform(0.45, 1.0)
    parts: list[Part] = []
    hung = rng.random() < 0.25
    if hung:
        body = [(0.16, 0.1), (0.34, 0.16), (0.46, 0.28), (0.5, rim)]
    else:
        foot = rng.uniform(0.26, 0.4)
        body = [(foot, 0.0), (foot * 0.95, 0.1), (foot * 0.95, 0.18), (0.44, 0.3), (0.5, rim)]
    bowl_ = turned(body, white, segments=24)
    parts += [shifted(part, (0, -0.1, 0)) for part in stretched([bowl_], (w, d, 1.0))]
    if not hung and rng.random() < 0.6:
        parts.append(box((0, 0.12, 0), (w * 0.6, 0.36, rim - 0.02), white))
    parts.append(box((0, 0.14, rim - 0.14), (w * 0.9, 0.26, 0.14), white))
    ring = ellipse(w, d, 28, power)
    parts += [
        shifted(prism(ring, rim - 0.01, 0.03, seat), (0, -0.1, 0)),
        shifted(prism(ring * 0.66, rim + 0.015, 0.007, BASIN), (0, -0.12, 0)),
    ]
    lid = prism(ring * (0.98, 0.95), 0, 0.025, seat)
    up = rng.random() < 0.45
    back = d / 2 - 0.1
    if up:
        raised = facing(lid, (0, back - 0.02, rim + 0.03 + d * 0.475))
        parts.append(tilted(raised, (-1, 0, 0), 0.12, (0, back, rim)))
    else:
        parts.append(shifted(lid, (0, -0.1, rim + 0.022)))
    kind = rng.random()
    if hung or kind < 0.12:
        parts.append(
            box(
                (0, back + 0.09, 0),
                (w + rng.uniform(0.1, 0.3), 0.14, rng.uniform(0.85, 1.1)),
                white,
            )
        )
        plate = box((0, back + 0.015, 0.8 if not up else 0.84), (0.2, 0.012, 0.1), CHROME)
        parts.append(plate)
    else:
        tall, wide = rng.uniform(0.34, 0.42), rng.uniform(0.34, 0.46)
        soft = rng.uniform(0.05, 0.3)
        at = (0, back + 0.09, rim - 0.04)
        parts.append(
            cushion(at, (wide, 0.18, tall), white, soft)
            if soft > 0.15
            else box(at, (wide, 0.18, tall), white)
        )
        top = rim - 0.04 + tall
        parts += [
            box((0, back + 0.09, top), (wide + 0.02, 0.2, 0.03), white),
            cylinder((0, back + 0.09, top + 0.03), 0.025, 0.012, CHROME),
        ]
    return Shape("porcelain", parts)


def bidet(rng: Random) -> Shape:
    """A low basin with a tap."""
    white = any_white(rng)
    w, d, rim = rng.uniform(0.34, 0.4), rng.uniform(0.5, 0.58), rng.uniform(0.36, 0.42)
    foot = rng.uniform(0.28, 0.42)
    body = turned(
        [
            (foot, 0),
            (foot * 0.95, 0.12),
            (0.42, rim * 0.7),
            (0.5, rim - 0.03),
            (0.5, rim),
            (0.4, rim),
            (0.3, rim - 0.06),
            (0.0, rim - 0.1),
        ],
        white,
        segments=26,
    )
    hollow = turned([(0.41, rim + 0.001), (0.0, rim - 0.09)], BASIN, segments=26)
    parts = stretched([body, hollow], (w, d, 1.0))
    y = d / 2 - 0.05
    parts += [
        box((0, y - 0.02, rim - 0.06), (w * 0.8, 0.12, 0.07), white),
        *tap(rng, (0, y, rim), 0.13),
    ]
    return Shape("porcelain", parts)


def urinal(rng: Random) -> Shape:
    """A shell at the wall."""
    white = any_white(rng)
    w, h = rng.uniform(0.32, 0.4), rng.uniform(0.6, 0.9)
    rows = []
    for t in np.linspace(0, 1, 12):
        z = h * t
        out = 0.30 * (1 - t) ** 0.7 * (0.35 + 0.65 * min(1.0, t / 0.12)) + 0.08
        angles = np.linspace(pi, 2 * pi, 13)
        half = w / 2 * (0.55 + 0.45 * min(1.0, t / 0.25)) * (1.0 if t < 0.8 else 1.0 - (t - 0.8))
        rows.append(np.column_stack([half * np.cos(angles), out * np.sin(angles), np.full(13, z)]))
    hollow = prism(ellipse(w * 0.66, h * 0.58, 24), 0, 0.05, BASIN)
    parts = [
        sheet(np.array(rows), white, both=True),
        box((0, 0.02, 0), (w * 0.9, 0.04, h), white),
        tilted(facing(hollow, (0, -0.24, h * 0.55)), (-1, 0, 0), 0.3, (0, -0.24, h * 0.55)),
        rod((0, -0.02, h), (0, -0.02, h + 0.2), 0.014, CHROME),
        cylinder((0, -0.02, h + 0.2), 0.03, 0.05, CHROME),
    ]
    return Shape("porcelain", parts)
