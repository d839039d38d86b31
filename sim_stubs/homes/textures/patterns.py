"""Pictures for surfaces, drawn from a seed: floors, wallpapers, fabrics, books, paintings.

Each function returns a PNG file in the user's cache, drawn once for each content. They are rich in
detail that does not repeat within a tile, so that a camera can find its place by looking. None is
saturated yellow.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.textures.cache import drawn_once
from sim_stubs.homes.textures.canvas import (
    SIDE,
    Colour,
    clouds,
    grain,
    plain_square,
    saved,
    wrapped_ellipse,
)

PAINT = (
    (0.72, 0.16, 0.16),
    (0.13, 0.32, 0.62),
    (0.12, 0.45, 0.28),
    (0.48, 0.24, 0.52),
    (0.10, 0.50, 0.55),
    (0.92, 0.92, 0.90),
    (0.18, 0.18, 0.22),
    (0.80, 0.45, 0.50),
)
"""Saturated colours of small things; the goal's yellow is not among them."""

DYES = (
    (0.45, 0.10, 0.12),
    (0.14, 0.20, 0.38),
    (0.55, 0.40, 0.26),
    (0.20, 0.32, 0.26),
    (0.62, 0.58, 0.52),
    (0.30, 0.16, 0.12),
    (0.75, 0.62, 0.42),
    (0.60, 0.22, 0.15),
    (0.85, 0.80, 0.70),
    (0.10, 0.10, 0.14),
)
"""Colours of oriental rugs."""


@drawn_once
def planks(seed: int, colour: Colour = (0.50, 0.33, 0.22)) -> Path:
    """A floor of brown boards; one tile is 2 m."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour)
    rows = 16
    height = SIDE // rows
    for row in range(rows):
        cuts = np.sort(rng.integers(0, SIDE, 2))
        for start, end in zip((0, *cuts), (*cuts, SIDE), strict=True):
            board = image[row * height : (row + 1) * height, start:end]
            board *= rng.uniform(0.72, 1.15)
            board[0], board[:, :1] = board[0] * 0.6, board[:, :1] * 0.6
    image *= grain(rng, 0.16)[..., None]
    return saved(image)


@drawn_once
def tiles(seed: int, colour: Colour, other: Colour, count: int = 6) -> Path:
    """Square tiles of two colours with grout between them."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour)
    edges = np.linspace(0, SIDE, count + 1).astype(int)
    for i in range(count):
        for j in range(count):
            tile = image[edges[i] : edges[i + 1], edges[j] : edges[j + 1]]
            tile[:] = np.array(colour if (i + j) % 2 else other) * rng.uniform(0.88, 1.05)
            tile[:3], tile[:, :3] = 0.55, 0.55
    image *= (1 + 0.12 * clouds(rng))[..., None]
    return saved(image)


@drawn_once
def wallpaper(seed: int, colour: Colour, motif: Colour, count: int = 70) -> Path:
    """Plaster with leaves and sprigs strewn over it; one tile is 2.5 m."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour) * (1 + 0.05 * clouds(rng))[..., None]
    for _ in range(count):
        x, y = rng.integers(0, SIDE, 2)
        shade = np.array(motif) * rng.uniform(0.75, 1.15)
        angle, length = rng.uniform(0, 360), int(rng.integers(6, 15))
        for turn in range(0, int(rng.integers(1, 4)) * 60, 60):
            wrapped_ellipse(image, (x, y), (length, length // 3), angle + turn, shade)
    return saved(image * grain(rng, 0.03)[..., None])


@drawn_once
def fabric(seed: int, colour: Colour, other: Colour | None = None) -> Path:
    """Woven cloth; with a second colour it is striped. Half as fine as floors and walls are."""
    rng = np.random.default_rng(seed)
    side = SIDE // 2
    image = plain_square(colour)[:side, :side]
    if other is not None:
        for start in range(0, side, 32):
            width = int(rng.integers(5, 17))
            image[:, start : start + width] = np.array(other) * rng.uniform(0.8, 1.1)
    weave = rng.normal(1.0, 0.08, (side, side, 1)).astype(np.float32)
    folds = cv2.resize(clouds(rng), (side, side), interpolation=cv2.INTER_AREA)
    return saved(image * weave * (1 + 0.08 * folds)[..., None])


@drawn_once
def medallion_rug(seed: int, colour: Colour, other: Colour) -> Path:
    """A rug with a border and a medallion; stretched over the rug."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour)
    for inset, shade in ((16, other), (34, colour), (44, other), (52, colour)):
        image[inset : SIDE - inset, inset : SIDE - inset] = np.array(shade) * 0.9
    for _ in range(60):
        x, y = rng.integers(80, SIDE - 80, 2)
        shade = np.array(other) * rng.uniform(0.7, 1.2)
        axes = (int(rng.integers(6, 26)), int(rng.integers(4, 12)))
        wrapped_ellipse(image, (x, y), axes, float(rng.uniform(0, 360)), shade)
    return saved(image * rng.normal(1.0, 0.08, (SIDE, SIDE, 1)).astype(np.float32))


@drawn_once
def oriental_rug(seed: int) -> Path:
    """A rug of borders, lozenges and ornaments that mirror each other; stretched over the rug."""
    rng = np.random.default_rng(seed)
    side = SIDE // 2
    half = side // 2
    image = np.zeros((side, side, 3), np.float32)

    def ink() -> NDArray[np.float64]:
        return np.array(DYES[rng.integers(len(DYES))]) * rng.uniform(0.8, 1.15)

    for inset in np.cumsum((0, *rng.integers(4, 16, 4))):
        image[inset : side - inset, inset : side - inset] = ink()
    for _ in range(30):
        x, y = rng.integers(0, half, 2)
        _lozenge(image, int(x), int(y), int(rng.integers(3, 12)), ink())
    for size in sorted(rng.integers(20, 90, 4), reverse=True):
        _lozenge(image, half, half, int(size), ink())
    image[:, half:] = image[:, :half][:, ::-1]
    image[half:] = image[:half][::-1]
    return saved(image * rng.normal(1.0, 0.08, (side, side, 1)))


