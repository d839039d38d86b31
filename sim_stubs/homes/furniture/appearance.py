"""Appearance of a piece of furniture in words, for captions: its colours and material."""

from __future__ import annotations

import colorsys
import re
from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_stubs.homes.geometry.solids import Part, Piece, triangles

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
"""Materials, and the words for them in the names of models."""

ONE_COLOUR = 0.6
"""A colour with this share of the surface is the colour of the piece."""
TWO_COLOURS = (0.85, 0.3)
"""Least share of two colours together, and of the lesser one, to be named both."""
TRACE = 0.08
"""Share from which a colour may be seen from some viewpoint."""


VIEWS = ((0.0, 20.0), (40.0, 30.0), (-40.0, 30.0), (90.0, 10.0), (-90.0, 10.0))
"""Views of a piece: yaw and pitch that it is turned by [degrees]."""
POINTS, PIXELS = 8000, 28
"""Points of its surface, and pixels along its longest side."""


@dataclass(frozen=True, slots=True)
class Appearance:
    """Colour and material.

    Attributes:
        colours: The common words for its colours, the largest surface first; two at most, none
            where no colour names it.
        material: One of `MATERIALS`; None when it is not known.
        traces: The words for all colours that a part of it has, named or not.
    """

    colours: tuple[str, ...]
    material: str | None
    traces: tuple[str, ...] = ()


def appearance(piece: Piece) -> Appearance:
    """The words for the looks of `piece`; its material is in its name."""
    names = re.findall(r"\w+", piece.name.lower())
    materials = (
        material
        for material, words in MATERIALS.items()
        if any(re.fullmatch(words, name) for name in names)
    )
    shares = _colours(piece)
    traces = tuple(word for word, share in shares.items() if share >= TRACE)
    return Appearance(_dominant(shares), next(materials, None), traces)


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


def _colours(piece: Piece) -> dict[str, float]:
    """Share of each word for a colour in what is seen of a piece."""
    shares: dict[str, float] = {}
    for part, share in zip(piece.parts, visible_shares(piece), strict=True):
        word = colour_word(mean_colour(part))
        shares[word] = shares.get(word, 0.0) + float(share)
    return shares


def _dominant(shares: Mapping[str, float]) -> tuple[str, ...]:
    """The names of a piece's colour, by the shares of colours."""
    largest = sorted(shares.items(), key=lambda item: -item[1])[:2]
    (first, most), (second, less) = (*largest, ("", 0.0))[:2]
    if most >= ONE_COLOUR:
        return (first,)
    return (first, second) if most + less >= TWO_COLOURS[0] and less >= TWO_COLOURS[1] else ()


def visible_shares(piece: Piece) -> NDArray[np.float64]:
    """Share (parts,) of each part in what is seen of a piece from its front, sides and above.

    Points of the surface are thrown onto a coarse picture for each way of looking, where the
    nearest one wins. What lies behind clear glass is seen through it.
    """
    rng = np.random.default_rng(0)
    corners = triangles(piece.parts)
    of_part = np.repeat(np.arange(len(piece.parts)), [len(part.faces) for part in piece.parts])
    clear = np.array([part.rgba[3] < 0.5 for part in piece.parts])[of_part]
    if not clear.all():
        corners, of_part = corners[~clear], of_part[~clear]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(across, axis=1)
    chosen = rng.choice(len(areas), POINTS, p=areas / areas.sum())
    u, v = np.sqrt(rng.random(POINTS)), rng.random(POINTS)
    weights = np.column_stack([1 - u, u * (1 - v), u * v])
    points = np.einsum("nij,ni->nj", corners[chosen], weights)
    seen = np.zeros(len(piece.parts))
    for yaw, pitch in VIEWS:
        view = Rotation.from_euler("zx", [yaw, pitch], degrees=True).apply(points)
        pixel = np.floor(view[:, [0, 2]] / piece.size.max() * PIXELS).astype(np.int64)
        order = np.lexsort((view[:, 1], pixel[:, 1], pixel[:, 0]))
        first = np.ones(POINTS, bool)
        first[1:] = (np.diff(pixel[order], axis=0) != 0).any(axis=1)
        seen += np.bincount(of_part[chosen[order[first]]], minlength=len(seen))
    return np.asarray(seen / seen.sum())
