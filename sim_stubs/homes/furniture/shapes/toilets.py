"""Procedural toilets, bidets and urinals."""

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
)
from sim_stubs.homes.furniture.shapes.materials import CHROME, Random, Shape, any_white, any_wood
from sim_stubs.homes.furniture.shapes.sinks import BASIN, tap
from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import Surface, box, cushion, cylinder, stretched


def toilet(rng: Random) -> Shape:
    """A bowl on the floor or at the wall, its cistern behind it or in the wall, lid up or down."""
    white = any_white(rng)
    seat: Surface = white if rng.random() < 0.75 else any_wood(rng)
    w, d = rng.uniform(0.34, 0.41), rng.uniform(0.48, 0.58)
    rim, power = rng.uniform(0.38, 0.43), rng.uniform(0.45, 1.0)
    parts: list[Part] = []
    hung = rng.random() < 0.25
    if hung:
        body = [(0.16, 0.1), (0.34, 0.16), (0.46, 0.28), (0.5, rim)]
    else:
        foot = rng.uniform(0.26, 0.4)
        body = [(foot, 0.0), (foot * 0.95, 0.1), (foot * 0.95, 0.18), (0.44, 0.3), (0.5, rim)]
    bowl_ = turned(body, white, segments=24)
    parts += [shifted(part, (0, -0.1, 0)) for part in stretched([bowl_], (w, d, 1.0))]
    if not hung and rng.random() < 0.6:
        parts.append(box((0, 0.12, 0), (w * 0.6, 0.36, rim - 0.02), white))
    parts.append(box((0, 0.14, rim - 0.14), (w * 0.9, 0.26, 0.14), white))
    ring = ellipse(w, d, 28, power)
    parts += [
        shifted(prism(ring, rim - 0.01, 0.03, seat), (0, -0.1, 0)),
        shifted(prism(ring * 0.66, rim + 0.015, 0.007, BASIN), (0, -0.12, 0)),
    ]
    lid = prism(ring * (0.98, 0.95), 0, 0.025, seat)
    up = rng.random() < 0.45
    back = d / 2 - 0.1
    if up:
        raised = facing(lid, (0, back - 0.02, rim + 0.03 + d * 0.475))
        parts.append(tilted(raised, (-1, 0, 0), 0.12, (0, back, rim)))
    else:
        parts.append(shifted(lid, (0, -0.1, rim + 0.022)))
    kind = rng.random()
    if hung or kind < 0.12:
        parts.append(
            box(
                (0, back + 0.09, 0),
                (w + rng.uniform(0.1, 0.3), 0.14, rng.uniform(0.85, 1.1)),
                white,
            )
        )
        plate = box((0, back + 0.015, 0.8 if not up else 0.84), (0.2, 0.012, 0.1), CHROME)
        parts.append(plate)
    else:
        tall, wide = rng.uniform(0.34, 0.42), rng.uniform(0.34, 0.46)
        soft = rng.uniform(0.05, 0.3)
        at = (0, back + 0.09, rim - 0.04)
        parts.append(
            cushion(at, (wide, 0.18, tall), white, soft)
            if soft > 0.15
            else box(at, (wide, 0.18, tall), white)
        )
        top = rim - 0.04 + tall
        parts += [
            box((0, back + 0.09, top), (wide + 0.02, 0.2, 0.03), white),
            cylinder((0, back + 0.09, top + 0.03), 0.025, 0.012, CHROME),
        ]
    return Shape("porcelain", parts)


def bidet(rng: Random) -> Shape:
    """A low basin with a tap."""
    white = any_white(rng)
    w, d, rim = rng.uniform(0.34, 0.4), rng.uniform(0.5, 0.58), rng.uniform(0.36, 0.42)
    foot = rng.uniform(0.28, 0.42)
    body = turned(
        [
            (foot, 0),
            (foot * 0.95, 0.12),
            (0.42, rim * 0.7),
            (0.5, rim - 0.03),
            (0.5, rim),
            (0.4, rim),
            (0.3, rim - 0.06),
            (0.0, rim - 0.1),
        ],
        white,
        segments=26,
    )
    hollow = turned([(0.41, rim + 0.001), (0.0, rim - 0.09)], BASIN, segments=26)
    parts = stretched([body, hollow], (w, d, 1.0))
    y = d / 2 - 0.05
    parts += [
        box((0, y - 0.02, rim - 0.06), (w * 0.8, 0.12, 0.07), white),
        *tap(rng, (0, y, rim), 0.13),
    ]
    return Shape("porcelain", parts)


def urinal(rng: Random) -> Shape:
    """A shell at the wall."""
    white = any_white(rng)
    w, h = rng.uniform(0.32, 0.4), rng.uniform(0.6, 0.9)
    rows = []
    for t in np.linspace(0, 1, 12):
        z = h * t
        out = 0.30 * (1 - t) ** 0.7 * (0.35 + 0.65 * min(1.0, t / 0.12)) + 0.08
        angles = np.linspace(pi, 2 * pi, 13)
        half = w / 2 * (0.55 + 0.45 * min(1.0, t / 0.25)) * (1.0 if t < 0.8 else 1.0 - (t - 0.8))
        rows.append(np.column_stack([half * np.cos(angles), out * np.sin(angles), np.full(13, z)]))
    hollow = prism(ellipse(w * 0.66, h * 0.58, 24), 0, 0.05, BASIN)
    parts = [
        sheet(np.array(rows), white, both=True),
        box((0, 0.02, 0), (w * 0.9, 0.04, h), white),
        tilted(facing(hollow, (0, -0.24, h * 0.55)), (-1, 0, 0), 0.3, (0, -0.24, h * 0.55)),
        rod((0, -0.02, h), (0, -0.02, h + 0.2), 0.014, CHROME),
        cylinder((0, -0.02, h + 0.2), 0.03, 0.05, CHROME),
    ]
    return Shape("porcelain", parts)