def _lozenge(image: NDArray[np.float32], x: int, y: int, size: int, colour: Colour) -> None:
    corners = np.array([(x, y - size), (x + size, y), (x, y + size), (x - size, y)], np.int32)
    cv2.fillPoly(image, [corners], tuple(colour))


@drawn_once
def wood(seed: int, colour: Colour) -> Path:
    """Wood grain for furniture. Half as fine as floors and walls are."""
    side = SIDE // 2
    streaks = grain(np.random.default_rng(seed), 0.22)[::2, :side]
    return saved(plain_square(colour)[:side, :side] * streaks[..., None])


@drawn_once
def books(seed: int) -> Path:
    """One shelf full of books, seen from their spines; stretched over the shelf."""
    rng = np.random.default_rng(seed)
    image = plain_square((0.10, 0.08, 0.07))[: SIDE // 4]
    height, x = image.shape[0], 2
    while x < SIDE - 14:
        width = int(rng.integers(9, 30))
        top = int(rng.integers(4, height // 3))
        spine = image[top:, x : x + width - 1]
        spine[:] = np.array(PAINT[rng.integers(len(PAINT))]) * rng.uniform(0.7, 1.1)
        label = int(rng.integers(8, 40))
        spine[label : label + int(rng.integers(4, 22)), 2:-2] *= rng.uniform(0.4, 1.6)
        x += width
    return saved(image)


@drawn_once
def painting(seed: int) -> Path:
    """An abstract picture."""
    rng = np.random.default_rng(seed)
    image = plain_square(np.array(PAINT[rng.integers(len(PAINT))]) * 0.5 + 0.4)
    for _ in range(int(rng.integers(14, 26))):
        shade = np.array(PAINT[rng.integers(len(PAINT))]) * rng.uniform(0.6, 1.1)
        corners = rng.integers(0, SIDE, (int(rng.integers(3, 6)), 2)).astype(np.int32)
        centre = corners.mean(axis=0)
        corners = (centre + (corners - centre) * rng.uniform(0.3, 0.8)).astype(np.int32)
        cv2.fillPoly(image, [corners], shade.tolist(), cv2.LINE_AA)
        if rng.random() < 0.5:
            cv2.polylines(image, [corners], True, (0.08, 0.08, 0.1), 5, cv2.LINE_AA)
    return saved(image * grain(rng, 0.05)[..., None])


@drawn_once
def outdoors(seed: int) -> Path:
    """The view from a window by day: sky and clouds, houses or hills, trees."""
    rng = np.random.default_rng(seed)
    height = np.linspace(0, 1, SIDE, dtype=np.float32)[:, None, None]
    zenith = np.array([0.55, 0.74, 0.97]) * rng.uniform(0.85, 1.0) + rng.uniform(-0.05, 0.05, 3)
    image = (1 - height) * zenith + height * np.array([0.90, 0.95, 1.0])
    image = image + rng.uniform(0.05, 0.25) * np.clip(clouds(rng), 0, None)[..., None]
    horizon = int(SIDE * rng.uniform(0.45, 0.7))
    if rng.random() < 0.6:
        _houses(image, horizon, rng)
    else:
        _hills(image, horizon, rng)
    trees, crown = int(rng.integers(10, 70)), int(rng.integers(24, 60))
    green = np.array([0.20, 0.40, 0.20]) + rng.uniform(-0.06, 0.10, 3)
    for _ in range(trees):
        at = (int(rng.integers(0, SIDE)), int(rng.integers(horizon, SIDE)))
        leaf = green * rng.uniform(0.6, 1.4)
        cv2.circle(image, at, int(rng.integers(16, crown)), leaf.tolist(), -1, cv2.LINE_AA)
    return saved(image)


def _houses(image: NDArray[np.floating], horizon: int, rng: np.random.Generator) -> None:
    """A street front with rows of windows."""
    x = -int(rng.integers(0, 60))
    while x < SIDE:
        width = int(rng.integers(50, 150))
        top = horizon - int(rng.integers(20, 140))
        wall = np.array([0.62, 0.60, 0.58]) * rng.uniform(0.7, 1.3) + rng.uniform(-0.06, 0.06, 3)
        cv2.rectangle(image, (x, top), (x + width - 6, SIDE), wall.tolist(), -1)
        for row in range(top + 14, SIDE, 26):
            for column in range(x + 8, x + width - 20, 18):
                cv2.rectangle(image, (column, row), (column + 9, row + 13), (0.3, 0.35, 0.4), -1)
        x += width


def _hills(image: NDArray[np.floating], horizon: int, rng: np.random.Generator) -> None:
    """Ridges, the near ones greener, and a meadow."""
    across = np.linspace(0, 2 * np.pi, SIDE)
    for distance in (1.0, 0.5, 0.0):
        waves = sum(
            rng.uniform(4, 22) * np.sin(across * turns + rng.uniform(0, 6)) for turns in (1, 2, 5)
        )
        ridge = horizon - 30 * distance + waves
        ground = np.arange(SIDE)[:, None] > ridge
        far, near = np.array([0.55, 0.65, 0.75]), np.array([0.38, 0.50, 0.26])
        image[ground] = (distance * far + (1 - distance) * near) * rng.uniform(0.9, 1.1)
