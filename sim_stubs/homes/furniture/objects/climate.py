"""Procedural fans, radiators and coolers."""

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
    translucent,
    tube,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    CHROME,
    PAINTS,
    STEEL,
    Random,
    Shape,
    any_metal,
    any_white,
    pick,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder


def electric_fan(rng: Random) -> Shape:
    """Blades in a round cage, on a table foot or on a pole."""
    r = rng.uniform(0.15, 0.23)
    h = rng.uniform(0.95, 1.3) if rng.random() < 0.5 else r + rng.uniform(0.12, 0.25)
    frame = pick(rng, (CHROME, STEEL, (0.92, 0.92, 0.92), BLACK, shade(rng, pick(rng, PAINTS))))
    blade = shade(
        rng,
        pick(rng, ((0.15, 0.3, 0.7), (0.9, 0.5, 0.3), (0.85, 0.86, 0.88), BLACK, (0.3, 0.55, 0.6))),
    )
    centre = np.array([0.0, -0.08, h])
    parts: list[Part] = []
    blades = int(rng.integers(3, 6))
    for k in range(blades):
        angle = 2 * pi * k / blades + 0.3
        way = np.array([np.cos(angle), 0, np.sin(angle)])
        side = np.array([-np.sin(angle), 0, np.cos(angle)])
        rows = [
            [
                centre + way * r * s + side * r * q * (0.25 + 0.35 * s) + vec(0, 0.05 * q, 0)
                for q in (-1.0, 0.0, 1.0)
            ]
            for s in (0.15, 0.5, 0.85)
        ]
        parts.append(sheet(np.array(rows), blade, both=True))
    hub = facing(
        turned(
            [(0, -0.02), (0.05, -0.02), (0.05, 0.04), (0.03, 0.06), (0, 0.06)], frame, segments=14
        ),
        centre,
    )
    motor = facing(
        turned([(0, -0.14), (0.05, -0.13), (0.06, -0.03), (0.05, -0.02)], frame, segments=14),
        centre,
    )
    parts += [hub, motor]
    for y in (-0.045, 0.045):
        for scale in (1.0, 0.62):
            loop = arc_points(
                centre + vec(0, y * (1 if scale == 1.0 else 1.4), 0),
                (r * scale, 0, 0),
                (0, 0, r * scale),
                0,
                2 * pi,
                20,
            )
            parts.append(tube(loop, 0.005 if scale == 1.0 else 0.003, frame, 4))
        for k in range(14):
            angle = 2 * pi * k / 14
            rim = centre + np.array([r * np.cos(angle), y * 0.6, r * np.sin(angle)])
            parts.append(rod(centre + vec(0, y * 1.5, 0), rim, 0.0025, frame, segments=3))
    parts.append(rod((0, 0.0, 0.02), (0, 0.0, h), 0.018, frame))
    if rng.random() < 0.75:
        parts.append(
            turned([(0, 0), (r * 0.95, 0), (r * 0.9, 0.025), (0.03, 0.05), (0, 0.05)], frame)
        )
    else:
        parts += [
            rod((0, 0, 0.03), (0.2 * np.cos(k), 0.2 * np.sin(k), 0.01), 0.014, frame)
            for k in (0.6, 2.2, 3.9, 5.5)
        ]
    return Shape("", parts)


def ceiling_fan(rng: Random) -> Shape:
    """Blades under a rod, with a lamp below now and then."""
    metal = any_metal(rng)
    blade: Surface = pick(rng, ((0.42, 0.27, 0.18), (0.92, 0.92, 0.9), (0.66, 0.48, 0.28), BLACK))
    drop, r, count = rng.uniform(0.25, 0.5), rng.uniform(0.45, 0.6), int(rng.integers(3, 6))
    lamp = rng.random() < 0.5
    low = 0.14 if lamp else 0.0
    parts = [
        turned(
            [
                (0, low),
                (0.06, low),
                (0.11, low + 0.03),
                (0.11, low + 0.1),
                (0.05, low + 0.14),
                (0, low + 0.14),
            ],
            metal,
        ),
        rod((0, 0, low + 0.12), (0, 0, low + 0.12 + drop), 0.014, metal),
        turned(
            [(0.03, low + 0.06 + drop), (0.07, low + 0.12 + drop), (0, low + 0.12 + drop)], metal
        ),
    ]
    for k in range(count):
        arm = box((0.16, 0, low + 0.05), (0.14, 0.04, 0.01), metal)
        wing = prism(
            ellipse(r - 0.1, 0.14, 16, 0.35) + vec(0.2 + (r - 0.1) / 2, 0), low + 0.055, 0.01, blade
        )
        parts += [
            shifted(part, (0, 0, 0), 2 * pi * k / count)
            for part in (arm, tilted(wing, (1, 0, 0), 0.15, (0, 0, low + 0.06)))
        ]
    if lamp:
        parts.append(
            turned(
                [(0, 0), (0.07, 0.02), (0.1, 0.07), (0.08, 0.13), (0.05, 0.15)], (0.95, 0.94, 0.9)
            )
        )
    return Shape("", parts)


