"""Materials, colours and components of procedural furniture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import SupportsInt, TypeVar

import numpy as np

from sim_stubs.homes.furniture.shapes.curved_solids import rod
from sim_stubs.homes.geometry.solids import Part, Surface, box, cylinder
from sim_stubs.homes.textures import patterns

Rgb = tuple[float, float, float]
T = TypeVar("T")

HELD_OUT_TEXTURES = 1_000_000
"""Least seed of the textures of held-out homes; those of training homes are below."""


class Random(np.random.Generator):
    """A generator with the side of the split that it draws for."""

    def __init__(self, rng: np.random.Generator, held_out: bool) -> None:
        """Share the state of `rng`: draws advance both."""
        super().__init__(rng.bit_generator)
        self.held_out = held_out

    def texture(self, number: SupportsInt) -> int:
        """Seed of the texture of a number on this side."""
        return int(number) + (HELD_OUT_TEXTURES if self.held_out else 0)


@dataclass(frozen=True, slots=True)
class Shape:
    """Procedural furniture in the frame of `Piece`, not yet centred.

    Attributes:
        material: Adjective of the material for the name ("wooden"); empty without one.
        parts: Meshes of the piece.
    """

    material: str
    parts: list[Part]


PORCELAIN = (0.88, 0.89, 0.90)
STEEL = (0.62, 0.64, 0.67)
CHROME = (0.75, 0.77, 0.80)
BLACK = (0.07, 0.07, 0.08)
GLASS = (0.72, 0.82, 0.85)
WATER = (0.60, 0.78, 0.86)
WOODS: tuple[Rgb, ...] = (
    (0.42, 0.27, 0.18), (0.30, 0.19, 0.13), (0.58, 0.42, 0.32), (0.66, 0.48, 0.28),
    (0.80, 0.66, 0.44), (0.55, 0.28, 0.14), (0.20, 0.13, 0.10), (0.72, 0.62, 0.50),
)  # fmt: skip
CLOTHS: tuple[Rgb, ...] = (
    (0.30, 0.36, 0.45), (0.45, 0.28, 0.26), (0.36, 0.42, 0.38), (0.50, 0.47, 0.46),
    (0.80, 0.75, 0.66), (0.85, 0.84, 0.82), (0.20, 0.20, 0.22), (0.62, 0.12, 0.14),
    (0.14, 0.26, 0.52), (0.20, 0.42, 0.28), (0.42, 0.24, 0.46), (0.85, 0.48, 0.18),
    (0.78, 0.52, 0.58), (0.35, 0.22, 0.15), (0.16, 0.46, 0.50), (0.62, 0.60, 0.58),
)  # fmt: skip
LEATHERS: tuple[Rgb, ...] = (
    (0.08, 0.08, 0.08), (0.28, 0.15, 0.09), (0.50, 0.30, 0.17), (0.86, 0.83, 0.77),
    (0.45, 0.07, 0.07), (0.35, 0.35, 0.36),
)  # fmt: skip
PAINTS: tuple[Rgb, ...] = (
    (0.80, 0.10, 0.10), (0.10, 0.25, 0.70), (0.12, 0.50, 0.22), (0.90, 0.45, 0.10),
    (0.50, 0.18, 0.58), (0.90, 0.50, 0.62), (0.20, 0.60, 0.68), (0.88, 0.80, 0.62),
    (0.09, 0.09, 0.10), (0.50, 0.50, 0.52), (0.93, 0.93, 0.92), (0.38, 0.22, 0.14),
)  # fmt: skip
"""Saturated and plain paints, without a strong yellow, which is left to the goal."""


def pick(rng: Random, options: Sequence[T]) -> T:
    """One of the options."""
    return options[int(rng.integers(len(options)))]


def shade(rng: Random, colour: Rgb, spread: float = 0.12) -> Rgb:
    """A colour a little lighter or darker, a little warmer or colder."""
    factor = rng.uniform(1 - spread, 1 + spread) * rng.uniform(1 - spread / 3, 1 + spread / 3, 3)
    red, green, blue = np.clip(np.array(colour) * factor, 0.02, 0.98)
    return float(red), float(green), float(blue)


def any_wood(rng: Random) -> Surface:
    """One of the woods, with its grain or plain."""
    colour = pick(rng, WOODS)
    if rng.random() < 0.5:
        return patterns.wood(rng.texture(rng.integers(4)), colour)
    return shade(rng, colour)


def any_cloth(rng: Random) -> Surface:
    """One of the cloths, woven, striped or plain."""
    colour, kind = pick(rng, CLOTHS), rng.random()
    if kind < 0.55:
        return shade(rng, colour)
    other = pick(rng, CLOTHS) if kind > 0.88 else None
    return patterns.fabric(rng.texture(rng.integers(4)), colour, other)


def any_paint(rng: Random) -> Surface:
    """One of the paints."""
    return shade(rng, pick(rng, PAINTS))


def any_white(rng: Random) -> Surface:
    """White as of sanitary ware and household machines, now and then cream or grey."""
    return shade(
        rng, pick(rng, (PORCELAIN, PORCELAIN, (0.95, 0.95, 0.94), (0.88, 0.86, 0.80))), 0.04
    )


def any_metal(rng: Random) -> Surface:
    """Chrome, steel, black, white or brass."""
    return pick(rng, (CHROME, STEEL, STEEL, BLACK, (0.9, 0.9, 0.9), (0.62, 0.48, 0.25)))


def any_leather(rng: Random) -> Surface:
    """One of the leathers."""
    return shade(rng, pick(rng, LEATHERS))


def wood_or_paint(rng: Random) -> tuple[str, Surface]:
    """Material and surface of joined furniture: mostly wood, sometimes white or painted."""
    kind = rng.random()
    if kind < 0.6:
        return "wooden", any_wood(rng)
    if kind < 0.85:
        return "", shade(rng, (0.92, 0.92, 0.90), 0.05)
    return "", any_paint(rng)


def upholstery(rng: Random) -> tuple[str, Surface]:
    """Material and surface of a cover."""
    return ("leather", any_leather(rng)) if rng.random() < 0.3 else ("fabric", any_cloth(rng))


def legs(
    width: float, depth: float, height: float, thick: float, surface: Surface,
    *, splay: float = 0.0, round_: bool = False,
) -> list[Part]:  # fmt: skip
    """Four legs under the corners, square or round; `splay` spreads their feet [m]."""
    x, y = (width - thick) / 2, (depth - thick) / 2
    corners = [(sx, sy) for sx in (-1, 1) for sy in (-1, 1)]
    if splay > 0 or round_:
        return [
            rod((sx * x, sy * y, height), (sx * (x + splay), sy * (y + splay), 0.0),
                thick / 2, surface, thick / 2 * (0.7 if splay else 1.0))
            for sx, sy in corners
        ]  # fmt: skip
    return [box((sx * x, sy * y, 0), (thick, thick, height), surface) for sx, sy in corners]


def cabinet(
    surface: Surface,
    size: tuple[float, float, float],
    grid: tuple[int, int],
    front: Surface,
    handle: Surface = STEEL,
    *,
    knobs: bool = False,
    base: float = 0.0,
) -> list[Part]:
    """A body with rows and columns of doors or drawers, `base` [m] above the floor.

    Args:
        surface: Of the body.
        size: Width, depth and height above the floor [m].
        grid: Number of rows and columns.
        front: Surface of the doors or drawers.
        handle: Surface of the handles.
        knobs: Whether the handles are knobs instead of bars.
        base: Height of the space below the body [m].
    """
    (width, depth, height), (rows, columns) = size, grid
    parts = [box((0, 0, base), (width, depth, height - base), surface)]
    w, h = width / columns, (height - base - 0.04) / rows
    for row in range(rows):
        for column in range(columns):
            x, z = (column + 0.5) * w - width / 2, base + 0.02 + row * h
            parts.append(box((x, -depth / 2 - 0.008, z), (w - 0.015, 0.016, h - 0.015), front))
            drawer = h < w
            side = 0.0 if drawer else (w / 2 - 0.05) * (-1 if column % 2 else 1)
            middle = z + (h / 2 - 0.01 if drawer or h > 0.9 else h * 0.75)
            if knobs:
                start = (x + side, -depth / 2 - 0.016, middle)
                end = (x + side, -depth / 2 - 0.04, middle)
                parts.append(rod(start, end, 0.012, handle, 0.016, 6))
            else:
                long = min(0.16, 0.5 * (w if drawer else h))
                grip = (long, 0.02, 0.014) if drawer else (0.014, 0.02, long)
                parts.append(
                    box((x + side, -depth / 2 - 0.026, middle - grip[2] / 2), grip, handle)
                )
    return parts


def disc(centre: tuple[float, float, float], radius: float, thick: float, surface: Surface) -> Part:
    """A lying disc."""
    return cylinder(centre, radius, thick, surface, segments=24)
