"""The canvas of textures, and the PNG files that they become."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.files import user_folder

Colour = Sequence[float] | NDArray[np.float64]
"""Red, green, blue in [0, 1]."""
Image = NDArray[np.float32]
"""(H, W, 3) red, green, blue in [0, 1], or (H, W) of one value a pixel."""

SIDE = 512
"""Edge of most textures [px]."""


def plain_square(colour: Colour) -> Image:
    """A square of one colour."""
    return np.full((SIDE, SIDE, 3), np.asarray(colour, np.float32), np.float32)


def clouds(rng: np.random.Generator) -> Image:
    """Smooth noise at three scales, about -1 to 1, that wraps around."""
    total = np.zeros((SIDE, SIDE), np.float32)
    for size, weight in ((8, 0.6), (24, 0.35), (80, 0.2)):
        coarse = rng.uniform(-1, 1, (size, size)).astype(np.float32)
        padded = np.pad(coarse, 2, mode="wrap")
        scale = SIDE / size
        fine = cv2.resize(padded, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
        margin = round(2 * scale)
        total += weight * fine[margin : margin + SIDE, margin : margin + SIDE]
    return total


def grain(rng: np.random.Generator, depth: float) -> Image:
    """Factor of about 1 with streaks along the rows."""
    noise = rng.normal(0.0, 1.0, (SIDE, SIDE // 16)).astype(np.float32)
    streaks = cv2.resize(noise, (SIDE, SIDE), interpolation=cv2.INTER_LINEAR)
    return np.asarray(np.clip(1 + depth * 0.5 * streaks, 0.4, 1.4), np.float32)


def wrapped_ellipse(
    image: Image,
    centre: tuple[int, int],
    axes: tuple[int, int],
    angle: float,
    colour: Colour,
) -> None:
    """An ellipse that goes on at the other side where it crosses an edge."""
    for dx in (-SIDE, 0, SIDE):
        for dy in (-SIDE, 0, SIDE):
            at = (int(centre[0]) + dx, int(centre[1]) + dy)
            cv2.ellipse(image, at, axes, angle, 0, 360, tuple(colour), -1, cv2.LINE_AA)


def texture_folder() -> Path:
    """Folder of the textures in the user's cache."""
    return user_folder("XDG_CACHE_HOME", ".cache") / "textures"


def saved(image: NDArray[np.floating]) -> Path:
    """PNG file of an (H, W, 3) RGB image in [0, 1], in the user's cache, named by its content."""
    rgb = np.clip(image * 255, 0, 255).astype(np.uint8)
    path = texture_folder() / f"{hashlib.sha256(rgb.tobytes()).hexdigest()[:24]}.png"
    if not path.exists():
        encoded, png = cv2.imencode(".png", np.ascontiguousarray(rgb[..., ::-1]))
        assert encoded
        keep(path, png.tobytes())
    return path


def keep(path: Path, content: bytes) -> None:
    """Write a file of the cache, whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    # Another process may draw the same texture: each writes its own file and renames it.
    scratch = path.with_suffix(f".{os.getpid()}")
    scratch.write_bytes(content)
    scratch.replace(path)
