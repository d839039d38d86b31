"""Procedural ornaments, animals and toys."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from sim_stubs.homes.furniture.objects.plants import LEAVES
from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    ellipse,
    facing,
    prism,
    rod,
    shifted,
    tilted,
    translucent,
    tube,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    GLASS,
    PAINTS,
    Random,
    Rgb,
    Shape,
    any_metal,
    any_paint,
    any_wood,
    pick,
    shade,
    wood_or_paint,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, flat_panel, stretched
from sim_stubs.homes.textures import patterns

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


def picture(rng: Random) -> Shape:
    """A framed painting, print or photograph, upright or across."""
    w, h = rng.uniform(0.35, 1.0), rng.uniform(0.35, 0.8)
    frame: Surface = pick(rng, (BLACK, any_wood(rng), any_metal(rng), (0.92, 0.92, 0.9)))
    rim = rng.uniform(0.012, 0.06)
    mount = rng.uniform(0.03, 0.08) if rng.random() < 0.4 else 0.0
    seed = rng.texture(rng.integers(10_000))
    face = patterns.painting(seed) if rng.random() < 0.75 else patterns.outdoors(seed)
    inset = rim + mount
    parts = [
        box((0, 0, 0), (w, 0.03, h), frame),
        box((0, -0.012, rim), (w - 2 * rim, 0.008, h - 2 * rim), (0.94, 0.93, 0.90)),
        flat_panel(
            (-w / 2 + inset, -0.017, inset),
            (w - 2 * inset, 0, 0),
            (0, 0, h - 2 * inset),
            face,
            tile=0,
        ),
    ]
    return Shape("", parts)


def mirror(rng: Random) -> Shape:
    """A framed mirror that shows plain light: square, round or oval; on the wall or standing."""
    w, h = rng.uniform(0.4, 0.8), rng.uniform(0.5, 1.0)
    frame: Surface = pick(
        rng, (any_metal(rng), any_wood(rng), (0.92, 0.92, 0.9), (0.70, 0.56, 0.28))
    )
    light = shade(rng, (0.74, 0.82, 0.87), 0.06)
    rim = rng.uniform(0.015, 0.06)
    kind = rng.random()
    if kind < 0.55:
        parts = [
            box((0, 0, 0), (w, 0.03, h), frame),
            flat_panel(
                (-w / 2 + rim, -0.0165, rim), (w - 2 * rim, 0, 0), (0, 0, h - 2 * rim), light
            ),
        ]
    else:
        h = w if kind < 0.8 else h
        parts = [
            facing(
                prism(ellipse(w + 2 * rim, h + 2 * rim, 32), 0, 0.03, frame),
                (0, 0.015, h / 2 + rim),
            ),
            facing(prism(ellipse(w, h, 32), 0, 0.033, light), (0, 0.015, h / 2 + rim)),
        ]
    return Shape("", parts)


def fireplace(rng: Random) -> Shape:
    """A mantelpiece around a dark opening with logs and fire; a chimney breast above it."""
    stone = shade(
        rng,
        pick(
            rng,
            (
                (0.88, 0.86, 0.82),
                (0.92, 0.92, 0.9),
                (0.55, 0.28, 0.22),
                (0.5, 0.48, 0.46),
                (0.7, 0.62, 0.5),
            ),
        ),
    )
    w, d, h = rng.uniform(1.0, 1.5), rng.uniform(0.32, 0.5), rng.uniform(0.95, 1.2)
    side, top = w * rng.uniform(0.16, 0.24), h * rng.uniform(0.24, 0.34)
    dark, mantel = (0.06, 0.055, 0.05), stone if rng.random() < 0.6 else any_wood(rng)
    parts = [
        *[box((s * (w - side) / 2, 0, 0), (side, d, h), stone) for s in (-1, 1)],
        box((0, 0, h - top), (w, d, top), stone),
        box((0, d / 2 - 0.03, 0), (w, 0.05, h), dark),
        box((0, 0.02, 0), (w - 2 * side, d - 0.06, 0.04), dark),
        *[
            box((s * (w / 2 - side - 0.005), 0.02, 0), (0.01, d - 0.06, h - top), dark)
            for s in (-1, 1)
        ],
        box((0, -0.04, h), (w + 0.16, d + 0.12, 0.05), mantel),
    ]
    if rng.random() < 0.5:
        parts.append(box((0, -d / 2 - 0.15, 0), (w, 0.3, 0.03), stone))
    for k in range(3):
        parts.append(
            rod(
                (-0.2, -0.05 + 0.08 * k, 0.08),
                (0.2, 0.02 + 0.05 * k, 0.09),
                0.035,
                (0.35, 0.22, 0.13),
            )
        )
    if rng.random() < 0.65:
        for k in range(7):
            x, tall = rng.uniform(-0.18, 0.18), rng.uniform(0.12, 0.32)
            parts.append(
                turned(
                    [(0, 0), (0.04, 0.04), (0.02, tall * 0.6), (0, tall)],
                    ((0.95, 0.55, 0.1), (0.95, 0.35, 0.08))[k % 2],
                    (x, 0.0, 0.1),
                    6,
                )
            )
    if rng.random() < 0.35:
        parts.append(
            box((0, d * 0.15, h + 0.05), (w * 0.75, d * 0.7, rng.uniform(0.8, 1.3)), stone)
        )
    return Shape("", parts)


def aquarium(rng: Random) -> Shape:
    """A glass tank with water, gravel, plants and fish, perhaps on a stand."""
    w, d, h = rng.uniform(0.55, 1.1), rng.uniform(0.28, 0.42), rng.uniform(0.35, 0.55)
    base = rng.uniform(0.6, 0.75) if rng.random() < 0.25 else 0.0
    frame = shade(rng, pick(rng, (BLACK, BLACK, (0.6, 0.62, 0.64))))
    parts: list[Part] = [
        box((0, 0, base), (w, d, 0.03), frame),
        box((0, 0, base + h - 0.05), (w, d, 0.05), frame),
        box((0, 0, base + 0.03), (w - 0.02, d - 0.02, 0.05), (0.68, 0.58, 0.42)),
    ]
    if base:
        parts.append(box((0, 0, 0), (w, d, base), wood_or_paint(rng)[1]))
    for _ in range(int(rng.integers(4, 9))):
        x, y = rng.uniform(-0.42, 0.42) * w, rng.uniform(-0.2, 0.25) * d
        for _ in range(3):
            tip = (
                x + rng.uniform(-0.05, 0.05),
                y,
                base + 0.08 + rng.uniform(0.3, 0.8) * (h - 0.15),
            )
            parts.append(rod((x, y, base + 0.06), tip, 0.012, pick(rng, LEAVES), 0.003, 4))
    for _ in range(int(rng.integers(3, 8))):
        at = (rng.uniform(-0.4, 0.4) * w, -0.25 * d, base + rng.uniform(0.3, 0.8) * h)
        paint = pick(rng, ((0.95, 0.5, 0.1), (0.9, 0.8, 0.2), (0.2, 0.4, 0.8), (0.85, 0.2, 0.2)))
        parts += [
            cushion(at, (0.06, 0.02, 0.03), paint, 1.0, 4),
            box((at[0] + 0.035, at[1], at[2]), (0.02, 0.006, 0.03), paint),
        ]
    parts.append(
        translucent(
            box((0, 0, base + 0.03), (w - 0.004, d - 0.004, h - 0.08), (0.50, 0.72, 0.82)), 0.4
        )
    )
    parts.append(translucent(box((0, 0, base + 0.03), (w, d, h - 0.04), GLASS), 0.15))
    return Shape("glass", parts)
