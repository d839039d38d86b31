"""Families of surfaces of generated homes, for floors, walls and windows, split in two.

A family has a bounded number of members. Each draws its own seed, colours and proportions from the
family's name and its number alone; a member is either for training homes or held out for the
benchmark's.
"""

from __future__ import annotations

import colorsys
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from sim_stubs.homes.geometry.solids import Surface
from sim_stubs.homes.textures import finishes, patterns

Rgb = tuple[float, float, float]
Random = np.random.Generator

TRAINING_SHARE = 0.7


@dataclass(frozen=True, slots=True)
class Family:
    """Surfaces of one kind.

    Attributes:
        draw: Draws one member from a generator of its own.
        count: Number of members.
        tile: Edge of the texture [m]; 0 where one copy is stretched.
    """

    draw: Callable[[Random], Surface]
    count: int
    tile: float = 2.0


@dataclass(frozen=True, slots=True)
class SurfaceFinish:
    """A surface ready to be laid.

    Attributes:
        surface: PNG file or plain colour.
        tile: Edge of the texture [m].
    """

    surface: Surface
    tile: float


def finish(family: str, rng: Random, held_out: bool) -> SurfaceFinish:
    """One member of a family, of the training or of the held-out side."""
    choices = members(family, held_out)
    return _finish(family, int(choices[rng.integers(len(choices))]))


def any_finish(weights: Mapping[str, float], rng: Random, held_out: bool) -> SurfaceFinish:
    """One member of one of the families, drawn by their weights."""
    share = np.array(list(weights.values()))
    family = list(weights)[int(rng.choice(len(share), p=share / share.sum()))]
    return finish(family, rng, held_out)


@cache
def members(family: str, held_out: bool) -> tuple[int, ...]:
    """Numbers of the members on one side, ordered by their hash."""
    count = FAMILIES[family].count
    ordered = sorted(range(count), key=lambda member: _hash(family, member))
    cut = round(TRAINING_SHARE * count)
    return tuple(ordered[cut:] if held_out else ordered[:cut])


@cache
def _finish(family: str, member: int) -> SurfaceFinish:
    """A member, drawn once in a process."""
    kind = FAMILIES[family]
    return SurfaceFinish(kind.draw(np.random.default_rng(_hash(family, member))), kind.tile)


def _hash(family: str, member: int) -> int:
    digest = hashlib.sha256(f"{family} {member}".encode()).digest()
    return int.from_bytes(digest[:8], "little")


def _seed(rng: Random) -> int:
    return int(rng.integers(1 << 31))


def _tint(rng: Random, saturation: tuple[float, float], value: tuple[float, float]) -> Rgb:
    """A colour of rooms: sand, green or blue, now and then a rose or lilac."""
    low, high = ((0.03, 0.14), (0.22, 0.45), (0.48, 0.64), (0.7, 1.0))[
        int(rng.choice(4, p=(0.42, 0.22, 0.26, 0.10)))
    ]
    strength = rng.uniform(*saturation) * (0.6 if low == 0.7 else 1.0)
    return colorsys.hsv_to_rgb(rng.uniform(low, high), strength, rng.uniform(*value))


def _brown(rng: Random, value: tuple[float, float] = (0.25, 0.72)) -> Rgb:
    """A wood, from nearly black over red-brown and honey to a pale grey."""
    return colorsys.hsv_to_rgb(rng.uniform(0.03, 0.09), rng.uniform(0.15, 0.6), rng.uniform(*value))


def _stone(rng: Random, value: tuple[float, float] = (0.3, 0.82)) -> Rgb:
    """A grey with a cold or warm touch."""
    hue = rng.uniform(0.55, 0.62) if rng.random() < 0.3 else rng.uniform(0.04, 0.12)
    return colorsys.hsv_to_rgb(hue, rng.uniform(0.01, 0.14), rng.uniform(*value))


def _beside(rng: Random, colour: Rgb, contrast: tuple[float, float]) -> Rgb:
    """A darker relative of a colour: its value times `contrast`, of a hue not far away."""
    hue, saturation, value = colorsys.rgb_to_hsv(*colour)
    hue = (hue + rng.normal(0, 0.04)) % 1.0
    saturation = min(0.6, saturation + rng.uniform(0.0, 0.25))
    return colorsys.hsv_to_rgb(hue, saturation, value * rng.uniform(*contrast))


def _paint(rng: Random) -> Surface:
    if rng.random() < 0.3:
        return colorsys.hsv_to_rgb(rng.uniform(0.05, 0.15), rng.uniform(0, 0.06),
                                   rng.uniform(0.82, 0.92))  # fmt: skip
    return _tint(rng, (0.05, 0.28), (0.68, 0.9))


def _tiles(rng: Random) -> Surface:
    colour = _stone(rng, (0.45, 0.85))
    other = colour if rng.random() < 0.4 else _beside(rng, colour, (0.45, 0.9))
    return patterns.tiles(_seed(rng), colour, other, int(rng.integers(4, 10)))


