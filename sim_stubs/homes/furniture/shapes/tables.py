"""Procedural tables."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    ellipse,
    prism,
    rod,
    sheet,
    translucent,
    tube,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    GLASS,
    Random,
    Shape,
    any_cloth,
    any_metal,
    any_wood,
    legs,
    wood_or_paint,
)
from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import Surface, box


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
