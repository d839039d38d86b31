"""A piece of furniture as triangle meshes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Triangles of one material.

    Attributes:
        vertices: (V, 3) float32 [m], z up, in the frame of the piece.
        normals: (V, 3) float32 unit.
        texcoords: (V, 2) float32; to the right and down the picture, in repeats of it; zeros where
            there is no texture.
        faces: (F, 3) int32, counter-clockwise seen from outside.
        rgba: (4,) float32 in [0, 1].
        texture: PNG file, or None for plain `rgba`.
    """

    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    texcoords: NDArray[np.float32]
    faces: NDArray[np.int32]
    rgba: NDArray[np.float32]
    texture: Path | None


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """One model. Its origin is the centre of its footprint on the floor; its front faces -y.

    Attributes:
        label: The class it is an instance of ("chair").
        name: The model's own name in its catalogue.
        size: (3,) float64 extent along x, y, z [m].
        parts: One for each material.
        attribution: Author and licence; empty for procedural shapes.
        shape: Name of a procedural shape by the seed that drew it; painted or scaled, it stays the
            same. Empty for models, and where nobody named it.
    """

    label: str
    name: str
    size: NDArray[np.float64]
    parts: tuple[Part, ...]
    attribution: str
    shape: str = ""
