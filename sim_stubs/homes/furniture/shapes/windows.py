"""Procedural windows and doors, as pieces that stand in a wall or against it."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    facing,
    prism,
    rod,
    translucent,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    CHROME,
    Random,
    Shape,
    any_metal,
    any_paint,
    any_wood,
    pick,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box

PANE = (0.66, 0.80, 0.90)


def window(rng: Random) -> Shape:
    """A window of one to four casements, or two sashes; with muntins, a sill, an arch."""
    frame = _frame_colour(rng)
    casements = int(rng.integers(1, 5))
    w = casements * rng.uniform(0.45, 0.65)
    h = rng.uniform(0.95, 1.5) if rng.random() < 0.75 else rng.uniform(1.9, 2.15)
    rim, deep = rng.uniform(0.04, 0.07), rng.uniform(0.06, 0.14)
    arched = rng.random() < 0.15
    parts = _leaf_frame((0.0, 0.0), (w, h), rim, deep, frame)
    sash = casements <= 2 and rng.random() < 0.35
    columns, rows = pick(rng, ((1, 1), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (2, 4)))
    wide = (w - 2 * rim) / casements
    for i in range(casements):
        x = -w / 2 + rim + (i + 0.5) * wide
        halves = (
            [
                (rim, (h - 2 * rim) / 2 + 0.02, -0.015),
                (h / 2 - 0.02, (h - 2 * rim) / 2 + 0.02, 0.015),
            ]
            if sash
            else [(rim, h - 2 * rim, 0.0)]
        )
        for z, tall, y in halves:
            parts += _leaf_frame((x, z), (wide, tall), rim * 0.8, deep * 0.5, frame, y)
            pane = box((x, y, z + 0.02), (wide - rim, 0.006, tall - 0.04), PANE)
            parts.append(translucent(pane, rng.uniform(0.2, 0.4)))
            for k in range(1, columns):
                parts.append(
                    box((x - wide / 2 + wide * k / columns, y, z), (0.018, 0.02, tall), frame)
                )
            for k in range(1, rows):
                parts.append(box((x, y, z + tall * k / rows), (wide, 0.02, 0.018), frame))
        if not sash:
            side = wide / 2 - rim * 0.6
            parts.append(
                box(
                    (x + side * (-1 if i % 2 else 1), -deep / 2 - 0.01, h * 0.45),
                    (0.02, 0.03, 0.1),
                    CHROME,
                )
            )
    if arched:
        half = w / 2
        curve = arc_points((0, 0, 0), (half, 0, 0), (0, half * 0.5, 0), 0, pi, 14)[:, :2]
        parts.append(facing(prism(curve, 0, deep, frame), (0, deep / 2, h)))
        parts.append(facing(prism(curve * 0.88, 0, deep + 0.004, PANE), (0, deep / 2, h)))
        parts += [
            rod(
                (0, -deep / 2, h),
                (half * 0.85 * np.cos(a), -deep / 2, h + half * 0.42 * np.sin(a)),
                0.01,
                frame,
            )
            for a in (pi / 4, pi / 2, 3 * pi / 4)
        ]
    if rng.random() < 0.6:
        parts.append(box((0, -deep * 0.6, -0.0), (w + 0.12, deep + 0.14, 0.03), frame))
    return Shape("", parts)


def _frame_colour(rng: Random) -> Surface:
    kind = rng.random()
    if kind < 0.6:
        return shade(rng, (0.92, 0.92, 0.91), 0.05)
    if kind < 0.85:
        return any_wood(rng)
    return shade(rng, pick(rng, ((0.2, 0.2, 0.22), (0.45, 0.46, 0.48), (0.15, 0.28, 0.2))))


def _leaf_frame(
    at: tuple[float, float],
    size: tuple[float, float],
    rim: float,
    deep: float,
    surface: Surface,
    y: float = 0.0,
) -> list[Part]:
    """Four bars around an opening of a width and height whose lower middle is x, z."""
    (x, z), (width, height) = at, size
    return [
        *[box((x + s * (width - rim) / 2, y, z), (rim, deep, height), surface) for s in (-1, 1)],
        *[box((x, y, bottom), (width, deep, rim), surface) for bottom in (z, z + height - rim)],
    ]


def door(rng: Random) -> Shape:
    """A leaf in its frame: plain, panelled or with panes; single or double."""
    leaf: Surface = pick(
        rng, (shade(rng, (0.92, 0.92, 0.91), 0.04), any_wood(rng), any_wood(rng), any_paint(rng))
    )
    frame: Surface = leaf if rng.random() < 0.5 else shade(rng, (0.92, 0.92, 0.91), 0.04)
    leaves = 2 if rng.random() < 0.2 else 1
    w, h, deep = rng.uniform(0.72, 0.95), rng.uniform(1.98, 2.1), 0.12
    total = w * leaves + 0.14
    parts = [
        *[box((s * (total - 0.07) / 2, 0, 0), (0.07, deep, h + 0.07), frame) for s in (-1, 1)],
        box((0, 0, h), (total, deep, 0.07), frame),
    ]
    style = rng.integers(4)
    metal = any_metal(rng)
    for i in range(leaves):
        x = (i - (leaves - 1) / 2) * w
        parts.append(box((x, 0, 0.005), (w - 0.008, 0.045, h - 0.01), leaf))
        dark = _darker(leaf)
        if style == 1:
            columns, rows = int(rng.integers(1, 3)), int(rng.integers(2, 4))
            for c in range(columns):
                for r in range(rows):
                    cw, ch = (w - 0.2) / columns, (h - 0.3) / rows
                    at = (x - w / 2 + 0.1 + (c + 0.5) * cw, 0, 0.15 + r * ch)
                    parts.append(box(at, (cw - 0.07, 0.05, ch - 0.09), dark))
                    parts.append(box((at[0], 0, at[2] + 0.03), (cw - 0.13, 0.056, ch - 0.15), leaf))
        elif style == 2:
            low = h * float(rng.choice([0.15, 0.45]))
            tall, wide = h - low - 0.15, w - 0.28
            parts.append(box((x, 0, low), (wide, 0.05, tall), PANE))
            parts += [
                box((x, 0, low + tall * k / 4), (wide, 0.054, 0.02), leaf) for k in range(1, 4)
            ]
            parts.append(box((x, 0, low), (0.02, 0.054, tall), leaf))
        side = 1 if i == 0 else -1
        hx = x + side * (w / 2 - 0.07)
        for y in (-0.05, 0.05):
            parts += [
                rod((hx, 0, 1.02), (hx, y, 1.02), 0.012, metal),
                box((hx - side * 0.05, y, 1.01), (0.13, 0.018, 0.02), metal),
            ]
        parts.append(box((hx, 0, 0.9), (0.04, 0.05, 0.2), metal if rng.random() < 0.5 else BLACK))
    return Shape("wooden" if not isinstance(leaf, tuple) else "", parts)


def _darker(surface: Surface) -> Surface:
    """A shade for grooves: darker than a plain colour; dark brown in grained wood."""
    if isinstance(surface, tuple):
        red, green, blue = surface
        return red * 0.75, green * 0.75, blue * 0.75
    return 0.25, 0.17, 0.11
