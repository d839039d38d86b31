"""Toys, animals, instruments and vehicles of our own."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from sim_stubs.joinery import (
    BLACK,
    PAINTS,
    STEEL,
    Random,
    Rgb,
    Shape,
    any_cloth,
    any_metal,
    any_paint,
    any_wood,
    pick,
    shade,
)
from sim_stubs.piece import Part
from sim_stubs.solids import Surface, box, cushion, cylinder
from sim_stubs.turnery import (
    arc,
    ellipse,
    facing,
    prism,
    rod,
    scaled,
    sheet,
    shifted,
    tilted,
    tube,
    turned,
    vec,
)

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
        curl = arc(tail + vec(0.08, 0, 0.0), (-0.08, 0.0, 0), (0, 0.05, 0.16), 0, 2.4, 8)
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
    return Shape("", scaled([shifted(part, (0, 0, -low)) for part in parts], (scale,) * 3))


def rocking_horse(rng: Random) -> Shape:
    """A horse on runners."""
    body, seat = (
        (any_wood(rng), any_paint(rng)) if rng.random() < 0.6 else (any_paint(rng), any_wood(rng))
    )
    runner = any_wood(rng)
    parts: list[Part] = []
    for s in (-1, 1):
        curve = arc((0, s * 0.11, 0.62), (0.46, 0, 0), (0, 0, -0.6), 0.25 * pi, 0.75 * pi, 10)
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


def guitar(rng: Random) -> Shape:
    """An acoustic or electric guitar, upright and leaning back a little on its stand."""
    electric = rng.random() < 0.5
    body: Surface = any_paint(rng) if electric else any_wood(rng)
    deep = 0.045 if electric else 0.1
    angles = np.linspace(0, 2 * pi, 36, endpoint=False)
    z = -np.cos(angles) * 0.23
    half = (
        np.sin(angles)
        * np.where(z < 0, 0.19, 0.145)
        * (1 - 0.25 * np.exp(-(((z - 0.03) / 0.06) ** 2)))
    )
    if electric:
        half = half * (1 + 0.25 * np.clip(z / 0.23, 0, 1) * np.sin(angles))
    plan = np.column_stack([half, z])
    if float(np.cross(np.append(plan[1] - plan[0], 0), np.append(plan[2] - plan[1], 0))[2]) < 0:
        plan = plan[::-1]
    neck: Surface = (0.32, 0.2, 0.12)
    parts = [
        facing(prism(plan, 0, deep, body), (0, deep / 2, 0.25)),
        box((0, -deep / 2 - 0.008, 0.36), (0.05, 0.024, 0.56), neck),
        box(
            (0, -deep / 2 - 0.006, 0.92), (0.075, 0.02, 0.14), body if rng.random() < 0.5 else neck
        ),
        box((0, -deep / 2 - 0.012, 0.13), (0.11, 0.016, 0.025), BLACK),
    ]
    if electric:
        plate = facing(
            prism(
                plan * (0.55, 0.6),
                0,
                0.004,
                shade(rng, (0.93, 0.93, 0.9)) if rng.random() < 0.5 else BLACK,
            ),
            (0.01, -deep / 2, 0.25),
        )
        parts += [
            plate,
            *[
                box((0, -deep / 2 - 0.012, h), (0.08, 0.016, 0.022), (0.8, 0.8, 0.8))
                for h in (0.2, 0.28)
            ],
        ]
    else:
        parts.append(facing(cylinder((0, 0, 0), 0.05, 0.004, BLACK), (0, -deep / 2, 0.31)))
    parts += [
        box((s * 0.009, -deep / 2 - 0.022, 0.13), (0.002, 0.002, 0.86), STEEL) for s in (-1, 0, 1)
    ]
    parts += [
        rod((s * 0.035, -deep / 2, h), (s * 0.06, -deep / 2, h), 0.007, STEEL, segments=5)
        for s in (-1, 1)
        for h in (0.95, 0.99, 1.03)
    ]
    if rng.random() < 0.6:
        parts += [rod((0, 0.04, 0.12), (s * 0.14, -0.12, 0.0), 0.008, BLACK) for s in (-1, 1)]
        parts += [
            rod((0, 0.05, 0.3), (0, 0.24, 0.0), 0.008, BLACK),
            box((0, -0.02, 0.0), (0.2, 0.08, 0.03), BLACK),
        ]
    leaned = [tilted(part, (-1, 0, 0), 0.12) for part in parts]
    low = min(float(part.vertices[:, 2].min()) for part in leaned)
    return Shape("wooden", [shifted(part, (0, 0, -low)) for part in leaned])


def piano(rng: Random) -> Shape:
    """An upright or a grand piano, with a stool now and then."""
    finish: Surface = (
        shade(rng, BLACK)
        if rng.random() < 0.55
        else any_wood(rng)
        if rng.random() < 0.7
        else (0.92, 0.92, 0.9)
    )
    parts: list[Part] = []
    w = rng.uniform(1.38, 1.5)
    if rng.random() < 0.6:
        d, h = rng.uniform(0.5, 0.62), rng.uniform(1.05, 1.35)
        front = -d / 2
        parts = [
            box((0, d * 0.2, 0.05), (w, d * 0.6, h - 0.05), finish),
            box((0, 0, h), (w + 0.04, d * 0.7, 0.03), finish),
            box((0, -d * 0.05, 0.58), (w, d * 0.85, 0.1), finish),
            *[
                box((s * (w / 2 - 0.05), front + 0.06, 0), (0.07, 0.09, 0.6), finish)
                for s in (-1, 1)
            ],
            *[
                box((s * (w / 2 - 0.03), -d * 0.1, 0.6), (0.06, d * 0.7, 0.16), finish)
                for s in (-1, 1)
            ],
            box((0, -d * 0.1 - 0.005, 0.92), (w * 0.45, 0.02, 0.16), finish),
        ]
        keys_y = front + 0.1
    else:
        length = rng.uniform(1.4, 1.7)
        plan = np.array(
            [
                (-w / 2, -length / 2),
                (w / 2, -length / 2),
                (w / 2, -length * 0.1),
                (w * 0.36, length * 0.12),
                (w * 0.1, length * 0.36),
                (-w * 0.15, length / 2),
                (-w * 0.42, length / 2),
                (-w / 2, length * 0.4),
            ]
        )
        inner = plan * (0.92, 0.75) + vec(0, 0.1)
        parts = [
            prism(plan, 0.62, 0.3, finish),
            prism(inner, 0.921, 0.004, (0.65, 0.48, 0.2)),
            box((0, -length / 2 + 0.12, 0.6), (w, 0.26, 0.14), finish),
        ]
        lid = prism(plan * (1.0, 0.8) + vec(0, length * 0.1), 0.93, 0.02, finish)
        parts.append(tilted(lid, (0, -1, 0), -rng.uniform(0.0, 0.75), (-w / 2, 0, 0.93)))
        parts += [
            turned([(0.05, 0), (0.05, 0.05), (0.04, 0.08), (0.06, 0.62)], finish, at, 10)
            for at in (
                (-w * 0.4, -length * 0.36, 0),
                (w * 0.4, -length * 0.36, 0),
                (-w * 0.2, length * 0.36, 0),
            )
        ]
        parts.append(rod((w * 0.3, 0, 0.93), (w * 0.1, 0, 1.3), 0.01, finish))
        keys_y = -length / 2 + 0.08
        parts.append(box((0, -length / 2 + 0.28, 0.93), (w * 0.4, 0.02, 0.2), finish))
    top = 0.74 if len(parts) > 8 and keys_y < -0.5 else 0.69
    parts.append(box((0, keys_y, top - 0.02), (w - 0.14, 0.15, 0.02), (0.95, 0.94, 0.9)))
    for i, x in enumerate(np.linspace(-w / 2 + 0.1, w / 2 - 0.1, 44)):
        if i % 7 not in (2, 6):
            parts.append(box((x, keys_y + 0.03, top), (0.014, 0.09, 0.012), BLACK))
    if rng.random() < 0.5:
        y = keys_y - 0.35
        parts += [
            box((0, y, 0.42), (0.6, 0.32, 0.08), BLACK),
            *[
                box((sx * 0.25, y + sy * 0.12, 0), (0.05, 0.05, 0.42), finish)
                for sx in (-1, 1)
                for sy in (-1, 1)
            ],
        ]
    return Shape("", parts)


def wheel(
    centre: ArrayLike,
    radius: float,
    spokes: int,
    tyre: Surface,
    metal: Surface,
    thick: float = 0.018,
) -> list[Part]:
    """A wheel that rolls along y."""
    c = np.asarray(centre, np.float64)
    parts = [
        tube(arc(c, (0, radius - thick, 0), (0, 0, radius - thick), 0, 2 * pi, 20), thick, tyre, 5),
        rod(c - vec(0.04, 0, 0), c + vec(0.04, 0, 0), 0.015, metal, segments=6),
    ]
    for k in range(spokes):
        angle = 2 * pi * k / spokes
        rim = c + (radius - thick) * np.array([0, np.cos(angle), np.sin(angle)])
        parts.append(rod(c, rim, 0.0025, metal, segments=3))
    return parts


def bicycle(rng: Random) -> Shape:
    """A bicycle, its front wheel at the front."""
    paint, metal = any_paint(rng), shade(rng, STEEL)
    r = rng.uniform(0.28, 0.34)
    half = r * 1.55
    parts = [*wheel((0, -half, r), r, 14, BLACK, metal), *wheel((0, half, r), r, 14, BLACK, metal)]
    crank, seat, head = (
        np.array([0, 0.05, r * 0.95]),
        np.array([0, half * 0.38, r * 2.3]),
        np.array([0, -half * 0.66, r * 2.35]),
    )
    step_through = rng.random() < 0.3
    middle = (crank + seat) / 2 if step_through else seat - vec(0, 0, 0.06)
    front, back = np.array([0, -half, r]), np.array([0, half, r])
    low = head - vec(0, 0.03, 0.12)
    parts += [
        rod(a, b, t, paint)
        for a, b, t in (
            (crank, seat, 0.017),
            (crank, low, 0.02),
            (middle, head if not step_through else low, 0.017),
            (low, head + vec(0, 0.02, 0.1), 0.018),
        )
    ]
    for s in (-0.035, 0.035):
        parts += [
            rod(low, front + vec(s, 0, 0), 0.012, paint),
            rod(crank, back + vec(s, 0, 0), 0.01, paint),
            rod(seat - vec(0, 0, 0.08), back + vec(s, 0, 0), 0.01, paint),
        ]
    top = head + vec(0, 0.02, 0.12)
    parts += [
        rod(top - vec(0.26, -0.08, 0), top, 0.012, metal),
        rod(top + vec(0.26, 0.08, 0), top, 0.012, metal),
        *[
            rod(top + vec(s * 0.2, 0.065, 0), top + vec(s * 0.29, 0.09, 0), 0.018, BLACK)
            for s in (-1, 1)
        ],
        rod(seat, seat + vec(0, 0.01, 0.08), 0.013, metal),
        cushion(seat + vec(0, 0.01, 0.07), (0.14, 0.26, 0.06), BLACK, 0.8, 6),
        rod(crank - vec(0.03, 0, 0), crank + vec(0.03, 0, 0), 0.09, metal, segments=16),
        *[
            rod(crank + vec(s * 0.05, 0, 0), crank + vec(s * 0.07, s * 0.1, -s * 0.13), 0.01, metal)
            for s in (-1, 1)
        ],
        *[
            box(crank + vec(s * 0.11, s * 0.1, -s * 0.13), (0.09, 0.07, 0.02), BLACK)
            for s in (-1, 1)
        ],
    ]
    return Shape("metal", parts)


def pushchair(rng: Random) -> Shape:
    """A seat with a hood on wheels."""
    cloth, metal = any_cloth(rng), any_metal(rng)
    parts: list[Part] = []
    for s in (-1, 1):
        x = s * 0.2
        parts += [
            rod((x, -0.35, 0.1), (x, 0.3, 1.0), 0.013, metal),
            rod((x, 0.34, 0.1), (x, -0.18, 0.62), 0.013, metal),
        ]
        for y in (-0.36, 0.36):
            parts += wheel((x, y, 0.1), 0.1, 5, BLACK, metal, 0.02)
    hood = [
        np.array(
            [
                arc((x, 0.12, 0.66), (0, -0.3, 0), (0, 0, 0.3), a, a + 0.0, 1)[0]
                for x in np.linspace(-0.2, 0.2, 5)
            ]
        )
        for a in np.linspace(0.25, 2.4, 9)
    ]
    parts += [
        sheet(np.array(hood), cloth, both=True),
        cushion((0, -0.05, 0.42), (0.38, 0.34, 0.08), cloth, 0.3),
        tilted(
            cushion((0, 0.12, 0.45), (0.38, 0.08, 0.48), cloth, 0.3),
            (-1, 0, 0),
            0.35,
            (0, 0.12, 0.45),
        ),
        tilted(
            cushion((0, -0.24, 0.2), (0.34, 0.05, 0.26), cloth, 0.3),
            (-1, 0, 0),
            -0.3,
            (0, -0.24, 0.44),
        ),
        rod((-0.2, 0.3, 1.0), (0.2, 0.3, 1.0), 0.018, BLACK),
        rod((-0.2, -0.24, 0.62), (0.2, -0.24, 0.62), 0.014, BLACK),
    ]
    return Shape("fabric", parts)


def high_chair(rng: Random) -> Shape:
    """A child's seat on long splayed legs, with a tray."""
    wooden = rng.random() < 0.5
    frame = any_wood(rng) if wooden else any_metal(rng)
    cloth = any_cloth(rng)
    h = rng.uniform(0.5, 0.6)
    tray: Surface = frame if wooden and rng.random() < 0.5 else (0.93, 0.93, 0.91)
    parts = [
        rod((sx * 0.15, sy * 0.14, h), (sx * 0.25, sy * 0.26, 0), 0.018, frame)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    parts += [
        cushion((0, 0, h - 0.02), (0.36, 0.34, 0.07), cloth, 0.3),
        tilted(
            cushion((0, 0.16, h), (0.36, 0.07, 0.45), cloth, 0.3), (-1, 0, 0), 0.12, (0, 0.16, h)
        ),
        *[box((s * 0.18, -0.02, h + 0.04), (0.04, 0.32, 0.14), frame) for s in (-1, 1)],
        prism(ellipse(0.5, 0.32, 24, 0.5) + np.array([0, -0.22]), h + 0.18, 0.025, tray),
        rod((-0.2, -0.2, 0.22), (0.2, -0.2, 0.22), 0.014, frame),
        box((0, -0.22, 0.2), (0.36, 0.12, 0.02), frame),
    ]
    return Shape("wooden" if wooden else "plastic", parts)


def wheelchair(rng: Random) -> Shape:
    """A chair between two large wheels."""
    cloth, metal = shade(rng, pick(rng, (BLACK, BLACK, PAINTS[1], PAINTS[0]))), any_metal(rng)
    parts: list[Part] = []
    for s in (-1, 1):
        x = s * 0.26
        parts += wheel((x + s * 0.03, 0.08, 0.3), 0.3, 12, BLACK, metal)
        parts += wheel((x * 0.85, -0.32, 0.08), 0.08, 4, BLACK, metal, 0.016)
        parts += [
            rod((x, 0.22, 0.2), (x, 0.28, 0.95), 0.013, metal),
            rod((x, 0.28, 0.93), (x, 0.42, 0.95), 0.018, BLACK),
            rod((x, 0.2, 0.48), (x, -0.24, 0.48), 0.013, metal),
            rod((x, -0.24, 0.48), (x * 0.8, -0.42, 0.1), 0.013, metal),
            rod((x, 0.2, 0.25), (x * 0.9, -0.3, 0.2), 0.012, metal),
            box((x, -0.02, 0.68), (0.06, 0.3, 0.03), BLACK),
            rod((x, -0.14, 0.48), (x, -0.14, 0.68), 0.012, metal),
            box((x * 0.6, -0.45, 0.08), (0.15, 0.14, 0.015), BLACK),
        ]
    parts += [
        cushion((0, -0.02, 0.45), (0.46, 0.44, 0.06), cloth, 0.2),
        tilted(
            cushion((0, 0.22, 0.5), (0.46, 0.04, 0.42), cloth, 0.2),
            (-1, 0, 0),
            0.08,
            (0, 0.22, 0.5),
        ),
    ]
    return Shape("metal", parts)
