"""Procedural plants and vases."""

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
    tilted,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    PAINTS,
    Random,
    Rgb,
    Shape,
    any_paint,
    pick,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, cushion, cylinder

LEAVES: tuple[Rgb, ...] = (
    (0.13, 0.38, 0.15),
    (0.20, 0.45, 0.14),
    (0.10, 0.30, 0.18),
    (0.32, 0.48, 0.20),
)


POTS: tuple[Rgb, ...] = (
    (0.60, 0.30, 0.22),
    (0.90, 0.90, 0.88),
    (0.20, 0.20, 0.22),
    (0.45, 0.30, 0.20),
    (0.25, 0.38, 0.55),
)


def leaf(base: np.ndarray, way: np.ndarray, length: float, width: float, colour: Surface) -> Part:
    """A leaf that starts upwards along `way` and bends over."""
    side = np.cross(way, (0, 0, 1.0))
    side /= max(float(np.linalg.norm(side)), 1e-6)
    rows = []
    for t, w in ((0.0, 0.15), (0.35, 0.9), (0.7, 0.8), (1.0, 0.05)):
        spine = base + way * length * t - np.array([0, 0, 0.45 * length * t * t])
        rows.append(
            [spine - side * width / 2 * w, spine + vec(0, 0, -0.012), spine + side * width / 2 * w]
        )
    return sheet(np.array(rows), colour, both=True)


def plant(rng: Random) -> Shape:
    """A pot with a rosette, a bush, a small tree, a palm, or upright blades."""
    colour = pick(rng, LEAVES)
    r, pot_h = rng.uniform(0.11, 0.19), rng.uniform(0.16, 0.34)
    pot = shade(rng, pick(rng, POTS))
    wall = [
        (0, 0),
        (r * rng.uniform(0.6, 0.95), 0),
        (r, pot_h),
        (r * 1.06, pot_h),
        (r * 1.06, pot_h + 0.02),
        (r * 0.9, pot_h + 0.02),
    ]
    parts = [turned(wall, pot), cylinder((0, 0, pot_h - 0.02), r * 0.95, 0.025, (0.16, 0.11, 0.09))]
    style = rng.integers(5)
    height = rng.uniform(0.5, 1.3)
    crown = np.array([0, 0, pot_h])
    stem = (0.35, 0.26, 0.16)
    if style == 0:
        count, spots = 26, [(crown, 0.35 + 0.25 * height, 0.07)]
    elif style == 1:
        parts += [
            rod(
                crown,
                crown + vec(rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), height * 0.8),
                0.008,
                stem,
                segments=4,
            )
            for _ in range(4)
        ]
        count = 44
        spots = [
            (crown + vec(rng.uniform(-0.12, 0.12), rng.uniform(-0.12, 0.12), z), 0.22, 0.11)
            for z in np.linspace(0.1, height * 0.8, 22)
        ]
    elif style == 2:
        parts.append(rod(crown, crown + vec(0.02, 0, height * 0.6), 0.018, stem))
        top = crown + vec(0.02, 0, height * 0.65)
        for _ in range(14):
            at = top + rng.normal(0, 0.12, 3) * (1, 1, 0.9)
            parts.append(cushion(at, (0.2, 0.2, 0.15), shade(rng, colour, 0.3), 1.0, 4))
        count, spots = 26, [(top + rng.normal(0, 0.12, 3), 0.16, 0.06) for _ in range(13)]
    elif style == 3:
        trunks = int(rng.integers(1, 4))
        count, spots = 16 * trunks, []
        for k in range(trunks):
            tip = crown + vec(
                rng.uniform(-0.08, 0.08),
                rng.uniform(-0.08, 0.08),
                height * (0.5 + 0.25 * k),
            )
            parts.append(rod(crown, tip, 0.022, stem))
            spots.append((tip, rng.uniform(0.35, 0.5), 0.05))
    else:
        for _ in range(int(rng.integers(10, 20))):
            x, y = rng.uniform(-0.6, 0.6, 2) * r
            blade = rod(
                (x, y, pot_h),
                (2.2 * x, 2.2 * y, pot_h + height * rng.uniform(0.5, 1.0)),
                0.022,
                shade(rng, colour, 0.25),
                0.003,
                4,
            )
            parts.append(blade)
        count, spots = 0, [(crown, 0.1, 0.1)]
    for k in range(count):
        base, length, width = spots[k % len(spots)]
        angle, rise = rng.uniform(0, 2 * pi), rng.uniform(0.25, 1.1)
        way = np.array([np.cos(angle) * np.cos(rise), np.sin(angle) * np.cos(rise), np.sin(rise)])
        parts.append(leaf(base, way, length * rng.uniform(0.7, 1.1), width, _leaf_shade(colour, k)))
    return Shape("", parts)


def _leaf_shade(colour: Rgb, k: int) -> Rgb:
    """One of three shades, so that leaves stand out from each other and materials stay few."""
    factor = (0.75, 1.0, 1.3)[k % 3]
    return colour[0] * factor, colour[1] * factor, colour[2] * factor


