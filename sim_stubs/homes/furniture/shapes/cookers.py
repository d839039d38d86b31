"""Procedural cookers and small kitchen machines."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    facing,
    rod,
    translucent,
    tube,
    turned,
)
from sim_stubs.homes.furniture.shapes.machines import casing
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    CHROME,
    STEEL,
    Random,
    Shape,
    any_paint,
    pick,
)
from sim_stubs.homes.geometry.solids import box, cushion, cylinder


def oven(rng: Random) -> Shape:
    """A cooker with hob, knobs and a door of dark glass; or a built-in oven; single or double."""
    body, w, d = casing(rng), rng.uniform(0.56, 0.9), rng.uniform(0.55, 0.65)
    cooker = rng.random() < 0.65
    h = rng.uniform(0.84, 0.92) if cooker else rng.uniform(0.58, 0.62)
    y = -d / 2
    double = not cooker and rng.random() < 0.4
    h = h * 1.8 if double else h
    parts = [box((0, 0, 0), (w, d, h), body)]
    knobs = int(rng.integers(3, 7))
    panel_z = h - 0.12
    parts.append(box((0, y, panel_z), (w, 0.02, 0.11), pick(rng, (body, BLACK, STEEL))))
    for x in np.linspace(-w * 0.4, w * 0.4, knobs):
        parts.append(
            facing(
                cylinder((0, 0, 0), 0.02, 0.03, pick(rng, (BLACK, CHROME)), segments=12),
                (x, y - 0.01, panel_z + 0.055),
            )
        )
    if rng.random() < 0.5:
        parts.append(box((0, y - 0.012, panel_z + 0.03), (0.14, 0.006, 0.05), (0.08, 0.12, 0.1)))
    low = 0.14 if cooker else 0.03
    doors = [(low, panel_z - 0.02 - low)]
    if double:
        half = (panel_z - 0.02 - low) / 2
        doors = [(low, half - 0.02), (low + half, half)]
    for z, tall in doors:
        parts += [
            box((0, y, z), (w - 0.02, 0.03, tall), body),
            box((0, y - 0.012, z + tall * 0.14), (w * 0.72, 0.012, tall * 0.55), BLACK),
            box((0, y - 0.05, z + tall - 0.06), (w * 0.8, 0.02, 0.022), CHROME),
            *[
                box((s * w * 0.38, y - 0.03, z + tall - 0.06), (0.02, 0.04, 0.02), CHROME)
                for s in (-1, 1)
            ],
        ]
    if cooker:
        gas = rng.random() < 0.5
        parts += [
            box((0, y - 0.002, 0.03), (w - 0.02, 0.012, 0.09), body),
            box(
                (0, 0, h), (w - 0.01, d - 0.01, 0.008), BLACK if gas or rng.random() < 0.6 else body
            ),
        ]
        for sx in (-1, 1):
            for sy in (-1, 1):
                at = (sx * w * 0.22, sy * d * 0.22, h + 0.008)
                if gas:
                    parts += [
                        cylinder(at, 0.04, 0.02, STEEL, segments=12),
                        box((at[0], at[1], at[2] + 0.02), (0.2, 0.012, 0.012), BLACK),
                        box((at[0], at[1], at[2] + 0.02), (0.012, 0.2, 0.012), BLACK),
                    ]
                else:
                    parts.append(
                        cylinder(at, rng.uniform(0.07, 0.1), 0.006, (0.35, 0.12, 0.10), segments=20)
                    )
        if rng.random() < 0.4:
            parts.append(box((0, d / 2 - 0.02, h), (w, 0.04, rng.uniform(0.1, 0.25)), body))
    return Shape("metal" if body == STEEL else "", parts)


def microwave(rng: Random) -> Shape:
    """A box with a window at the left and controls at the right."""
    body = casing(rng)
    w, d, h = rng.uniform(0.42, 0.56), rng.uniform(0.32, 0.4), rng.uniform(0.24, 0.32)
    y, split = -d / 2, w * rng.uniform(0.68, 0.78)
    parts = [
        box((0, 0, 0.01), (w, d, h - 0.01), body),
        box((0, 0, 0), (w - 0.08, d - 0.08, 0.012), BLACK),
    ]
    x = -w / 2 + split / 2
    parts += [
        box((x, y, 0.02), (split - 0.02, 0.014, h - 0.03), pick(rng, (body, BLACK))),
        box((x - 0.005, y - 0.008, 0.055), (split - 0.1, 0.008, h - 0.1), (0.10, 0.11, 0.12)),
        box((x + split / 2 - 0.03, y - 0.025, 0.05), (0.015, 0.02, h - 0.1), CHROME),
    ]
    cx, cw = -w / 2 + split + (w - split) / 2, w - split - 0.02
    parts += [
        box((cx, y, 0.02), (cw, 0.012, h - 0.03), pick(rng, (BLACK, body, (0.3, 0.32, 0.34)))),
        box((cx, y - 0.007, h - 0.075), (cw * 0.8, 0.006, 0.035), (0.1, 0.35, 0.25)),
    ]
    if rng.random() < 0.5:
        for row in range(4):
            for column in range(3):
                at = (cx + (column - 1) * cw * 0.27, y - 0.007, 0.05 + row * (h - 0.15) / 4)
                parts.append(box(at, (cw * 0.18, 0.006, 0.016), (0.7, 0.7, 0.72)))
    else:
        parts += [
            facing(cylinder((0, 0, 0), cw * 0.28, 0.025, STEEL, segments=14), (cx, y, z))
            for z in (h * 0.28, h * 0.52)
        ]
    return Shape("", parts)


def coffee_machine(rng: Random) -> Shape:
    """A filter machine with its jug, or an espresso machine."""
    body, dark = (any_paint(rng), BLACK) if rng.random() < 0.5 else (casing(rng), BLACK)
    if rng.random() < 0.55:
        w, h = rng.uniform(0.17, 0.24), rng.uniform(0.3, 0.38)
        jug = turned(
            [(0, 0.035), (0.065, 0.035), (0.078, 0.08), (0.05, 0.15), (0.055, 0.16)],
            (0.25, 0.2, 0.18),
            (0, -0.05, 0),
        )
        handle = tube(
            arc_points((0, -0.13, 0.1), (0, 0, 0.045), (0, -0.045, 0), 0, pi, 8), 0.008, dark, 6
        )
        parts = [
            box((0, 0, 0), (w, 0.26, 0.03), dark),
            box((0, 0.08, 0), (w, 0.1, h), body),
            box((0, -0.01, h - 0.13), (w, 0.22, 0.13), body),
            translucent(jug, 0.75),
            handle,
        ]
    else:
        w, d, h = rng.uniform(0.2, 0.5), rng.uniform(0.28, 0.36), rng.uniform(0.28, 0.36)
        parts = [
            box((0, 0, 0), (w, d, 0.05), STEEL),
            box((0, d * 0.25, 0), (w, d * 0.5, h), body),
            box((0, 0, h - 0.1), (w, d, 0.1), body),
        ]
        for x in (-w / 5, w / 5) if w > 0.32 else (0.0,):
            parts += [
                cylinder((x, -d * 0.25, h - 0.14), 0.03, 0.05, CHROME, segments=12),
                rod((x, -d * 0.25, h - 0.12), (x, -d * 0.25 - 0.16, h - 0.13), 0.012, BLACK),
                cylinder((x, -d * 0.25, 0.05), 0.028, 0.06, (0.93, 0.93, 0.92), 0.035, 12),
            ]
        parts.append(
            facing(cylinder((0, 0, 0), 0.025, 0.01, (0.9, 0.9, 0.9)), (w * 0.35, -d / 2, h - 0.05))
        )
    return Shape("", parts)


def toaster(rng: Random) -> Shape:
    """Two slots, a lever, and toast now and then."""
    body = any_paint(rng) if rng.random() < 0.5 else casing(rng)
    w, d, h = rng.uniform(0.26, 0.34), rng.uniform(0.15, 0.2), rng.uniform(0.17, 0.21)
    parts = [
        box((0, 0, 0), (w * 0.92, d * 0.9, 0.02), BLACK),
        cushion((0, 0, 0.012), (w, d, h), body, 0.25),
        *[box((0, y, h + 0.003), (w * 0.7, 0.026, 0.012), BLACK) for y in (-d * 0.17, d * 0.17)],
        box((w / 2, 0, h * 0.55), (0.04, 0.04, 0.02), BLACK),
        facing(
            cylinder((0, 0, 0), 0.016, 0.02, BLACK, segments=10), (w * 0.3, -d / 2 + 0.005, 0.06)
        ),
    ]
    if rng.random() < 0.6:
        parts += [
            cushion((0, y, h - 0.03), (w * 0.5, 0.018, 0.09), (0.68, 0.45, 0.22), 0.3, 6)
            for y in (-d * 0.17, d * 0.17)
        ]
    return Shape("", parts)
