"""Procedural musical instruments."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    facing,
    prism,
    rod,
    shifted,
    tilted,
    turned,
    vec,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    STEEL,
    Random,
    Shape,
    any_paint,
    any_wood,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cylinder


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
