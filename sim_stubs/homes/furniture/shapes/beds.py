"""Procedural beds, bunk beds and cribs; the head is at the back."""

from __future__ import annotations

from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    prism,
    rod,
    shifted,
    tilted,
    tube,
)
from sim_stubs.homes.furniture.shapes.materials import (
    CLOTHS,
    Random,
    Shape,
    any_cloth,
    any_metal,
    any_wood,
    legs,
    pick,
    shade,
    upholstery,
    wood_or_paint,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder
from sim_stubs.homes.textures import patterns

LINEN = (0.90, 0.90, 0.90)


def bed(rng: Random) -> Shape:
    """A double bed."""
    return _bed(rng, rng.uniform(1.3, 1.85))


def single_bed(rng: Random) -> Shape:
    """A bed for one."""
    return _bed(rng, rng.uniform(0.82, 1.05))


def _bed(rng: Random, width: float) -> Shape:
    length = rng.uniform(1.95, 2.1)
    style = rng.random()
    base = rng.uniform(0.22, 0.36)
    head = rng.uniform(0.75, 1.2)
    foot = float(rng.choice([0.0, 0.0, rng.uniform(0.45, 0.75)]))
    if style < 0.6:
        material, frame = wood_or_paint(rng)
        parts = _panelled(rng, width, length, base, head, foot, frame)
    elif style < 0.8:
        material, frame = upholstery(rng)
        parts = [
            box((0, 0, 0.04), (width + 0.06, length, base - 0.04), frame),
            cushion((0, length / 2, 0), (width + 0.1, 0.14, head), frame, 0.15),
        ]
        if rng.random() < 0.5:
            parts += [
                cushion(
                    ((i - 1) * width / 3, length / 2 - 0.06, base),
                    (width / 3 - 0.01, 0.08, head - base - 0.04),
                    frame,
                    0.3,
                    6,
                )
                for i in range(3)
            ]
    else:
        material, frame = "metal", any_metal(rng)
        parts = _barred(rng, width, length, base, head, max(foot, 0.5), frame)
    return Shape(material, parts + bedding(rng, width, length, base))


def bedding(rng: Random, width: float, length: float, base: float) -> list[Part]:
    """Mattress, pillows and cover on a base of that height [m]."""
    mattress = rng.uniform(0.16, 0.24)
    top = base + mattress - 0.03
    parts = [cushion((0, 0, base - 0.03), (width - 0.04, length - 0.04, mattress), LINEN, 0.12)]
    cover = any_cloth(rng)
    if rng.random() < 0.35:
        colour, other = pick(rng, CLOTHS), pick(rng, CLOTHS)
        cover = patterns.fabric(rng.texture(rng.integers(4)), colour, other)
    covered = float(rng.choice([0.62, 0.75, 0.85, 1.0]))
    kind = rng.random()
    if kind < 0.85:
        y, drop = -length * (1 - covered) / 2, rng.uniform(0.1, 0.28)
        parts.append(
            cushion((0, y, top - drop), (width + 0.04, length * covered, drop + 0.05), cover, 0.1)
        )
        if covered < 0.9 and rng.random() < 0.5:
            fold = (0, y + length * covered / 2, top + 0.02)
            parts.append(cushion(fold, (width + 0.03, 0.3, 0.05), LINEN, 0.3, 6))
    if rng.random() < 0.3:
        throw = (0, -length * 0.32, top - 0.1)
        parts.append(cushion(throw, (width + 0.06, 0.45, 0.17), any_cloth(rng), 0.1, 6))
    pillow = LINEN if rng.random() < 0.6 else shade(rng, pick(rng, CLOTHS))
    count, lift = (2 if width > 1.2 else 1), 0.05 if covered == 1.0 and kind < 0.85 else 0.0
    for i in range(count):
        x = ((i + 0.5) / count - 0.5) * width
        size = (width / count * 0.82, 0.42, 0.15)
        parts.append(cushion((x, length / 2 - 0.32, top - 0.02 + lift), size, pillow, 0.6))
    return parts


def _panelled(
    rng: Random, width: float, length: float, base: float, head: float, foot: float, frame: Surface
) -> list[Part]:
    """Boards at the head, the sides and perhaps the foot."""
    y, w = length / 2, width + 0.08
    parts: list[Part] = []
    if rng.random() < 0.5:
        parts.append(box((0, 0, 0.0), (width, length, base), frame))
        if rng.random() < 0.4:
            parts += [
                box(
                    (width / 2 + 0.005, (i - 0.5) * length / 2, 0.05),
                    (0.02, length / 2 - 0.06, base - 0.09),
                    any_wood(rng),
                )
                for i in range(2)
            ]
    else:
        parts += legs(w, length + 0.04, base, 0.07, frame)
        parts.append(box((0, 0, base - 0.16), (width + 0.04, length, 0.16), frame))
    boards = [(y, head)] + ([(-y, foot)] if foot else [])
    for at, top in boards:
        style = rng.integers(4)
        if style == 0:
            parts.append(box((0, at, 0), (w, 0.05, top), frame))
        elif style == 1:
            parts += [box((s * w / 2, at, 0), (0.07, 0.07, top + 0.04), frame) for s in (-1, 1)]
            parts.append(box((0, at, top - 0.09), (w, 0.04, 0.09), frame))
            for x in np.linspace(-w / 2, w / 2, int(rng.integers(6, 14)))[1:-1]:
                parts.append(box((x, at, base), (0.03, 0.025, top - base - 0.05), frame))
        elif style == 2:
            parts.append(box((0, at, 0), (w, 0.05, top - 0.15), frame))
            arch = arc_points((0, 0, 0), (w / 2, 0, 0), (0, 0.22, 0), 0, pi, 12)[:, :2]
            board = prism(arch, -0.025, 0.05, frame)
            parts.append(shifted(tilted(board, (1, 0, 0), pi / 2), (0, at, top - 0.15)))
        else:
            parts += [cylinder((s * w / 2, at, 0), 0.045, top + 0.06, frame) for s in (-1, 1)]
            parts += [
                box((0, at, z), (w, 0.03, 0.13), frame) for z in np.arange(base, top - 0.1, 0.2)
            ]
    return parts


def _barred(
    rng: Random, width: float, length: float, base: float, head: float, foot: float, frame: Surface
) -> list[Part]:
    """Iron bars, straight under a rail or under an arch."""
    parts = [box((0, 0, base - 0.05), (width, length, 0.04), frame)]
    arched = rng.random() < 0.5
    for at, top in ((length / 2, head), (-length / 2, min(foot, head - 0.1))):
        x = width / 2 + 0.02
        parts += [rod((s * x, at, 0), (s * x, at, top), 0.02, frame) for s in (-1, 1)]
        rise = 0.18 if arched else 0.0
        hoop = arc_points((0, at, top), (x, 0, 0), (0, 0, rise), 0, pi, 12)
        parts.append(
            tube(hoop, 0.016, frame, 6)
            if arched
            else rod((-x, at, top), (x, at, top), 0.018, frame)
        )
        parts.append(rod((-x, at, base + 0.1), (x, at, base + 0.1), 0.012, frame))
        for share in np.linspace(-1, 1, int(rng.integers(7, 12)))[1:-1]:
            z = top + rise * np.sqrt(1 - share**2)
            parts.append(
                rod((x * share, at, base + 0.1), (x * share, at, z), 0.008, frame, segments=5)
            )
    return parts


def bunk_bed(rng: Random) -> Shape:
    """Two beds one above the other, or one high up over a desk, with a ladder."""
    material, frame = wood_or_paint(rng)
    if rng.random() < 0.35:
        material, frame = "metal", any_metal(rng)
    w, length, high = rng.uniform(0.9, 1.05), 2.0, rng.uniform(1.15, 1.4)
    thick, loft = (0.06 if material != "metal" else 0.04), rng.random() < 0.3
    parts = legs(w + 0.06, length + 0.06, high + 0.4, thick, frame)
    for base in (high,) if loft else (0.32, high):
        parts += [
            box((s * (w / 2 + 0.01), 0, base - 0.1), (0.03, length, 0.13), frame) for s in (-1, 1)
        ]
        parts += [box((0, s * (length / 2), base - 0.1), (w, 0.03, 0.13), frame) for s in (-1, 1)]
        parts.append(box((0, 0, base - 0.06), (w, length, 0.04), frame))
        parts += bedding(rng, w - 0.04, length - 0.06, base)
        for z in (base + 0.2, base + 0.32):
            parts += [box((0, s * length / 2, z), (w, 0.025, 0.05), frame) for s in (-1, 1)]
            if base == high:
                parts.append(box((-w / 2, 0, z), (0.025, length, 0.05), frame))
                parts.append(box((w / 2, 0.25, z), (0.025, length - 0.5, 0.05), frame))
    if loft:
        parts.append(box((-0.15, 0.1, 0.7), (w * 0.6, length * 0.8, 0.03), frame))
    x = w / 2 + 0.06
    for y in (-length / 2 + 0.1, -length / 2 + 0.45):
        parts.append(rod((x + 0.12, y, 0), (x, y, high + 0.3), 0.022, frame))
    for z in np.linspace(0.25, high, 5):
        shift = x + 0.12 * (1 - z / (high + 0.3))
        parts.append(
            rod((shift, -length / 2 + 0.1, z), (shift, -length / 2 + 0.45, z), 0.017, frame)
        )
    return Shape(material, parts)


def crib(rng: Random) -> Shape:
    """A baby's bed with bars all around."""
    material, frame = wood_or_paint(rng)
    w, d, top = rng.uniform(1.1, 1.3), rng.uniform(0.6, 0.72), rng.uniform(0.8, 1.0)
    base = rng.uniform(0.25, 0.4)
    parts = legs(w + 0.04, d + 0.04, top, 0.05, frame)
    for y in (-d / 2, d / 2):
        parts += [box((0, y, z), (w, 0.03, 0.05), frame) for z in (base - 0.05, top - 0.06)]
        for x in np.linspace(-w / 2, w / 2, 14)[1:-1]:
            parts.append(rod((x, y, base), (x, y, top - 0.04), 0.008, frame, segments=5))
    closed = rng.random() < 0.5
    rise = rng.uniform(0.0, 0.12)
    for x in (-w / 2, w / 2):
        if closed:
            parts.append(box((x, 0, base - 0.05), (0.03, d, top - base + rise), frame))
        else:
            parts += [box((x, 0, z), (0.03, d, 0.05), frame) for z in (base - 0.05, top - 0.06)]
            for y in np.linspace(-d / 2, d / 2, 8)[1:-1]:
                parts.append(rod((x, y, base), (x, y, top - 0.04), 0.008, frame, segments=5))
    parts += [
        cushion((0, 0, base - 0.02), (w - 0.04, d - 0.04, 0.12), LINEN, 0.12),
        cushion((-0.15, 0, base + 0.05), (w * 0.65, d - 0.05, 0.09), any_cloth(rng), 0.2),
        cushion((w / 2 - 0.2, 0, base + 0.08), (0.26, d * 0.7, 0.08), LINEN, 0.6),
    ]
    return Shape(material, parts)
