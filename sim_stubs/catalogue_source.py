"""Furniture for a home from the Sweet Home 3D catalogue, with plain shapes where it has none."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs import shapes
from sim_stubs.furnishing import Source
from sim_stubs.furniture import Entry, choose, load
from sim_stubs.furniture_classes import CLASSES
from sim_stubs.piece import Part, Piece

DRAWS = 20
"""Models tried before a plain shape is taken."""
YELLOW_SHARE = 0.02
"""A model with a larger share of yellow in one of its parts could be taken for the goal."""


def catalogue_source(entries: Sequence[Entry]) -> Source:
    """Draws models from `entries`; none of them is yellow, which is the goal's own colour.

    Models that hang on a wall, and classes that the catalogue lacks, are plain shapes.
    """
    standing = tuple(entry for entry in entries if entry.elevation == 0.0)

    def piece(label: str, rng: np.random.Generator) -> Piece:
        if label in CLASSES:
            for _ in range(DRAWS):
                entry = choose(label, rng, standing)
                if entry is None:
                    break
                model = load(entry, label)
                if not any(_yellow_share(part) > YELLOW_SHARE for part in model.parts):
                    return model
        return shapes.piece(label, rng)

    return piece


def _yellow_share(part: Part) -> float:
    """Share of a part's colours, 0 to 1, that are saturated and between orange and lime."""
    colours: NDArray[np.float32] = part.rgba[None, None, :3].astype(np.float32)
    if part.texture is not None:
        texture = cv2.imread(str(part.texture))
        if texture is not None:
            colours = colours * (texture[..., ::-1].astype(np.float32) / np.float32(255.0))
    hue, saturation, value = np.moveaxis(cv2.cvtColor(colours, cv2.COLOR_RGB2HSV), 2, 0)
    return float(np.mean((hue > 38) & (hue < 75) & (saturation > 0.5) & (value > 0.3)))
