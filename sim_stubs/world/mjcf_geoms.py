"""MuJoCo's primitive geoms as triangle meshes, in their own frames.

Source: MuJoCo documentation, "XML reference", body/geom (`type`, `size`) and asset/material
(`texrepeat`, `texuniform`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import (
    WHITE,
    Surface,
    box,
    cushion,
    cylinder,
    flat_panel,
    joined,
)

STEPS = 12
"""Number of faces of a round geom between its poles."""


@dataclass(frozen=True, slots=True, eq=False)
class GeomAppearance:
    """Appearance of a geom.

    Attributes:
        rgba: (4,) in [0, 1].
        texture: PNG file, or None.
        repeat: (2,) copies of the texture, over each face or over a metre.
        uniform: Whether `repeat` counts copies over a metre.
    """

    rgba: NDArray[np.float64]
    texture: Path | None = None
    repeat: tuple[float, float] = (1.0, 1.0)
    uniform: bool = False


def dressed(part: Part, look: GeomAppearance) -> Part:
    """The part in these colours."""
    texcoords = part.texcoords * np.asarray(look.repeat, np.float32)
    rgba = look.rgba.astype(np.float32)
    return replace(part, rgba=rgba, texture=look.texture, texcoords=texcoords)


def primitive(kind: str, size: NDArray[np.float64], look: GeomAppearance) -> Part | None:
    """A geom around its origin; None for a kind that is no primitive.

    Args:
        kind: "plane", "sphere", "capsule", "ellipsoid", "cylinder" or "box".
        size: (3,) as MuJoCo has it: half extents or radius and half length [m].
        look: Appearance of the geom.
    """
    shape = _shape(kind, size, WHITE, 1.0 if look.uniform else 0.0)
    return None if shape is None else dressed(shape, look)


def _shape(kind: str, size: NDArray[np.float64], white: Surface, tile: float) -> Part | None:
    a, b, c = (float(value) for value in size)
    match kind:
        case "plane":
            return flat_panel((-a, -b, 0.0), (2 * a, 0, 0), (0, 2 * b, 0), white, tile)
        case "box":
            return box((0.0, 0.0, -c), (2 * a, 2 * b, 2 * c), white, tile)
        case "cylinder":
            return cylinder((0.0, 0.0, -b), a, 2 * b, white, segments=2 * STEPS)
        case "sphere":
            return _ellipsoid(a, a, a, 0.0)
        case "ellipsoid":
            return _ellipsoid(a, b, c, 0.0)
        case "capsule":
            middle = cylinder((0.0, 0.0, -b), a, 2 * b, white, segments=2 * STEPS)
            return joined([middle, _ellipsoid(a, a, a, -b), _ellipsoid(a, a, a, b)])
    return None


def _ellipsoid(a: float, b: float, c: float, z: float) -> Part:
    """Half axes; z of its centre [m]."""
    return cushion((0.0, 0.0, z - c), (2 * a, 2 * b, 2 * c), WHITE, 1.0, STEPS)
