"""Procedural household machines, for the kitchen and for laundry."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    ellipse,
    facing,
    prism,
    rod,
    tilted,
    translucent,
    tube,
    turned,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    CHROME,
    STEEL,
    Random,
    Shape,
    any_paint,
    any_white,
    disc,
    pick,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder


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


def casing(rng: Random) -> Surface:
    """Enamel or steel: mostly white, then grey and black, seldom a colour."""
    kind = rng.random()
    if kind < 0.5:
        return any_white(rng)
    if kind < 0.8:
        return shade(rng, STEEL)
    return shade(rng, BLACK) if kind < 0.9 else any_paint(rng)


def refrigerator(rng: Random) -> Shape:
    """One door, a freezer above or below, or two doors side by side."""
    body, handle = casing(rng), pick(rng, (CHROME, STEEL, BLACK, (0.8, 0.8, 0.8)))
    kind = rng.random()
    french = kind > 0.65
    w = rng.uniform(0.8, 0.95) if french else rng.uniform(0.54, 0.72)
    d, h = rng.uniform(0.6, 0.75), rng.uniform(1.6, 1.9) if kind > 0.15 else rng.uniform(0.85, 1.3)
    t, gap = 0.05, 0.008
    soft = rng.random() < 0.3
    if french:
        drawer = rng.uniform(0.3, 0.4) * h if rng.random() < 0.6 else 0.03
        doors = [(-w / 4, drawer, w / 2, h - drawer, 1), (w / 4, drawer, w / 2, h - drawer, -1)]
        if drawer > 0.1:
            doors.append((0.0, 0.04, w, drawer - 0.04, 0))
    elif kind > 0.3:
        cut = h * float(rng.choice([rng.uniform(0.28, 0.4), rng.uniform(0.62, 0.72)]))
        doors = [(0.0, cut, w, h - cut, 1), (0.0, 0.04, w, cut - 0.04, 1)]
    else:
        doors = [(0.0, 0.04, w, h - 0.04, 1)]
    parts = [
        box((0, 0.02, 0.0), (w, d - t, h), body),
        box((0, -d / 2 + t, 0), (w - 0.06, 0.02, 0.05), BLACK),
    ]
    side = float(rng.choice([-1.0, 1.0]))
    for x, z, wide, tall, way in doors:
        size = (wide - gap, t, tall - gap)
        at = (x, -d / 2 + t / 2, z)
        parts.append(cushion(at, size, body, 0.08) if soft else box(at, size, body))
        way = way if french else int(way * side)
        if way:
            grip = min(tall * 0.5, 0.6)
            low = z + (0.05 if z > h * 0.5 and not french else tall - grip - 0.08)
            hx = x + way * (wide / 2 - 0.06)
            parts.append(box((hx, -d / 2 - 0.03, low), (0.022, 0.022, grip), handle))
            parts += [
                box((hx, -d / 2 - 0.012, low + k), (0.018, 0.03, 0.018), handle)
                for k in (0.02, grip - 0.04)
            ]
        else:
            parts.append(
                box((x, -d / 2 - 0.03, z + tall - 0.09), (wide * 0.7, 0.022, 0.022), handle)
            )
    if french and rng.random() < 0.5:
        parts.append(box((-w / 4, -d / 2 - 0.004, h * 0.58), (w * 0.22, 0.01, h * 0.16), BLACK))
    for _ in range(int(rng.integers(0, 5)) if rng.random() < 0.35 else 0):
        at = (rng.uniform(-w * 0.3, w * 0.3), -d / 2 - 0.002, rng.uniform(h * 0.5, h * 0.85))
        parts.append(
            box(at, (rng.uniform(0.05, 0.12), 0.004, rng.uniform(0.05, 0.14)), any_paint(rng))
        )
    return Shape("metal" if body == STEEL else "", parts)


def washing_machine(rng: Random) -> Shape:
    """A front loader, or a top loader with its lid and controls at the back."""
    body = any_white(rng) if rng.random() < 0.75 else shade(rng, STEEL)
    if rng.random() < 0.65:
        return Shape("", _front_loader(rng, body, drawer=True))
    w, d, h = rng.uniform(0.55, 0.7), rng.uniform(0.58, 0.68), rng.uniform(0.85, 0.95)
    tall = rng.uniform(0.1, 0.2)
    parts = [
        box((0, 0, 0), (w, d, h), body),
        box((0, -0.06, h), (w * 0.82, d * 0.62, 0.025), shade(rng, (0.85, 0.86, 0.88))),
        box((0, -0.06 - d * 0.31, h + 0.012), (0.16, 0.03, 0.02), STEEL),
        tilted(
            box((0, d / 2 - 0.08, h - 0.02), (w, 0.1, tall + 0.02), body),
            (-1, 0, 0),
            0.2,
            (0, d / 2, h),
        ),
    ]
    for x in np.linspace(-w * 0.35, w * 0.35, int(rng.integers(2, 5))):
        knob = facing(
            cylinder((0, 0, 0), 0.025, 0.03, pick(rng, (STEEL, BLACK))),
            (x, d / 2 - 0.13, h + tall / 2),
        )
        parts.append(knob)
    return Shape("", parts)


def dryer(rng: Random) -> Shape:
    """A front loader without a drawer for powder, its door wide and often square or solid."""
    return Shape("", _front_loader(rng, any_white(rng), drawer=False))


def _front_loader(rng: Random, body: Surface, *, drawer: bool) -> list[Part]:
    w, d, h = rng.uniform(0.58, 0.66), rng.uniform(0.52, 0.64), rng.uniform(0.82, 0.9)
    y, z, r = -d / 2, h * rng.uniform(0.44, 0.52), rng.uniform(0.17, 0.23)
    ring: Surface = pick(rng, (CHROME, STEEL, (0.9, 0.9, 0.9), BLACK))
    glass = (0.16, 0.19, 0.23) if drawer or rng.random() < 0.4 else (0.85, 0.86, 0.88)
    band = pick(rng, (body, (0.55, 0.58, 0.62), (0.80, 0.81, 0.83), BLACK))
    parts = [
        box((0, 0, 0.02), (w, d, h - 0.02), body),
        box((0, 0.02, 0), (w - 0.06, d - 0.06, 0.03), BLACK),
        box((0, y, h - 0.14), (w - 0.01, 0.012, 0.125), band),
        box((0, y, 0.03), (w - 0.02, 0.01, 0.1), shade(rng, (0.82, 0.83, 0.84))),
    ]
    power = 1.0 if drawer or rng.random() < 0.6 else 0.2
    for scale, out, surface in ((1.0, 0.03, ring), (0.8, 0.042, glass), (0.5, 0.05, glass)):
        plate = prism(ellipse(2 * r * scale, 2 * r * scale, 28, power), 0, out, surface)
        parts.append(facing(plate, (0, y, z)))
    parts.append(box((r * 0.9, y - 0.035, z - 0.05), (0.03, 0.02, 0.1), STEEL))
    if drawer:
        parts.append(box((-w / 2 + 0.12, y - 0.008, h - 0.125), (0.19, 0.014, 0.095), body))
    x = rng.uniform(-0.02, 0.1)
    parts.append(
        facing(disc((0, 0, 0), 0.035, 0.035, pick(rng, (STEEL, BLACK, body))), (x, y, h - 0.078))
    )
    parts.append(box((w / 2 - 0.11, y - 0.008, h - 0.1), (0.14, 0.008, 0.045), (0.1, 0.13, 0.16)))
    return parts


def dishwasher(rng: Random) -> Shape:
    """A cabinet-sized machine with a plain door, a bar, and controls above it."""
    body = casing(rng)
    w, d, h = rng.uniform(0.45, 0.6), rng.uniform(0.56, 0.62), rng.uniform(0.82, 0.87)
    parts = [
        box((0, 0.02, 0), (w, d - 0.04, h), body),
        box((0, -d / 2 + 0.02, 0.1), (w - 0.01, 0.03, h - 0.22), body),
        box((0, -d / 2 + 0.02, h - 0.11), (w - 0.01, 0.03, 0.105), pick(rng, (body, BLACK, STEEL))),
        box((0, -d / 2 - 0.015, h - 0.17), (w * 0.7, 0.02, 0.025), CHROME),
        box((0, -d / 2 + 0.06, 0), (w, 0.02, 0.09), BLACK),
    ]
    parts += [
        box((x, -d / 2 + 0.003, h - 0.07), (0.02, 0.008, 0.02), (0.3, 0.6, 0.4))
        for x in (0.05, 0.1, 0.15)
    ]
    return Shape("", parts)


def freezer(rng: Random) -> Shape:
    """A chest with its lid on top."""
    white = any_white(rng)
    w, d, h = rng.uniform(0.8, 1.3), rng.uniform(0.56, 0.68), rng.uniform(0.75, 0.9)
    grey = shade(rng, (0.6, 0.62, 0.64))
    parts = [
        box((0, 0, 0.04), (w, d, h - 0.12), white),
        box((0, 0, h - 0.08), (w + 0.02, d + 0.02, 0.008), grey),
        cushion((0, 0, h - 0.07), (w + 0.02, d + 0.02, 0.08), white, 0.1),
        box((0, 0, 0), (w - 0.06, d - 0.06, 0.05), BLACK),
        box((0, -d / 2 - 0.02, h - 0.055), (0.18, 0.03, 0.04), grey),
        box((w / 2 - 0.18, -d / 2 - 0.003, 0.08), (0.24, 0.008, 0.12), grey),
    ]
    return Shape("", parts)
