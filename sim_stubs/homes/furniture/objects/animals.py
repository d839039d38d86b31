"""Procedural animals of flesh, plush and wood."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    rod,
    shifted,
    tilted,
    tube,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    PAINTS,
    Random,
    Rgb,
    Shape,
    any_paint,
    any_wood,
    pick,
    shade,
)
from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import Surface, box, cushion, stretched

FURS: tuple[Rgb, ...] = (
    (0.55, 0.36, 0.20),
    (0.72, 0.55, 0.34),
    (0.36, 0.24, 0.16),
    (0.85, 0.80, 0.72),
    (0.25, 0.24, 0.24),
    (0.48, 0.47, 0.46),
)


def ball_at(centre: ArrayLike, size: ArrayLike, surface: Surface, steps: int = 6) -> Part:
    """An ellipsoid about its centre."""
    x, y, z = np.asarray(centre, np.float64)
    return cushion((x, y, z - float(np.asarray(size)[2]) / 2), size, surface, 1.0, steps)


def teddy_bear(rng: Random) -> Shape:
    """A sitting bear."""
    fur = shade(rng, pick(rng, FURS[:4]))
    light = shade(rng, (0.85, 0.72, 0.52))
    s = rng.uniform(0.85, 1.3)
    fat = rng.uniform(0.9, 1.15)
    balls: list[tuple[tuple[float, float, float], tuple[float, float, float], Surface]] = [
        ((0, 0, 0.11), (0.20 * fat, 0.17, 0.22), fur),
        ((0, -0.06, 0.11), (0.13 * fat, 0.08, 0.15), light),
        ((0, -0.01, 0.28), (0.17, 0.155, 0.15), fur),
        ((0, -0.085, 0.265), (0.075, 0.06, 0.055), light),
        ((0, -0.117, 0.275), (0.024, 0.016, 0.018), BLACK),
    ]
    for side in (-1, 1):
        balls += [
            ((side * 0.065, 0.0, 0.35), (0.06, 0.035, 0.06), fur),
            ((side * 0.065, -0.012, 0.35), (0.035, 0.025, 0.035), light),
            ((side * 0.035, -0.078, 0.30), (0.016, 0.012, 0.018), BLACK),
            ((side * 0.115, -0.05, 0.17), (0.065, 0.15, 0.07), fur),
            ((side * 0.09, -0.14, 0.045), (0.085, 0.18, 0.085), fur),
            ((side * 0.09, -0.225, 0.05), (0.06, 0.02, 0.065), light),
        ]
    parts = [ball_at(np.array(c) * s, np.array(d) * s, k) for c, d, k in balls]
    if rng.random() < 0.4:
        parts.append(
            cushion((0, -0.08 * s, 0.195 * s), (0.09 * s, 0.03, 0.03 * s), any_paint(rng), 0.6, 4)
        )
    return Shape("fabric", parts)


def cat(rng: Random) -> Shape:
    """A cat that sits or stands."""
    return _animal(rng, pointed=True, scale=rng.uniform(0.85, 1.1))


def dog(rng: Random) -> Shape:
    """A dog that sits or stands."""
    return _animal(rng, pointed=False, scale=rng.uniform(1.2, 1.8))


def _animal(rng: Random, *, pointed: bool, scale: float) -> Shape:
    """Head to the front; cats have pointed ears and a long tail, dogs a snout and hanging ears."""
    fur = shade(rng, pick(rng, FURS))
    second = shade(rng, pick(rng, FURS)) if rng.random() < 0.35 else fur
    slim = 0.85 if pointed else 1.0
    parts: list[Part] = []
    if rng.random() < 0.5:
        body = ball_at((0, 0.05, 0.15), (0.17 * slim, 0.2, 0.3), fur)
        parts += [
            tilted(body, (1, 0, 0), 0.25, (0, 0.05, 0)),
            ball_at((0, -0.03, 0.2), (0.12, 0.1, 0.18), second),
        ]
        parts += [
            rod((s * 0.045, -0.07, 0.2), (s * 0.045, -0.09, 0.0), 0.024, fur, 0.02) for s in (-1, 1)
        ]
        parts += [ball_at((s * 0.08, 0.06, 0.06), (0.08, 0.17, 0.12), fur) for s in (-1, 1)]
        parts += [
            ball_at((s * 0.045, -0.11, 0.015), (0.045, 0.07, 0.03), second, 4) for s in (-1, 1)
        ]
        head, tail = np.array([0, -0.07, 0.36]), np.array([0, 0.15, 0.04])
    else:
        parts += [
            ball_at((0, 0, 0.22), (0.14 * slim, 0.42, 0.16), fur),
            ball_at((0, -0.14, 0.25), (0.12 * slim, 0.14, 0.16), second),
        ]
        for y in (-0.14, 0.14):
            parts += [
                rod((s * 0.045, y, 0.2), (s * 0.045, y, 0.0), 0.025, fur, 0.018) for s in (-1, 1)
            ]
        head, tail = np.array([0, -0.25, 0.34]), np.array([0, 0.2, 0.25])
    parts += [
        ball_at(head, (0.125, 0.13, 0.115), fur),
        *[
            ball_at(
                head + vec(s * 0.035, -0.052, 0.02),
                (0.02, 0.014, 0.02),
                (0.3, 0.5, 0.2) if pointed else BLACK,
                4,
            )
            for s in (-1, 1)
        ],
    ]
    if pointed:
        parts += [
            ball_at(head + vec(0, -0.055, -0.02), (0.055, 0.04, 0.04), second, 4),
            ball_at(head + vec(0, -0.076, -0.012), (0.014, 0.01, 0.01), (0.75, 0.45, 0.45), 4),
        ]
        parts += [
            rod(
                head + vec(s * 0.035, 0.0, 0.03),
                head + vec(s * 0.05, 0.0, 0.1),
                0.028,
                fur,
                0.002,
                4,
            )
            for s in (-1, 1)
        ]
        curl = arc_points(tail + vec(0.08, 0, 0.0), (-0.08, 0.0, 0), (0, 0.05, 0.16), 0, 2.4, 8)
        parts.append(tube(curl, 0.018, fur, 6))
    else:
        parts += [
            ball_at(head + vec(0, -0.08, -0.025), (0.07, 0.12, 0.06), second),
            ball_at(head + vec(0, -0.138, -0.012), (0.028, 0.02, 0.022), BLACK, 4),
        ]
        parts += [
            ball_at(head + vec(s * 0.065, 0.01, -0.005), (0.03, 0.06, 0.11), second)
            for s in (-1, 1)
        ]
        parts.append(rod(tail, tail + vec(0.02, 0.12, 0.12), 0.016, fur, 0.008, 6))
        if rng.random() < 0.4:
            parts.append(
                turned([(0.055, 0), (0.055, 0.02)], any_paint(rng), head + vec(0, 0.03, -0.075), 12)
            )
    low = min(float(part.vertices[:, 2].min()) for part in parts)
    return Shape("", stretched([shifted(part, (0, 0, -low)) for part in parts], (scale,) * 3))


def rocking_horse(rng: Random) -> Shape:
    """A horse on runners."""
    body, seat = (
        (any_wood(rng), any_paint(rng)) if rng.random() < 0.6 else (any_paint(rng), any_wood(rng))
    )
    runner = any_wood(rng)
    parts: list[Part] = []
    for s in (-1, 1):
        curve = arc_points(
            (0, s * 0.11, 0.62), (0.46, 0, 0), (0, 0, -0.6), 0.25 * pi, 0.75 * pi, 10
        )
        parts.append(tube(curve, 0.016, runner, 6))
        for x in (-0.2, 0.2):
            parts.append(rod((x * 0.7, s * 0.06, 0.34), (x, s * 0.11, 0.07), 0.022, body))
    parts += [box((x, 0, 0.05), (0.05, 0.24, 0.02), runner) for x in (-0.25, 0.25)]
    neck = rod((0.16, 0, 0.36), (0.27, 0, 0.56), 0.06, body, 0.045)
    head = tilted(
        ball_at((0.31, 0, 0.57), (0.2, 0.075, 0.1), body), (0, 1, 0), 0.5, (0.31, 0, 0.57)
    )
    mane: Surface = pick(rng, ((0.25, 0.16, 0.1), (0.85, 0.8, 0.7), BLACK))
    parts += [
        ball_at((0, 0, 0.36), (0.46, 0.17, 0.18), body),
        neck,
        head,
        box((0, 0, 0.43), (0.18, 0.16, 0.04), seat),
        *[
            rod(
                (0.12 + 0.04 * k, 0, 0.45 + 0.05 * k),
                (0.17 + 0.035 * k, 0, 0.5 + 0.045 * k),
                0.025,
                mane,
                segments=5,
            )
            for k in range(3)
        ],
        rod((0.27, -0.13, 0.55), (0.27, 0.13, 0.55), 0.012, runner),
        rod((-0.22, 0, 0.4), (-0.34, 0, 0.24), 0.025, mane, 0.012),
        *[ball_at((0.33, s * 0.035, 0.6), (0.015, 0.012, 0.015), BLACK, 4) for s in (-1, 1)],
        *[
            rod((0.26, s * 0.025, 0.6), (0.25, s * 0.03, 0.66), 0.015, body, 0.003, 4)
            for s in (-1, 1)
        ],
    ]
    return Shape("wooden", parts)


def ball(rng: Random) -> Shape:
    """A ball with patches or seams."""
    r = rng.uniform(0.1, 0.14)
    ground = shade(rng, pick(rng, ((0.93, 0.93, 0.92), (0.85, 0.42, 0.12), *PAINTS[:3])))
    parts = [ball_at((0, 0, r), (2 * r,) * 3, ground, 10)]
    other = BLACK if rng.random() < 0.6 else any_paint(rng)
    for way in rng.normal(0, 1, (11, 3)):
        unit = way / np.linalg.norm(way)
        parts.append(
            ball_at(
                unit * r * 0.78 + vec(0, 0, r), (0.075, 0.075, 0.075) * np.array(r / 0.12), other, 4
            )
        )
    low = min(float(part.vertices[:, 2].min()) for part in parts)
    return Shape("", [shifted(part, (0, 0, -low)) for part in parts])
