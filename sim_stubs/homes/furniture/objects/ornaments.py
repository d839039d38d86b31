"""Procedural pictures, mirrors, fireplaces and aquariums."""

from __future__ import annotations

from sim_stubs.homes.furniture.objects.plants import LEAVES
from sim_stubs.homes.furniture.shapes.curved_solids import (
    ellipse,
    facing,
    prism,
    rod,
    translucent,
    turned,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    GLASS,
    Random,
    Shape,
    any_metal,
    any_wood,
    pick,
    shade,
    wood_or_paint,
)
from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import Surface, box, cushion, flat_panel
from sim_stubs.homes.textures import patterns


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
