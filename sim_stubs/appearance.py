"""How a piece of furniture looks in words: its colour and what it is made of, for captions."""

from __future__ import annotations

import colorsys
import re
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.piece import Part, Piece
from sim_stubs.solids import triangles

MATERIALS = {
    "wood": r"wood|wooden|oak|alder|pear|teak|pine",
    "metal": r"metal|iron|steel",
    "glass": r"glass",
    "leather": r"leather|winchester",
    "fabric": r"fabric|burlap",
    "porcelain": r"porcelain|ceramic",
    "wicker": r"wicker|rattan",
    "plastic": r"plastic",
}
"""Materials, and the words in the name of a model that tell them."""

ONE_COLOUR = 0.6
"""A colour with this share of the surface is the colour of the piece."""
TWO_COLOURS = (0.85, 0.3)
"""Least share of two colours together, and of the lesser one, to be named both."""


@dataclass(frozen=True, slots=True)
class Appearance:
    """Colour and material.

    Attributes:
        colours: The common words for its colours, the largest surface first; two at most, none
            where no one would say what colour it is.
        material: One of `MATERIALS`; None when it is not known.
    """

    colours: tuple[str, ...]
    material: str | None


def appearance(piece: Piece) -> Appearance:
    """The words for how `piece` looks; its material is told by its name."""
    names = re.findall(r"\w+", piece.name.lower())
    materials = (
        material
        for material, words in MATERIALS.items()
        if any(re.fullmatch(words, name) for name in names)
    )
    return Appearance(_dominant(piece), next(materials, None))


def colour_word(rgb: NDArray[np.float64]) -> str:
    """The common word for a colour: red, green, blue in [0, 1]."""
    hue, saturation, value = colorsys.rgb_to_hsv(*(float(channel) for channel in rgb))
    degrees = 360.0 * hue
    if value < 0.2 or (saturation < 0.3 and value < 0.25):
        return "black"
    if saturation < 0.12 or (saturation < 0.3 and value < 0.45):
        return "white" if value > 0.72 else "grey"
    if degrees < 14 or degrees >= 345:
        if saturation < 0.55:
            return "pink" if value > 0.65 else "brown"
        return "red" if value > 0.35 else "brown"
    if degrees < 68:
        if saturation < 0.42 and value > 0.66:
            return "beige"
        if degrees >= 42:
            return (
                "yellow"
                if saturation > 0.5 and value > 0.65
                else "green"
                if degrees > 56
                else "brown"
            )
        return "orange" if saturation > 0.72 and value > 0.72 else "brown"
    if degrees < 170:
        return "green"
    if degrees < 252:
        return "blue"
    if degrees < 292:
        return "purple"
    return "pink" if value > 0.6 else "purple"


def mean_colour(part: Part) -> NDArray[np.float64]:
    """(3,) red, green, blue in [0, 1] of a part; a texture counts by its mean."""
    colour = part.rgba[:3].astype(np.float64)
    if part.texture is not None:
        image = cv2.imread(str(part.texture))
        if image is not None:
            colour = colour * image.mean(axis=(0, 1))[::-1] / 255.0
    return np.asarray(np.clip(colour, 0.0, 1.0))


def _dominant(piece: Piece) -> tuple[str, ...]:
    shares: dict[str, float] = {}
    for part in piece.parts:
        corners = triangles([part])
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = float(np.linalg.norm(across, axis=1).sum())
        word = colour_word(mean_colour(part))
        shares[word] = shares.get(word, 0.0) + area * float(part.rgba[3])
    total = sum(shares.values())
    largest = sorted(shares.items(), key=lambda item: -item[1])[:2]
    ranked = [(word, share / total) for word, share in largest if share > 0]
    if ranked and ranked[0][1] >= ONE_COLOUR:
        return (ranked[0][0],)
    if len(ranked) == 2 and ranked[0][1] + ranked[1][1] >= TWO_COLOURS[0]:
        return (ranked[0][0], ranked[1][0]) if ranked[1][1] >= TWO_COLOURS[1] else ()
    return ()
