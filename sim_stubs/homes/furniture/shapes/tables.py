"""Procedural tables and desks."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    ellipse,
    facing,
    prism,
    rod,
    sheet,
    shifted,
    translucent,
    tube,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    GLASS,
    Random,
    Shape,
    any_cloth,
    any_metal,
    any_wood,
    cabinet,
    legs,
    pick,
    shade,
    wood_or_paint,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cylinder


def dining_table(rng: Random) -> Shape:
    """A table to eat at."""
    if rng.random() < 0.25:
        across = rng.uniform(0.85, 1.3)
        return _table(rng, across, across, rng.uniform(0.72, 0.77), round_=True)
    return _table(rng, rng.uniform(1.0, 2.1), rng.uniform(0.7, 1.0), rng.uniform(0.72, 0.77))


def any_table(rng: Random) -> Shape:
    """Any table: to eat at, low, or a small round one."""
    kind = rng.random()
    if kind < 0.6:
        return dining_table(rng)
    if kind < 0.8:
        return coffee_table(rng)
    across = rng.uniform(0.5, 0.8)
    return _table(rng, across, across, rng.uniform(0.6, 1.05), round_=bool(rng.random() < 0.6))


def coffee_table(rng: Random) -> Shape:
    """A low table, perhaps with a shelf under it."""
    w, d, h = rng.uniform(0.8, 1.3), rng.uniform(0.45, 0.75), rng.uniform(0.36, 0.5)
    round_ = bool(rng.random() < 0.2)
    shape = _table(rng, d * 1.3 if round_ else w, d * 1.3 if round_ else d, h, round_=round_)
    if not round_ and rng.random() < 0.4:
        shelf = any_wood(rng)
        shape.parts.append(box((0, 0, h * 0.3), (w - 0.12, d - 0.12, 0.025), shelf))
    return shape


def _table(
    rng: Random, width: float, depth: float, height: float, *, round_: bool = False
) -> Shape:
    """A top of wood or glass on legs, a pedestal, trestles, or under a cloth."""
    material, wood = wood_or_paint(rng)
    kind = rng.random()
    if kind < 0.08:
        return Shape("fabric", _under_cloth(rng, width, depth, height, round_))
    glass = kind > 0.82
    metal = glass or rng.random() < 0.2
    stand: Surface = any_metal(rng) if metal else wood
    thick = 0.014 if glass else rng.uniform(0.025, 0.05)
    plan = ellipse(width, depth, 32, 1.0 if round_ else 0.08)
    top = prism(plan, height - thick, thick, GLASS if glass else wood)
    parts = [translucent(top, 0.45) if glass else top]
    under = height - thick
    pedestal = round_ and rng.random() < 0.6
    if pedestal:
        parts += _pedestal(rng, min(width, depth), under, stand)
    elif not round_ and rng.random() < 0.22:
        parts += _trestles(rng, width, depth, under, stand)
    else:
        t = rng.uniform(0.03, 0.045) if metal else rng.uniform(0.045, 0.09)
        shrink, splay = (0.7 if round_ else 1.0), float(rng.choice([0.0, 0.0, 0.05]))
        inset = rng.uniform(0.02, 0.12) * (height / 0.75)
        w, d = width * shrink - inset, depth * shrink - inset
        parts += legs(w, d, under, t, stand, splay=splay, round_=metal or rng.random() < 0.2)
        if not glass or rng.random() < 0.5:
            apron = 0.03 if metal else rng.uniform(0.06, 0.1)
            for s in (-1, 1):
                parts.append(box((0, s * (d - t) / 2, under - apron), (w - t, 0.02, apron), stand))
                parts.append(box((s * (w - t) / 2, 0, under - apron), (0.02, d - t, apron), stand))
        if not metal and rng.random() < 0.2:
            parts.append(box((0, 0, 0.12), (w - t, 0.05, 0.05), stand))
            parts += [box((s * (w - t) / 2, 0, 0.12), (0.05, d - t, 0.05), stand) for s in (-1, 1)]
    return Shape("glass" if glass else material, parts)


def _pedestal(rng: Random, across: float, height: float, surface: Surface) -> list[Part]:
    if rng.random() < 0.5:
        foot = turned(
            [
                (0, 0),
                (across * 0.28, 0),
                (across * 0.26, 0.03),
                (0.05, 0.06),
                (0.035, height * 0.5),
                (0.04, height - 0.04),
                (0.14, height),
            ],
            surface,
        )
        return [foot]
    column = turned(
        [(0, 0.1), (0.07, 0.12), (0.09, 0.25), (0.05, 0.35), (0.06, height - 0.05), (0.2, height)],
        surface,
    )
    feet = []
    for k in range(4):
        way = np.array([np.cos(k * pi / 2 + pi / 4), np.sin(k * pi / 2 + pi / 4), 0.0])
        path = [
            way * 0.04 + vec(0, 0, 0.22),
            way * across * 0.2 + vec(0, 0, 0.12),
            way * across * 0.38 + vec(0, 0, 0.035),
        ]
        feet.append(tube(path, 0.035, surface, 6))
    return [column, *feet]


def _trestles(
    rng: Random, width: float, depth: float, height: float, surface: Surface
) -> list[Part]:
    """Two stands: slabs, crossed legs, or a pair of splayed legs each."""
    style, parts = rng.integers(3), []
    x = width / 2 - width * 0.14
    for s in (-1, 1):
        d = depth / 2 - 0.06
        if style == 0:
            parts += [
                box((s * x, 0, 0), (0.05, depth * 0.7, 0.05), surface),
                box((s * x, 0, 0), (0.05, depth * 0.3, height), surface),
            ]
        elif style == 1:
            parts += [
                rod((s * x, -d, 0), (s * x, d, height), 0.025, surface),
                rod((s * x, d, 0), (s * x, -d, height), 0.025, surface),
            ]
        else:
            for y in (-d, d):
                parts += [
                    rod((s * x + 0.14, y, 0), (s * x, y * 0.8, height), 0.018, surface),
                    rod((s * x - 0.14, y, 0), (s * x, y * 0.8, height), 0.018, surface),
                ]
            parts.append(box((s * x, 0, height - 0.06), (0.05, depth * 0.85, 0.06), surface))
    if style == 0:
        parts.append(box((0, 0, height * 0.3), (2 * x, 0.03, 0.09), surface))
    return parts


def _under_cloth(
    rng: Random, width: float, depth: float, height: float, round_: bool
) -> list[Part]:
    cloth = any_cloth(rng)
    drop = height * rng.uniform(0.35, 0.95)
    rings = []
    count = 41
    angles = np.linspace(0, 2 * pi, count)
    power = 1.0 if round_ else 0.2
    for flare, z in (
        (1.0, height - drop),
        (1.0, height - drop / 2),
        (1.0, height - 0.01),
        (0.98, height),
    ):
        waves = 1 + 0.05 * np.sin(9 * angles) * (height - z) / height
        ways = np.column_stack([np.cos(angles), np.sin(angles)])
        xy = (
            np.sign(ways)
            * np.abs(ways) ** power
            * (width / 2, depth / 2)
            * (flare * waves)[:, None]
        )
        rings.append(np.column_stack([xy, np.full(count, z)]))
    skirt = sheet(np.array(rings), cloth, both=True)
    top = prism(ellipse(width * 0.98, depth * 0.98, 32, power), height - 0.01, 0.01, cloth)
    return [skirt, top, *legs(width * 0.7, depth * 0.7, height - 0.02, 0.05, any_wood(rng))]


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