def air_conditioner(rng: Random) -> Shape:
    """The long white box high on a wall."""
    white = any_white(rng)
    w, d, h = rng.uniform(0.75, 1.0), rng.uniform(0.18, 0.24), rng.uniform(0.26, 0.32)
    parts = [
        cushion((0, 0, 0), (w, d, h), white, 0.15),
        box((0, 0.02, 0), (w - 0.02, d - 0.04, h), white),
        box((0, -d / 2 + 0.01, 0.03), (w * 0.86, 0.02, 0.05), (0.35, 0.37, 0.4)),
        *[box((0, -d / 2 - 0.001, z), (w * 0.86, 0.008, 0.006), white) for z in (0.045, 0.06)],
        box((w * 0.36, -d / 2 - 0.001, h * 0.55), (0.08, 0.006, 0.02), (0.15, 0.4, 0.3)),
        box((0, -d / 2 + 0.001, h * 0.38), (w * 0.96, 0.006, 0.006), (0.6, 0.62, 0.64)),
    ]
    return Shape("", parts)


def radiator(rng: Random) -> Shape:
    """Ribs between pipes, a ribbed plate, or a ladder for towels."""
    white = any_white(rng) if rng.random() < 0.8 else any_metal(rng)
    kind = rng.random()
    if kind < 0.25:
        w, h = rng.uniform(0.45, 0.6), rng.uniform(0.9, 1.5)
        parts = [rod((s * w / 2, 0, 0), (s * w / 2, 0, h), 0.018, white) for s in (-1, 1)]
        parts += [
            rod((-w / 2, -0.02, z), (w / 2, -0.02, z), 0.011, white)
            for z in np.linspace(0.06, h - 0.06, 14)
            if round(z * 100) % 5
        ]
        return Shape("metal", parts)
    w, h = rng.uniform(0.5, 1.5), rng.uniform(0.45, 0.75)
    base, d = 0.1, rng.uniform(0.08, 0.16)
    parts = [
        rod((-w / 2, 0, z), (w / 2, 0, z), 0.022, white) for z in (base + 0.06, base + h - 0.06)
    ]
    if kind < 0.65:
        for x in np.arange(-w / 2 + 0.03, w / 2, rng.uniform(0.055, 0.08)):
            parts.append(cushion((x, 0, base), (0.045, d, h), white, 0.5, 4))
    else:
        parts += [box((0, s * d / 2, base), (w, 0.015, h), white) for s in (-1, 1)]
        parts += [
            box((x, -d / 2 - 0.008, base + 0.05), (0.015, 0.014, h - 0.1), white)
            for x in np.arange(-w / 2 + 0.04, w / 2 - 0.02, 0.05)
        ]
        parts.append(box((0, 0, base + h), (w, d + 0.02, 0.012), white))
    parts += [
        rod((s * (w / 2 - 0.08), 0, 0), (s * (w / 2 - 0.08), 0, base + 0.05), 0.014, white)
        for s in (-1, 1)
    ]
    parts.append(
        cylinder((w / 2 + 0.03, 0, base + h - 0.1), 0.025, 0.08, (0.9, 0.9, 0.9), segments=10)
    )
    return Shape("metal", parts)


def water_cooler(rng: Random) -> Shape:
    """A blue bottle upside down on a stand with taps."""
    white = any_white(rng)
    w, h = rng.uniform(0.28, 0.34), rng.uniform(0.9, 1.0)
    blue = shade(rng, (0.45, 0.68, 0.88))
    bottle = turned(
        [
            (0.03, h),
            (0.05, h + 0.03),
            (0.13, h + 0.09),
            (0.135, h + 0.18),
            (0.125, h + 0.2),
            (0.135, h + 0.22),
            (0.135, h + 0.36),
            (0.11, h + 0.4),
            (0, h + 0.41),
        ],
        blue,
    )
    parts = [
        box((0, 0, 0), (w, w, h), white),
        translucent(bottle, 0.7),
        box((0, -w / 2, h - 0.32), (w * 0.8, 0.02, 0.24), (0.5, 0.52, 0.55)),
        box((0, -w / 2 - 0.03, h - 0.33), (w * 0.7, 0.09, 0.02), BLACK),
    ]
    for x, colour in ((-0.05, (0.15, 0.3, 0.75)), (0.05, (0.75, 0.15, 0.15))):
        parts.append(box((x, -w / 2 - 0.03, h - 0.15), (0.035, 0.05, 0.04), colour))
    return Shape("", parts)
