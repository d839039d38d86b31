"""Varied furniture: other proportions and colours of the models that training homes have.

A class has a handful of training models, which the encoder would learn by heart. A varied piece
keeps its bounding box, and so its place in the home; its shape inside the box is shifted and
tapered, and some pieces are painted.
"""

from __future__ import annotations

import colorsys
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furniture.appearance import mean_colour
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.solids import Piece
from vizbot.core.home_vocabulary import COLOURS

SHAPED, PAINTED = 0.8, 0.35
"""Shares of the pieces that get other proportions, and other colours."""
SLOPE = 0.4
"""Standard deviation of how much thicker a slice of a piece becomes (as a logarithm)."""
TAPER = 0.12
"""Most by which the top of a piece is narrower, or its foot."""
SLICES = 5
"""Along each side of the bounding box."""
AS_THEY_ARE = ("aquarium", "computer", "door", "laptop", "mirror", "picture", "tv", "window")
"""Classes whose pictures, screens and panes keep their colours."""


def varied(house: House, rng: np.random.Generator) -> House:
    """The home with varied furniture."""
    instances = tuple(replace(it, piece=another(it.piece, rng)) for it in house.instances)
    return replace(house, instances=instances)


def another(piece: Piece, rng: np.random.Generator) -> Piece:
    """A piece of the same class and size, with other proportions or colours or both.

    A piece that is named by its colour, such as a "yellow chair", keeps it.
    """
    if rng.random() < SHAPED:
        piece = _shaped(piece, rng)
    if rng.random() < PAINTED and not keeps_colours(piece.label):
        piece = _painted(piece, rng)
    return piece


def keeps_colours(label: str) -> bool:
    """Whether pieces are never painted: those of `AS_THEY_ARE`, and a "yellow chair"."""
    return label in AS_THEY_ARE or label.split()[0] in COLOURS


def _shaped(piece: Piece, rng: np.random.Generator) -> Piece:
    corners = np.concatenate([part.vertices for part in piece.parts])
    low, high = corners.min(axis=0).astype(np.float64), corners.max(axis=0).astype(np.float64)
    knots = np.linspace(0.0, 1.0, SLICES + 1)
    heights = []
    for axis in range(3):
        thickness = np.exp(rng.normal(0.0, SLOPE, SLICES))
        if axis == 0:  # furniture is alike on its left and right
            thickness = thickness + thickness[::-1]
        heights.append(np.concatenate([[0.0], np.cumsum(thickness) / thickness.sum()]))
    taper = rng.uniform(-TAPER, TAPER, 2)

    def reshape(vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        share = (vertices - low) / np.maximum(high - low, 1e-6)
        share = np.column_stack([np.interp(share[:, i], knots, heights[i]) for i in range(3)])
        up = share[:, 2:]
        narrower = 1.0 - np.maximum(taper * (2.0 * up - 1.0), 0.0)
        share[:, :2] = 0.5 + (share[:, :2] - 0.5) * narrower
        return np.asarray(low + share * (high - low), np.float32)

    parts = tuple(replace(part, vertices=reshape(part.vertices)) for part in piece.parts)
    return replace(piece, parts=parts)


def _painted(piece: Piece, rng: np.random.Generator) -> Piece:
    """All parts turned by one hue, or each in a colour of its own; the name loses its material."""
    turn, bolder = rng.uniform(0.0, 1.0), rng.uniform(0.0, 0.3)
    every = rng.random() < 0.5
    parts = []
    for part in piece.parts:
        if every:
            hue, saturation, value = colorsys.rgb_to_hsv(*mean_colour(part))
            rgb = colorsys.hsv_to_rgb((hue + turn) % 1.0, min(1.0, saturation + bolder), value)
        elif rng.random() < 0.7:
            rgb = colorsys.hsv_to_rgb(rng.uniform(), rng.beta(1.0, 1.5), rng.uniform(0.15, 1.0))
        else:
            parts.append(part)
            continue
        rgba = np.array([*rgb, part.rgba[3]], np.float32)
        parts.append(replace(part, rgba=rgba, texture=None))
    return replace(piece, name=piece.label, parts=tuple(parts))
