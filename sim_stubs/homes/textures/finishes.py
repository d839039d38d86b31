"""Pictures of floors and walls, drawn from a seed. One tile wraps around.

It covers 2 m of a floor, and 2.5 m of a wall.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from sim_stubs.homes.textures.cache import drawn_once
from sim_stubs.homes.textures.canvas import (
    SIDE,
    Colour,
    Image,
    clouds,
    grain,
    plain_square,
    saved,
    wrapped_ellipse,
)


@drawn_once
def parquet(seed: int, colour: Colour, staves: int = 4, blocks: int = 8) -> Path:
    """Square blocks of short staves, laid by turns along and across."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour)
    lengthwise, crosswise = grain(rng, 0.2), grain(rng, 0.2).T
    side = SIDE // blocks
    for i in range(blocks):
        for j in range(blocks):
            at = np.s_[i * side : (i + 1) * side, j * side : (j + 1) * side]
            block = image[at] if (i + j) % 2 else image[at].swapaxes(0, 1)
            for stave in np.array_split(block, staves):
                stave *= rng.uniform(0.78, 1.15)
                stave[0] *= 0.7
            image[at] *= (lengthwise if (i + j) % 2 else crosswise)[at][..., None]
    return saved(image)


@drawn_once
def laminate(seed: int, colour: Colour, rows: int = 10) -> Path:
    """Long boards of one even tone with printed grain and knots."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour) * grain(rng, 0.22)[..., None]
    edges = np.linspace(0, SIDE, rows + 1).astype(int)
    for top, bottom in pairwise(edges):
        joint = int(rng.integers(0, SIDE))
        # The board that the tile's edge cuts goes on at the other side.
        board = np.roll(image[top:bottom], -joint, axis=1)
        board *= rng.uniform(0.93, 1.06)
        for _ in range(int(rng.integers(0, 3))):
            at = (int(rng.integers(20, SIDE - 20)), int(rng.integers(5, bottom - top - 5)))
            knot = np.array(colour) * rng.uniform(0.5, 0.7)
            axes = (int(rng.integers(4, 10)), int(rng.integers(2, 4)))
            cv2.ellipse(board, at, axes, 0, 0, 360, knot.tolist(), -1, cv2.LINE_AA)
        board[:, :2] *= 0.75
        board[:1] *= 0.7
        image[top:bottom] = np.roll(board, joint, axis=1)
    return saved(image)


@drawn_once
def flagstones(seed: int, colour: Colour, joint: Colour, count: int = 26) -> Path:
    """Irregular slabs: cells around random points, with joints between them."""
    from scipy.spatial import cKDTree  # what is drawn already needs none of it

    rng = np.random.default_rng(seed)
    points = rng.uniform(0, SIDE, (count, 2))
    half = SIDE // 2
    u, v = np.meshgrid(np.arange(half) * 2.0, np.arange(half) * 2.0)
    distances, nearest = cKDTree(points, boxsize=SIDE).query(np.stack([u, v], axis=-1), k=2)
    apart = cv2.resize(distances[..., 1] - distances[..., 0], (SIDE, SIDE))
    stone = nearest[..., 0].repeat(2, axis=0).repeat(2, axis=1)
    shades = np.asarray(colour) * rng.uniform(0.78, 1.12, (count, 1)) * _tinted(rng, count)
    image = shades[stone].astype(np.float32)
    image[apart < 7] = joint
    return saved(image * (1 + 0.16 * clouds(rng) + _speckles(rng, 0.04))[..., None])


@drawn_once
def marble(seed: int, colour: Colour, vein: Colour, count: int = 3) -> Path:
    """Large polished slabs with veins."""
    rng = np.random.default_rng(seed)
    turbulence = clouds(rng) + 0.5 * clouds(rng)
    strength = np.exp(-np.abs(turbulence) * rng.uniform(9, 18))[..., None]
    image = plain_square(colour) * (1 - strength) + np.asarray(vein, np.float32) * strength
    image *= (1 + 0.10 * clouds(rng))[..., None]
    edges = np.linspace(0, SIDE, count + 1).astype(int)[:-1]
    for edge in edges:
        image[edge : edge + 2] *= 0.7
        image[:, edge : edge + 2] *= 0.7
    return saved(image)


@drawn_once
def concrete(seed: int, colour: Colour) -> Path:
    """Trowelled screed with stains and a few cracks."""
    rng = np.random.default_rng(seed)
    image = plain_square(colour) * (1 + 0.11 * clouds(rng) + _speckles(rng, 0.04))[..., None]
    for _ in range(3):
        steps = rng.normal(0, 1, (40, 2)).cumsum(axis=0) * 2 + np.arange(40)[:, None] * (3, 1)
        crack = (rng.integers(60, SIDE - 190, 2) + steps).astype(np.int32)
        darker = (np.asarray(colour) * 0.62).tolist()
        cv2.polylines(image, [crack], False, darker, 1, cv2.LINE_AA)
    return saved(image)


@drawn_once
def fitted_carpet(seed: int, colour: Colour, fleck: Colour) -> Path:
    """Short pile from wall to wall, with flecks of a second colour."""
    rng = np.random.default_rng(seed)
    flecks = cv2.GaussianBlur(rng.random((SIDE, SIDE)).astype(np.float32), (0, 0), 1.5)
    image = plain_square(colour)
    image[flecks > np.quantile(flecks, rng.uniform(0.8, 0.95))] = fleck
    return saved(image * (1 + 0.07 * clouds(rng) + _speckles(rng, 0.10))[..., None])


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


def _speckles(rng: np.random.Generator, depth: float) -> Image:
    """(SIDE, SIDE) noise of single pixels."""
    return (depth * rng.standard_normal((SIDE, SIDE))).astype(np.float32)


def _tinted(rng: np.random.Generator, count: int) -> Image:
    """(count, 3) factors around 1 that shift a colour a little."""
    return rng.uniform(0.95, 1.05, (count, 3)).astype(np.float32)
