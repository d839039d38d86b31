"""Procedural chairs, office chairs, stools and benches."""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import (
    arc_points,
    ellipse,
    prism,
    rod,
    sheet,
    shifted,
    tilted,
    tube,
    turned,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    PAINTS,
    Random,
    Shape,
    any_metal,
    any_paint,
    any_wood,
    legs,
    pick,
    shade,
    upholstery,
    wood_or_paint,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder


def chair(rng: Random) -> Shape:
    """A chair: joined, upholstered, of steel tube, folding, or a moulded shell."""
    style = rng.random()
    if style < 0.45:
        return _joined(rng)
    if style < 0.62:
        return _upholstered(rng)
    if style < 0.74:
        return _cantilever(rng)
    if style < 0.82:
        return _folding(rng)
    if style < 0.90:
        return _bentwood(rng)
    return _shell(rng)


def _joined(rng: Random) -> Shape:
    """Four legs, a seat, and a back of rungs, slats, a cross or a panel."""
    material, surface = wood_or_paint(rng)
    w, d = rng.uniform(0.38, 0.48), rng.uniform(0.38, 0.48)
    seat, top = rng.uniform(0.43, 0.47), rng.uniform(0.78, 1.08)
    thick, round_ = rng.uniform(0.028, 0.045), bool(rng.random() < 0.4)
    splay = rng.choice([0.0, 0.0, 0.04])
    y = d / 2 - thick / 2
    parts = legs(w, d, seat, thick, surface, splay=float(splay), round_=round_)
    if rng.random() < 0.45:
        bar = rng.uniform(0.12, 0.25)
        for side in (-1, 1):
            x = side * (w - thick) / 2
            parts.append(box((x, 0, bar), (thick * 0.6, d - thick, thick * 0.6), surface))
        parts.append(box((0, 0, bar), (w - thick, thick * 0.6, thick * 0.6), surface))
    parts.append(box((0, 0, seat - 0.02), (w + 0.02, d + 0.02, rng.uniform(0.02, 0.05)), surface))
    if rng.random() < 0.5:
        cover = upholstery(rng)[1]
        parts.append(cushion((0, 0, seat), (w - 0.02, d - 0.03, 0.06), cover, 0.3, 6))
    back = [*_back(rng, w, thick, seat, top, surface)]
    lean = rng.uniform(0.0, 0.16)
    parts += [tilted(shifted(part, (0, y, 0)), (-1, 0, 0), lean, (0, y, seat)) for part in back]
    if rng.random() < 0.25:
        parts += _arms(w, d, seat, thick, surface)
    return Shape(material, parts)


def _back(
    rng: Random, width: float, thick: float, seat: float, top: float, surface: Surface
) -> list[Part]:
    """A back in the plane y = 0, between two posts."""
    inner, height = width - 2 * thick, top - seat
    x = (width - thick) / 2
    parts = [
        box((side * x, 0, seat - 0.02), (thick, thick, height + 0.02), surface) for side in (-1, 1)
    ]
    rail = rng.uniform(0.05, 0.10)
    parts.append(box((0, 0, top - rail), (width - thick, thick * 0.7, rail), surface))
    style = rng.integers(5)
    if style == 0:
        for z in np.linspace(seat + 0.1, top - rail - 0.08, int(rng.integers(2, 5))):
            parts.append(box((0, 0, z), (inner + thick, thick * 0.6, 0.045), surface))
    elif style == 1:
        for at in np.linspace(-inner / 2, inner / 2, int(rng.integers(3, 8)) + 2)[1:-1]:
            parts.append(box((at, 0, seat), (0.02, 0.016, height - rail), surface))
    elif style == 2:
        panel = box((0, 0, seat + 0.12), (inner + thick, thick * 0.6, height - 0.16), surface)
        parts.append(panel)
    elif style == 3:
        cover = upholstery(rng)[1]
        size = (inner + 0.01, 0.06, height - rail - 0.1)
        parts.append(cushion((0, -0.01, seat + 0.08), size, cover, 0.25, 6))
    else:
        low, high = seat + 0.1, top - rail
        parts.append(rod((-x, 0, low), (x, 0, high), 0.012, surface))
        parts.append(rod((x, 0, low), (-x, 0, high), 0.012, surface))
    return parts


def _arms(width: float, depth: float, seat: float, thick: float, surface: Surface) -> list[Part]:
    """Arm rests on posts."""
    parts = []
    for side in (-1, 1):
        x = side * (width / 2 - thick / 2)
        parts.append(box((x, -depth * 0.3, seat), (thick, thick, 0.2), surface))
        parts.append(box((x, 0, seat + 0.2), (thick * 1.4, depth, thick * 0.8), surface))
    return parts


def _upholstered(rng: Random) -> Shape:
    """Seat and back under one cover, on legs of wood or metal."""
    material, cover = upholstery(rng)
    w, d = rng.uniform(0.42, 0.52), rng.uniform(0.42, 0.5)
    seat, top = rng.uniform(0.44, 0.48), rng.uniform(0.8, 1.05)
    wooden = rng.random() < 0.6
    stand = any_wood(rng) if wooden else any_metal(rng)
    thick, soft = rng.uniform(0.05, 0.11), rng.uniform(0.1, 0.35)
    splay = float(rng.choice([0.0, 0.05]))
    back = cushion((0, d / 2 - 0.04, seat - 0.06), (w, 0.08, top - seat + 0.06), cover, soft)
    parts = [
        *legs(w - 0.04, d - 0.04, seat - thick, 0.035, stand, splay=splay, round_=not wooden),
        cushion((0, 0, seat - thick), (w, d, thick), cover, soft),
        tilted(back, (-1, 0, 0), rng.uniform(0, 0.2), (0, d / 2, seat)),
    ]
    if rng.random() < 0.3:
        for side in (-1, 1):
            at = (side * w / 2, 0.02, seat - 0.06)
            parts.append(cushion(at, (0.07, d, 0.26), cover, soft))
    return Shape(material, parts)


def _cantilever(rng: Random) -> Shape:
    """Seat and back held by a bent steel tube without hind legs, or by four thin ones."""
    tubing, (material, cover) = any_metal(rng), upholstery(rng)
    w, d, seat, top = rng.uniform(0.44, 0.52), 0.46, 0.46, rng.uniform(0.8, 0.95)
    parts = []
    free = rng.random() < 0.6
    arms = rng.random() < 0.5
    for side in (-1, 1):
        x = side * w / 2
        if free:
            path = [
                (x, d / 2, 0.012),
                (x, -d / 2, 0.012),
                (x, -d / 2, seat - 0.02),
                (x, d / 2, seat - 0.02),
                (x, d / 2 + 0.06, top),
            ]
            bars = list(pairwise(path))
        else:
            bars = [
                ((x, -d / 2, 0), (x, -d / 2, seat)),
                ((x, d / 2, 0), (x, d / 2 + 0.03, top)),
                ((x, -d / 2, seat - 0.03), (x, d / 2, seat - 0.03)),
            ]
        parts += [rod(a, b, 0.013, tubing) for a, b in bars]
        if arms:
            parts.append(box((x, 0, seat + 0.2), (0.04, d, 0.025), BLACK))
            parts.append(rod((x, -d / 2, seat), (x, -d / 2, seat + 0.2), 0.013, tubing))
    if free:
        parts.append(rod((-w / 2, d / 2, 0.012), (w / 2, d / 2, 0.012), 0.013, tubing))
    back = cushion(
        (0, d / 2 + 0.03, seat + rng.uniform(0.08, 0.2)), (w, 0.05, top - seat - 0.18), cover, 0.2
    )
    parts += [cushion((0, 0, seat - 0.02), (w, d, 0.055), cover, 0.2), back]
    return Shape("metal" if rng.random() < 0.5 else material, parts)


def _folding(rng: Random) -> Shape:
    """Crossed legs."""
    wooden = rng.random() < 0.5
    surface: Surface = any_wood(rng) if wooden else any_paint(rng)
    thick, w, top = (0.016 if wooden else 0.011), 0.42, rng.uniform(0.76, 0.9)
    seat: Surface = surface if rng.random() < 0.6 else any_paint(rng)
    parts = [box((0, -0.02, 0.44), (w - 0.04, 0.38, 0.025), seat)]
    for side in (-1, 1):
        x = side * w / 2
        parts.append(rod((x, -0.24, 0), (x, 0.2, top), thick, surface))
        parts.append(rod((x * 0.9, 0.26, 0), (x * 0.9, -0.18, 0.45), thick, surface))
    for z in (0.12, 0.45):
        y = -0.24 + 0.44 * z / top
        parts.append(rod((-w / 2, y, z), (w / 2, y, z), thick * 0.8, surface))
    for z in np.linspace(top - 0.22, top - 0.05, int(rng.integers(1, 4))):
        y = -0.24 + 0.44 * z / top
        parts.append(box((0, y, z - 0.04), (w, 0.018, 0.07), seat))
    return Shape("wooden" if wooden else "metal", parts)


def _bentwood(rng: Random) -> Shape:
    """A cafe chair: round seat, a hoop for a back."""
    surface = any_wood(rng)
    radius, top = rng.uniform(0.19, 0.23), rng.uniform(0.82, 0.95)
    parts = [prism(ellipse(2 * radius, 2 * radius), 0.43, 0.03, surface)]
    for sx in (-1, 1):
        parts.append(rod((sx * 0.14, -0.13, 0.43), (sx * 0.19, -0.19, 0), 0.016, surface))
        parts.append(rod((sx * 0.15, 0.14, 0.45), (sx * 0.19, 0.22, 0), 0.016, surface))
    for scale in (1.0, 0.6) if rng.random() < 0.6 else (1.0,):
        hoop = arc_points(
            (0, 0.17, 0.46),
            (radius * 0.95 * scale, 0, 0),
            (0, 0.1 * scale, (top - 0.46) * scale),
            0,
            pi,
            12,
        )
        parts.append(tube(hoop, 0.014, surface, 6))
    ring = arc_points((0, 0, 0.22), (0.15, 0, 0), (0, 0.15, 0), 0, 2 * pi, 16)
    parts.append(tube(ring, 0.009, surface, 5))
    if rng.random() < 0.35:
        arms = arc_points(
            (0, 0, 0.66), (radius + 0.06, 0, 0), (0, radius + 0.04, 0), -0.5, pi + 0.5, 14
        )
        parts.append(tube(arms, 0.014, surface, 6))
        for x in (-1, 1):
            parts.append(
                rod((x * 0.18, -0.06, 0.45), (x * (radius + 0.05), -0.09, 0.66), 0.012, surface)
            )
    return Shape("wooden", parts)


def bowl(rng: Random, width: float, back: float, surface: Surface, lip: float = 0.25) -> Part:
    """A moulded seat that runs up into its back, about the middle of its bottom at z = 0.

    `lip` is how far its edges turn inwards, as a share of its width.
    """
    u = np.linspace(-1, 1, 11)
    depth, narrow = width * 0.9, rng.uniform(0.6, 0.95)
    rows = []
    for t in np.linspace(0, 1, 15):
        upright = float(np.clip((t - 0.35) / 0.3, 0, 1)) ** 2 * (
            3 - 2 * np.clip((t - 0.35) / 0.3, 0, 1)
        )
        lift = max(0.0, t - 0.42) / 0.58
        y = depth * (min(t, 0.5) / 0.5 - 0.5) + 0.14 * lift
        z = 0.04 * (1 - min(1.0, t / 0.2)) ** 2 * -1 + back * lift**1.3
        half = (
            width / 2 * (1 - (1 - narrow) * upright) * np.sqrt(1 - 0.6 * max(0.0, t - 0.85) / 0.15)
        )
        half *= np.sqrt(1 - 0.3 * max(0.0, 0.1 - t) / 0.1)
        rise = lip * width * np.abs(u) ** 2.5 * np.sin(pi * min(1.0, 0.15 + 0.75 * t))
        rows.append(np.column_stack([half * u, y - rise * upright, z + rise * (1 - upright)]))
    return sheet(np.array(rows), surface, both=True)


def _shell(rng: Random) -> Shape:
    """A plastic or wooden shell on wires, rods, or a trumpet foot."""
    wooden = rng.random() < 0.3
    surface: Surface = any_wood(rng) if wooden else any_paint(rng)
    w, seat = rng.uniform(0.44, 0.54), 0.44
    parts = [
        shifted(bowl(rng, w, rng.uniform(0.3, 0.42), surface, rng.uniform(0.05, 0.4)), (0, 0, seat))
    ]
    foot = rng.integers(3)
    if foot == 0:
        parts.append(
            turned(
                [
                    (0, 0),
                    (0.23, 0),
                    (0.22, 0.015),
                    (0.05, 0.05),
                    (0.025, 0.15),
                    (0.03, seat - 0.05),
                    (0.12, seat + 0.005),
                ],
                surface,
            )
        )
    else:
        stand = any_metal(rng) if foot == 1 else any_wood(rng)
        parts += legs(w * 0.6, w * 0.6, seat + 0.01, 0.026, stand, splay=0.09, round_=True)
    if rng.random() < 0.4:
        cover = upholstery(rng)[1]
        parts.append(cushion((0, -0.02, seat + 0.01), (w * 0.8, w * 0.8, 0.05), cover, 0.7, 6))
    return Shape("wooden" if wooden else "plastic", parts)


def office_chair(rng: Random) -> Shape:
    """A swivel chair on five castors."""
    material, cover = upholstery(rng)
    if rng.random() < 0.5:
        cover = shade(rng, pick(rng, (BLACK, BLACK, PAINTS[1], PAINTS[0], (0.3, 0.3, 0.32))))
    frame = BLACK if rng.random() < 0.7 else any_metal(rng)
    seat, top = rng.uniform(0.43, 0.5), rng.uniform(0.85, 1.2)
    w, d, soft = rng.uniform(0.44, 0.52), rng.uniform(0.42, 0.5), rng.uniform(0.25, 0.6)
    parts = [cylinder((0, 0, 0.08), 0.03, seat - 0.12, frame)]
    for k in range(5):
        angle = k * 2 * pi / 5 + 0.3
        x, y = 0.29 * np.cos(angle), 0.29 * np.sin(angle)
        parts.append(rod((0, 0, 0.11), (x, y, 0.07), 0.025, frame, 0.016))
        parts.append(rod((x - 0.02, y, 0.028), (x + 0.02, y, 0.028), 0.028, BLACK))
    gap = rng.uniform(0.04, 0.14)
    back = cushion(
        (0, d / 2, seat + gap), (w * rng.uniform(0.8, 1.0), 0.09, top - seat - gap), cover, soft
    )
    parts += [
        cushion((0, 0, seat - 0.05), (w, d, 0.10), cover, soft),
        tilted(back, (-1, 0, 0), rng.uniform(0, 0.15), (0, d / 2, seat)),
        box((0, d / 2 + 0.03, seat - 0.03), (0.06, 0.025, gap + 0.2), frame),
    ]
    if rng.random() < 0.65:
        for side in (-1, 1):
            x = side * (w / 2 + 0.03)
            parts.append(rod((x * 0.8, 0.02, seat - 0.02), (x, 0.02, seat + 0.18), 0.016, frame))
            parts.append(cushion((x, 0.0, seat + 0.17), (0.06, 0.26, 0.035), BLACK, 0.3, 4))
    return Shape(material, parts)


def stool(rng: Random) -> Shape:
    """A seat without a back, low or as high as a bar; a bar chair has a low back."""
    high = rng.random() < 0.6
    h = rng.uniform(0.62, 0.8) if high else rng.uniform(0.42, 0.5)
    r = rng.uniform(0.15, 0.2)
    material, surface = wood_or_paint(rng)
    stand = rng.integers(3)
    if stand == 0:
        metal = any_metal(rng)
        material, top = "", upholstery(rng)[1]
        parts = [turned([(0, 0), (0.21, 0), (0.2, 0.015), (0.03, 0.04), (0.025, h), (0, h)], metal)]
        ring = arc_points((0, 0, h * 0.4), (0.15, 0, 0), (0, 0.15, 0), 0, 2 * pi, 16)
        parts.append(tube(ring, 0.011, metal, 6))
        parts.append(rod((-0.15, 0, h * 0.4), (0.15, 0, h * 0.4), 0.009, metal))
        parts.append(cushion((0, 0, h - 0.02), (2 * r, 2 * r, 0.09), top, 0.6))
    else:
        round_ = stand == 1
        parts = legs(1.6 * r, 1.6 * r, h, 0.035, surface, splay=0.05 * round_, round_=round_)
        for z in (h * 0.3, h * 0.45) if high else (h * 0.35,):
            for at in (-1, 1):
                a = at * (0.8 * r - 0.017 + 0.05 * round_ * (1 - z / h))
                parts.append(rod((-a, a, z), (a, a, z), 0.011, surface))
                parts.append(rod((a, -a, z), (a, a, z), 0.011, surface))
        plan = ellipse(2.1 * r, 2.1 * r, 20, 1.0 if rng.random() < 0.6 else 0.25)
        parts.append(prism(plan, h, 0.035, surface))
    if high and rng.random() < 0.4:
        y = r * 0.95
        parts += [
            rod((x, y, h), (x, y + 0.03, h + 0.28), 0.012, surface) for x in (-r * 0.7, r * 0.7)
        ]
        parts.append(box((0, y + 0.02, h + 0.18), (1.6 * r, 0.025, 0.1), surface))
    return Shape(material, parts)


def bench(rng: Random) -> Shape:
    """A long seat without a back, or with a slatted one."""
    material, surface = wood_or_paint(rng)
    w, d, h = rng.uniform(0.95, 1.6), rng.uniform(0.32, 0.46), rng.uniform(0.42, 0.48)
    parts: list[Part] = []
    if rng.random() < 0.5:
        parts += legs(w - 0.1, d - 0.04, h - 0.04, 0.05, surface, round_=bool(rng.random() < 0.4))
    else:
        parts += [
            box((x, 0, 0), (0.05, d - 0.04, h - 0.04), surface)
            for x in (-w / 2 + 0.12, w / 2 - 0.12)
        ]
        parts.append(box((0, 0, 0.15), (w - 0.24, 0.04, 0.08), surface))
    kind = rng.integers(3)
    if kind == 0:
        count = int(rng.integers(3, 6))
        for y in np.linspace(-d / 2 + 0.04, d / 2 - 0.04, count):
            parts.append(box((0, y, h - 0.04), (w, d / count - 0.015, 0.035), surface))
    elif kind == 1:
        plan = ellipse(w, d, 28, float(rng.choice([0.2, 0.5])))
        parts.append(prism(plan, h - 0.04, 0.045, surface))
    else:
        parts.append(box((0, 0, h - 0.06), (w, d, 0.06), surface))
        parts.append(
            cushion((0, 0, h - 0.01), (w - 0.03, d - 0.03, 0.07), upholstery(rng)[1], 0.15)
        )
    if rng.random() < 0.25:
        parts += [
            box((x, d / 2 - 0.02, h), (0.04, 0.03, 0.4), surface)
            for x in (-w / 2 + 0.1, 0, w / 2 - 0.1)
        ]
        parts += [box((0, d / 2 - 0.04, z), (w, 0.02, 0.07), surface) for z in (h + 0.16, h + 0.3)]
    return Shape(material, parts)
