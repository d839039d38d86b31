"""Procedural sofas and armchairs."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.chairs import bowl
from sim_stubs.homes.furniture.shapes.curved_solids import rod, shifted, tilted, turned
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    Random,
    Shape,
    any_cloth,
    any_metal,
    any_wood,
    legs,
    upholstery,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder


def sofa(rng: Random) -> Shape:
    """A sofa for two or three, straight, with a chaise, or around a corner."""
    material, cover = upholstery(rng)
    seats = int(rng.integers(2, 4))
    corner = rng.random()
    parts = _straight(rng, cover, seats * rng.uniform(0.56, 0.72), seats)
    if corner < 0.3:
        width = _extent(parts)
        side, length = float(rng.choice([-1.0, 1.0])), rng.uniform(0.6, 1.1)
        parts += _wing(rng, cover, side * (width / 2 - 0.42), length, corner < 0.15, side)
    return Shape(material, parts)


def armchair(rng: Random) -> Shape:
    """An easy chair: a sofa for one, a winged chair, a tub, a wooden frame, or a swivel shell."""
    style = rng.random()
    material, cover = upholstery(rng)
    if style < 0.4:
        return Shape(material, _straight(rng, cover, rng.uniform(0.5, 0.6), 1))
    if style < 0.55:
        return Shape(material, _winged(rng, cover))
    if style < 0.7:
        return Shape(material, _tub(rng, cover))
    if style < 0.85:
        return _framed(rng, cover)
    metal = any_metal(rng)
    foot = turned([(0, 0), (0.26, 0), (0.25, 0.02), (0.04, 0.05), (0.03, 0.4), (0.1, 0.42)], metal)
    shell = shifted(bowl(rng, 0.66, rng.uniform(0.45, 0.6), cover, 0.35), (0, 0, 0.38))
    pad = cushion((0, -0.02, 0.39), (0.5, 0.5, 0.1), cover, 0.6)
    return Shape(material, [foot, shell, pad])


def beanbag(rng: Random) -> Shape:
    """A soft bag to sit in."""
    cover = any_cloth(rng)
    w, h = rng.uniform(0.75, 1.0), rng.uniform(0.55, 0.8)
    profile = [
        (0, 0),
        (0.40, 0.0),
        (0.48, 0.10),
        (0.5, 0.25),
        (0.47, 0.42),
        (0.40, 0.60),
        (0.30, 0.78),
        (0.17, 0.92),
        (0, 1.0),
    ]
    bag = turned([(r * w, z * h) for r, z in profile], cover, segments=24)
    # It leans back, so that there is a hollow to sit in.
    sagging = replace(bag, vertices=bag.vertices.copy())
    height = sagging.vertices[:, 2] / h
    sagging.vertices[:, 1] += 0.22 * w * height**2
    return Shape("fabric", [sagging])


def _straight(rng: Random, cover: Surface, inner: float, seats: int) -> list[Part]:
    """Arms, back and cushions along x; `inner` is the width between the arms [m]."""
    soft = rng.uniform(0.12, 0.5)
    arm_w = rng.uniform(0.10, 0.26)
    arm_h, back_h = rng.uniform(0.48, 0.68), rng.uniform(0.72, 0.98)
    d, leg = rng.uniform(0.78, 0.95), rng.choice([0.03, 0.08, 0.15])
    seat = rng.uniform(0.4, 0.46)
    width = inner + 2 * arm_w
    stand: Surface = any_wood(rng) if rng.random() < 0.6 else any_metal(rng)
    armless = seats > 1 and rng.random() < 0.12
    parts = [
        *legs(width - 0.1, d - 0.1, leg + 0.02, 0.05, stand, round_=bool(rng.random() < 0.5)),
        box((0, 0, leg), (width - 0.02, d - 0.04, seat - 0.16 - leg), cover),
        cushion(
            (0, d / 2 - 0.1, leg + 0.02), (width - 0.04, 0.2, back_h - leg - 0.02), cover, soft
        ),
    ]
    if not armless:
        rolled = rng.random() < 0.3
        for side in (-1, 1):
            x = side * (width - arm_w) / 2
            parts.append(cushion((x, -0.01, leg), (arm_w, d, arm_h - leg), cover, soft))
            if rolled:
                parts.append(
                    rod(
                        (x, -d / 2 - 0.01, arm_h - 0.04),
                        (x, d / 2 - 0.1, arm_h - 0.04),
                        arm_w * 0.6,
                        cover,
                        segments=14,
                    )
                )
    span = width if armless else inner
    pads = seats if rng.random() < 0.8 else 1
    for i in range(pads):
        x, w = ((i + 0.5) / pads - 0.5) * span, span / pads
        parts.append(cushion((x, -0.09, seat - 0.17), (w - 0.005, d - 0.18, 0.19), cover, 0.22))
    if rng.random() < 0.7:
        for i in range(pads):
            x, w = ((i + 0.5) / pads - 0.5) * span, span / pads
            pad = cushion(
                (x, d / 2 - 0.26, seat), (w - 0.01, 0.18, back_h - seat + 0.02), cover, 0.3
            )
            parts.append(tilted(pad, (-1, 0, 0), 0.14, (0, d / 2 - 0.2, seat)))
    for _ in range(int(rng.integers(0, 4)) if seats > 1 else int(rng.random() < 0.3)):
        pillow = cushion((0, 0, 0), (0.4, 0.14, 0.38), any_cloth(rng), 0.55, 6)
        x = rng.uniform(-span / 2 + 0.2, span / 2 - 0.2) if seats > 1 else 0.0
        leaning = tilted(pillow, (-1, 0, 0), 0.3)
        parts.append(shifted(leaning, (x, 0.02, seat), rng.uniform(-0.4, 0.4)))
    return parts


def _wing(
    rng: Random, cover: Surface, x: float, length: float, backed: bool, side: float
) -> list[Part]:
    """The part of a sofa that goes around a corner, towards the front at x [m]."""
    middle = -0.4 - length / 2
    parts = [
        box((x, middle, 0.05), (0.82, length, 0.24), cover),
        cushion((x, middle, 0.26), (0.84, length + 0.06, 0.19), cover, 0.2),
    ]
    if backed:
        at = (x + side * 0.36, middle, 0.05)
        parts.append(cushion(at, (0.2, length + 0.04, rng.uniform(0.68, 0.8)), cover, 0.25))
    return parts


def _winged(rng: Random, cover: Surface) -> list[Part]:
    w, top, stand = rng.uniform(0.55, 0.65), rng.uniform(0.98, 1.12), any_wood(rng)
    sides = []
    for side in (-1, 1):
        x = side * w / 2
        sides += [
            cushion((x, -0.02, 0.14), (0.13, 0.7, 0.46), cover, 0.35),
            cushion((x * 0.95, 0.22, 0.5), (0.09, 0.26, top - 0.55), cover, 0.5),
        ]
    return [
        *legs(w, 0.6, 0.2, 0.045, stand, splay=0.02),
        box((0, 0, 0.16), (w, 0.62, 0.14), cover),
        cushion((0, -0.04, 0.28), (w - 0.08, 0.6, 0.16), cover, 0.3),
        tilted(
            cushion((0, 0.3, 0.2), (w, 0.16, top - 0.2), cover, 0.3),
            (-1, 0, 0),
            0.08,
            (0, 0.3, 0.3),
        ),
        *sides,
    ]


def _tub(rng: Random, cover: Surface) -> list[Part]:
    """A round back that is its own arms."""
    r, low, high = rng.uniform(0.32, 0.38), rng.uniform(0.55, 0.62), rng.uniform(0.68, 0.8)
    count = 11
    wall = []
    for angle in np.linspace(-0.15 * pi, 1.15 * pi, count):
        h = low + (high - low) * max(0.0, np.sin(angle)) - 0.12
        block = cushion((0, 0, 0), (2.6 * r * pi / count, 0.13, h), cover, 0.35, 6)
        spot = (r * np.cos(angle), r * np.sin(angle), 0.12)
        wall.append(shifted(block, spot, angle - pi / 2))
    stand = any_wood(rng)
    return [
        *legs(1.1 * r, 1.1 * r, 0.14, 0.04, stand, splay=0.03, round_=True),
        cylinder((0, 0, 0.12), r, 0.18, cover, segments=24),
        cushion((0, -0.04, 0.28), (1.8 * r, 1.9 * r, 0.15), cover, 0.5),
        *wall,
    ]


def _framed(rng: Random, cover: Surface) -> Shape:
    """Cushions in an open frame of wood or steel."""
    wooden = rng.random() < 0.65
    frame = any_wood(rng) if wooden else any_metal(rng)
    thick, w = (0.05 if wooden else 0.028), rng.uniform(0.6, 0.7)
    parts: list[Part] = []
    for side in (-1, 1):
        x = side * w / 2
        parts += [box((x, y, 0), (thick, thick, 0.56), frame) for y in (-0.32, 0.3)]
        parts.append(box((x, 0, 0.55), (thick * 1.4, 0.74, thick * 0.8), frame))
        parts.append(box((x, 0, 0.26), (thick, 0.64, thick), frame))
    seat = cushion((0, 0, 0.3), (w - 0.04, 0.62, 0.14), cover, 0.25)
    back = cushion((0, 0.26, 0.36), (w - 0.06, 0.14, rng.uniform(0.45, 0.65)), cover, 0.25)
    parts += [
        tilted(seat, (1, 0, 0), -0.08, (0, 0, 0.3)),
        tilted(back, (-1, 0, 0), 0.28, (0, 0.26, 0.36)),
        box((0, 0.3, 0.4), (w, 0.02, 0.06), frame),
        box((0, 0, 0.25), (w, 0.5, 0.03), BLACK),
    ]
    return Shape("wooden" if wooden else "metal", parts)


def _extent(parts: list[Part]) -> float:
    """Width of parts along x [m]."""
    return float(np.ptp(np.concatenate([part.vertices[:, 0] for part in parts])))