def _flagstones(rng: Random) -> Surface:
    colour = _stone(rng)
    joint = _beside(rng, colour, (0.5, 0.8))
    return finishes.flagstones(_seed(rng), colour, joint, int(rng.integers(14, 50)))


def _marble(rng: Random) -> Surface:
    colour = _stone(rng, (0.5, 0.9))
    vein = _beside(rng, colour, (0.4, 0.75))
    return finishes.marble(_seed(rng), colour, vein, int(rng.integers(2, 5)))


def _fitted_carpet(rng: Random) -> Surface:
    colour = _tint(rng, (0.03, 0.25), (0.3, 0.7))
    return finishes.fitted_carpet(_seed(rng), colour, _beside(rng, colour, (0.7, 0.9)))


def _plaster(rng: Random) -> Surface:
    return finishes.plaster(_seed(rng), _tint(rng, (0.0, 0.22), (0.7, 0.9)))


def _wallpaper(rng: Random) -> Surface:
    colour = _tint(rng, (0.02, 0.25), (0.72, 0.9))
    motif = _beside(rng, colour, (0.5, 0.85))
    return patterns.wallpaper(_seed(rng), colour, motif, int(rng.integers(40, 120)))


def _stripes(rng: Random) -> Surface:
    colour = _tint(rng, (0.02, 0.22), (0.74, 0.9))
    return finishes.stripes(_seed(rng), colour, _beside(rng, colour, (0.65, 0.92)))


def _ornaments(rng: Random) -> Surface:
    colour = _tint(rng, (0.02, 0.25), (0.7, 0.9))
    return finishes.ornaments(_seed(rng), colour, _beside(rng, colour, (0.6, 0.9)))


def _bricks(rng: Random) -> Surface:
    if rng.random() < 0.35:  # whitewashed
        colour = colorsys.hsv_to_rgb(0.08, rng.uniform(0, 0.08), rng.uniform(0.72, 0.85))
    else:
        hue = rng.uniform(0.01, 0.07)
        colour = colorsys.hsv_to_rgb(hue, rng.uniform(0.35, 0.6), rng.uniform(0.4, 0.65))
    return finishes.bricks(_seed(rng), colour, _stone(rng, (0.5, 0.75)))


def _wall_tiles(rng: Random) -> Surface:
    colour = _tint(rng, (0.0, 0.12), (0.75, 0.92))
    accent = _tint(rng, (0.1, 0.4), (0.45, 0.8))
    return finishes.wall_tiles(_seed(rng), colour, accent, int(rng.integers(8, 18)))


FAMILIES: Mapping[str, Family] = {
    "planks": Family(lambda rng: patterns.planks(_seed(rng), _brown(rng)), 40),
    "parquet": Family(
        lambda rng: finishes.parquet(
            _seed(rng), _brown(rng, (0.35, 0.7)), int(rng.integers(3, 7)), int(rng.choice([4, 8]))
        ),
        30,
    ),
    "laminate": Family(
        lambda rng: finishes.laminate(
            _seed(rng), _brown(rng, (0.45, 0.8)), int(rng.integers(8, 13))
        ),
        30,
    ),
    "tiles": Family(_tiles, 40),
    "flagstones": Family(_flagstones, 20),
    "marble": Family(_marble, 20),
    "concrete": Family(lambda rng: finishes.concrete(_seed(rng), _stone(rng, (0.4, 0.75))), 20),
    "fitted carpet": Family(_fitted_carpet, 20),
    "paint": Family(_paint, 60, 2.5),
    "plaster": Family(_plaster, 30, 2.5),
    "wallpaper": Family(_wallpaper, 40, 2.5),
    "stripes": Family(_stripes, 30, 2.5),
    "ornaments": Family(_ornaments, 30, 2.5),
    "bricks": Family(_bricks, 20, 2.5),
    "wall tiles": Family(_wall_tiles, 40, 2.5),
    "ceiling": Family(
        lambda rng: colorsys.hsv_to_rgb(
            rng.uniform(0.05, 0.15), rng.uniform(0, 0.05), rng.uniform(0.86, 0.95)
        ),
        20,
    ),
    "door": Family(lambda rng: patterns.wood(_seed(rng), _brown(rng, (0.2, 0.6))), 20, 0.0),
    "stair wood": Family(lambda rng: patterns.wood(_seed(rng), _brown(rng)), 24, 1.0),
    "stair stone": Family(
        lambda rng: finishes.concrete(_seed(rng), _stone(rng, (0.5, 0.85))), 16, 1.0
    ),
    "stair metal": Family(lambda rng: _stone(rng, (0.08, 0.7)), 16, 1.0),
    "outdoors": Family(lambda rng: patterns.outdoors(_seed(rng)), 40, 0.0),
}
"""Families by name."""
