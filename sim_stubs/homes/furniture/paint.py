"""Paint for pieces of furniture: in shades of a colour, or in one plain colour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import cv2
import numpy as np

from sim_stubs.homes.geometry.solids import Part, Piece, by_material

COLOURS: Mapping[str, tuple[float, float, float]] = {
    "red": (0.80, 0.08, 0.08),
    "blue": (0.08, 0.20, 0.75),
    "green": (0.05, 0.50, 0.15),
    "purple": (0.45, 0.10, 0.60),
    "orange": (0.95, 0.42, 0.05),
    "pink": (0.92, 0.45, 0.62),
    "white": (0.90, 0.90, 0.90),
    "black": (0.10, 0.10, 0.11),
    "grey": (0.50, 0.50, 0.51),
    "brown": (0.38, 0.22, 0.12),
}
"""Common colours by name; yellow is left to the chair that rehearsals look for."""


def painted_in_shades(piece: Piece, rgba: Sequence[float]) -> Piece:
    """`piece` in shades of `rgba` (4,), without textures; glass stays glass.

    The brightest part takes the colour itself, darker ones down to 60 % of it.
    """
    brightness = np.array([_brightness(part) for part in piece.parts])
    shades = 0.6 + 0.4 * brightness / max(float(brightness.max()), 1e-6)
    parts = tuple(
        replace(
            part,
            rgba=np.array([*(shade * np.array(rgba[:3])), rgba[3] * part.rgba[3]], np.float32),
            texture=None,
        )
        for part, shade in zip(piece.parts, shades, strict=True)
    )
    return replace(piece, parts=parts)


def _brightness(part: Part) -> float:
    """Mean of the part's colour, 0 to 1."""
    tint = float(part.rgba[:3].mean())
    if part.texture is None:
        return tint
    image = cv2.imread(str(part.texture))
    return tint if image is None else tint * float(image.mean()) / 255.0


def painted_plain(piece: Piece, label: str, rgb: tuple[float, float, float]) -> Piece:
    """`piece` in one plain colour, as an instance of `label`."""
    rgba = np.array([*rgb, 1.0], np.float32)
    parts = by_material([replace(part, rgba=rgba, texture=None) for part in piece.parts])
    return replace(piece, label=label, parts=parts)