def flowers(rng: Random) -> Shape:
    """Flowers in a vase."""
    vase_h, petal = (
        rng.uniform(0.16, 0.28),
        shade(rng, pick(rng, (*PAINTS[:6], (0.95, 0.94, 0.92), (0.95, 0.75, 0.15)))),
    )
    second = (
        shade(rng, pick(rng, (*PAINTS[:6], (0.95, 0.94, 0.92)))) if rng.random() < 0.4 else petal
    )
    parts = [_vase(rng, vase_h, rng.uniform(0.05, 0.08))]
    for k in range(int(rng.integers(5, 12))):
        angle, out = rng.uniform(0, 2 * pi), rng.uniform(0.02, 0.14)
        tip = np.array([out * np.cos(angle), out * np.sin(angle), vase_h + rng.uniform(0.12, 0.28)])
        parts.append(rod((0, 0, vase_h * 0.8), tip, 0.005, LEAVES[1], segments=4))
        colour = petal if k % 2 else second
        if rng.random() < 0.5:
            parts.append(cushion(tip, (0.06, 0.06, 0.055), colour, 0.8, 4))
        else:
            parts.append(
                tilted(
                    shifted(
                        turned(
                            [(0.01, 0), (0.05, 0.02), (0.035, 0.03), (0, 0.02)], colour, segments=8
                        ),
                        tip,
                    ),
                    (1, 0, 0),
                    rng.uniform(-0.5, 0.5),
                    tip,
                )
            )
        way = np.array([np.cos(angle + 1), np.sin(angle + 1), 0.9])
        parts.append(leaf(np.array([0, 0, vase_h]), way / 1.35, 0.2, 0.035, LEAVES[k % 2]))
    return Shape("", parts)


def _vase(rng: Random, height: float, radius: float) -> Part:
    shape = pick(
        rng,
        (
            ((0.6, 0.0), (1.0, 0.35), (0.9, 0.6), (0.4, 0.85), (0.55, 1.0)),
            ((0.7, 0.0), (0.75, 0.5), (0.8, 1.0)),
            ((0.5, 0.0), (0.9, 0.5), (1.0, 0.75), (0.55, 0.92), (0.6, 1.0)),
            ((0.5, 0.0), (0.9, 0.15), (1.0, 0.3), (0.35, 0.6), (0.3, 0.9), (0.5, 1.0)),
            ((0.45, 0.0), (0.5, 0.1), (0.8, 0.6), (1.0, 1.0)),
        ),
    )
    profile = [(0.0, 0.0), *[(r * radius, z * height) for r, z in shape]]
    inner = [(profile[-1][0] * 0.9, height), (profile[-1][0] * 0.7, height * 0.9)]
    return turned([*profile, *inner, (0.0, height * 0.88)], any_paint(rng), segments=20)


def vase(rng: Random) -> Shape:
    """A vase, seldom with dry twigs."""
    h = rng.uniform(0.25, 0.7)
    parts = [_vase(rng, h, rng.uniform(0.09, 0.15))]
    if rng.random() < 0.3:
        for _ in range(7):
            tip = np.array([*rng.uniform(-0.15, 0.15, 2), h + rng.uniform(0.2, 0.45)])
            parts.append(rod((0, 0, h * 0.8), tip, 0.004, (0.55, 0.42, 0.28), segments=4))
    return Shape("porcelain", parts)


def christmas_tree(rng: Random) -> Shape:
    """A decorated fir."""
    h, r = rng.uniform(1.2, 2.0), rng.uniform(0.4, 0.65)
    green = shade(rng, (0.08, 0.30, 0.13)) if rng.random() < 0.85 else (0.92, 0.94, 0.94)
    parts = [
        cylinder((0, 0, 0), 0.04, 0.25, (0.35, 0.23, 0.13)),
        turned([(0, 0), (0.16, 0), (0.13, 0.16)], shade(rng, PAINTS[0])),
    ]
    layers = int(rng.integers(4, 8))
    for k in range(layers):
        low, high = 0.2 + (h - 0.3) * k / layers, 0.2 + (h - 0.3) * (k + 1.6) / layers
        wide = r * (1 - k / layers * 0.9)
        parts.append(
            turned(
                [(wide * 0.3, low + 0.04), (wide, low), (wide * 0.25, min(high, h))],
                green,
                segments=12,
            )
        )
        for _ in range(7):
            angle = rng.uniform(0, 2 * pi)
            at = (wide * 0.93 * np.cos(angle), wide * 0.93 * np.sin(angle), low - 0.02)
            parts.append(
                cushion(
                    at,
                    (0.06, 0.06, 0.06),
                    pick(rng, (PAINTS[0], PAINTS[1], (0.85, 0.7, 0.2), (0.8, 0.8, 0.82))),
                    1.0,
                    3,
                )
            )
    star = [
        facing(prism(ellipse(0.16, 0.05, 4), 0, 0.02, (0.9, 0.75, 0.15)), (0, 0, 0))
        for _ in range(2)
    ]
    parts += [shifted(star[0], (0, 0, h)), shifted(tilted(star[1], (0, 1, 0), pi / 2), (0, 0, h))]
    return Shape("", parts)
