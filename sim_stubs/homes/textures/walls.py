"""Pictures of walls, drawn from a seed. One tile covers 2.5 m and wraps around."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from sim_stubs.homes.textures.canvas import (
    SIDE,
    Colour,
    clouds,
    drawn_once,
    plain_square,
    saved,
    wrapped_ellipse,
)


@drawn_once
def plaster(seed: int, colour: Colour) -> Path:
    """Paint on rough plaster, a little uneven."""
    rng = np.random.default_rng(seed)
    lumps = cv2.GaussianBlur(rng.standard_normal((SIDE, SIDE)), (0, 0), 2.0) / 0.14
    return saved(plain_square(colour) * (1 + 0.045 * clouds(rng) + 0.02 * lumps)[..., None])


@drawn_once
def stripes(seed: int, colour: Colour, other: Colour) -> Path:
    """Upright stripes of several widths, some with a fine line beside them."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour)
    period = int(SIDE / rng.integers(4, 10))
    bands = np.sort(rng.uniform(0, period, 4)).astype(int)
    fine = rng.random() < 0.5
    for start in range(0, SIDE - period + 1, period):
        image[:, start + bands[0] : start + bands[1]] = other
        if fine:
            image[:, start + bands[2] : start + bands[2] + 2] = np.asarray(other) * 0.8
    return saved(image * (1 + 0.04 * clouds(rng))[..., None])


@drawn_once
def ornaments(seed: int, colour: Colour, motif: Colour) -> Path:
    """One ornament of petals in a lattice, every second row offset by half."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour)
    side = SIDE // int(rng.choice([4, 6, 8]))
    petals, round_middle = int(rng.integers(3, 7)), rng.random() < 0.6
    axes = (int(side * rng.uniform(0.14, 0.2)), int(side * rng.uniform(0.05, 0.1)))
    for row in range(0, SIDE // side):
        for column in range(0, SIDE // side):
            x = int((column + 0.5 * (row % 2) + 0.25) * side)
            y = int((row + 0.5) * side)
            for turn in np.arange(petals) * 2 * np.pi / petals:
                at = (int(x + axes[0] * np.cos(turn)), int(y + axes[0] * np.sin(turn)))
                wrapped_ellipse(image, at, axes, float(np.degrees(turn)), motif)
            if round_middle:
                inner = tuple((np.asarray(motif) * 0.8).tolist())
                wrapped_ellipse(image, (x, y), (axes[1], axes[1]), 0.0, inner)
    return saved(image * (1 + 0.05 * clouds(rng))[..., None])


@drawn_once
def bricks(seed: int, colour: Colour, mortar: Colour, courses: int = 32) -> Path:
    """Brickwork in stretcher bond."""
    rng = np.random.default_rng(seed)
    image = plain_square(mortar)
    height, width = SIDE // courses, SIDE // 10
    for course in range(courses):
        row = np.zeros((height - 2, SIDE, 3), np.float32) + image[:1, :1]
        for brick in range(10):
            tone = np.asarray(colour) * rng.uniform(0.7, 1.2) * rng.uniform(0.94, 1.06, 3)
            row[:, brick * width : (brick + 1) * width - 2] = tone
        shift = (course % 2) * width // 2
        image[course * height : (course + 1) * height - 2] = np.roll(row, shift, axis=1)
    return saved(image * (1 + 0.14 * clouds(rng))[..., None])


@drawn_once
def wall_tiles(seed: int, colour: Colour, accent: Colour, count: int = 12) -> Path:
    """Glazed tiles with grout; a band of accents runs around at one height."""
    rng = np.random.default_rng(seed)
    image = plain_square((0.62, 0.62, 0.60))
    edges = np.linspace(0, SIDE, count + 1).astype(int)
    band, scattered = int(rng.integers(count)), rng.random() < 0.5
    for i in range(count):
        for j in range(count):
            coloured = rng.random() < 0.12 if scattered else i == band
            tone = np.asarray(accent if coloured else colour) * rng.uniform(0.94, 1.04)
            image[edges[i] + 2 : edges[i + 1], edges[j] + 2 : edges[j + 1]] = tone
    return saved(image * (1 + 0.06 * clouds(rng))[..., None])
