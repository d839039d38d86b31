"""Wavefront OBJ and MTL: triangles by material.

Enough of the formats for furniture: polygons (cut into fans), texture coordinates, normals, diffuse
colour, opacity and diffuse texture. Lines, curves, smoothing groups and shader settings are passed
over. Source: Wavefront, "Object Files (.obj)" and "Material Library (.mtl)", Advanced Visualizer
manual, appendix B.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources.abc import Traversable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vizbot.core.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Material:
    """The material of a surface.

    Attributes:
        rgba: Diffuse colour and opacity, each in [0, 1].
        texture: File beside the model, or None.
    """

    rgba: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)
    texture: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles of one material, corner by corner.

    Attributes:
        material: Material of all triangles.
        corners: (F, 3, 3) float64 points, counter-clockwise seen from outside, in the file's units.
        texcoords: (F, 3, 2) float64, v upwards; zeros where the file has none.
    """

    material: Material
    corners: NDArray[np.float64]
    texcoords: NDArray[np.float64]


def read_obj(folder: Traversable, name: str) -> tuple[Surface, ...]:
    """Surfaces of the model `name` in `folder`, in the order in which the file names materials.

    Faces whose winding contradicts the normals of their corners are turned round.

    Raises:
        ConfigError: The file holds no triangles, or a line of it cannot be read.
    """
    try:
        lines = [line.split() for line in _text(folder / name).splitlines()]
        return _surfaces(folder, lines)
    except (ValueError, IndexError) as error:
        raise ConfigError(f"{name}: not a Wavefront model that can be read ({error})") from error


def read_mtl(file: Traversable) -> dict[str, Material]:
    """Materials by name; empty without such a file."""
    if not file.is_file():
        return {}
    materials: dict[str, Material] = {}
    name = ""
    for words in (line.split() for line in _text(file).splitlines()):
        match words:
            case ["newmtl", *rest]:
                name = " ".join(rest)
                materials[name] = Material()
            case ["Kd", red, green, blue, *_]:
                alpha = materials[name].rgba[3]
                rgba = (float(red), float(green), float(blue), alpha)
                materials[name] = Material(rgba, materials[name].texture)
            case ["d", *_, opacity]:
                rgba = (*materials[name].rgba[:3], float(opacity))
                materials[name] = Material(rgba, materials[name].texture)
            case ["map_Kd", *rest]:
                # Paths of the author's own disk are common; the file itself lies beside the model.
                texture = " ".join(rest).replace("\\", "/").rsplit("/", 1)[-1]
                materials[name] = Material(materials[name].rgba, texture)
    return materials


def _surfaces(folder: Traversable, lines: list[list[str]]) -> tuple[Surface, ...]:
    points = _numbers(lines, "v", 3)
    texcoords = _numbers(lines, "vt", 2)
    normals = _numbers(lines, "vn", 3)
    materials: dict[str, Material] = {}
    triangles: dict[str, list[list[str]]] = {}
    current = triangles.setdefault("", [])
    for words in lines:
        match words:
            case ["f", first, *rest]:
                current.extend([first, *pair] for pair in pairwise(rest))
            case ["usemtl", *rest]:
                current = triangles.setdefault(" ".join(rest), [])
            case ["mtllib", *rest]:
                materials |= read_mtl(folder / " ".join(rest))
    surfaces = []
    for name, faces in triangles.items():
        if not faces:
            continue
        indices = _indices(faces, (len(points), len(texcoords), len(normals)))
        corners = points[indices[..., 0]]
        outward = _looked_up(normals, indices[..., 2]).sum(axis=1)
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inverted = (facing * outward).sum(axis=1) < 0
        indices[inverted] = indices[inverted, ::-1]
        surfaces.append(
            Surface(
                materials.get(name, Material()),
                points[indices[..., 0]],
                _looked_up(texcoords, indices[..., 1]),
            )
        )
    if not surfaces:
        raise ValueError("no faces")
    return tuple(surfaces)


def _indices(faces: list[list[str]], counts: tuple[int, int, int]) -> NDArray[np.int64]:
    """(F, 3, 3) indices from 0 of point, texture coordinate and normal; -1 where there is none."""
    table = {corner: _corner(corner, counts) for face in faces for corner in face}
    return np.array([[table[corner] for corner in face] for face in faces], np.int64)


def _corner(corner: str, counts: tuple[int, int, int]) -> tuple[int, ...]:
    numbers = [int(field) if field else 0 for field in corner.split("/")]
    numbers += [0] * (3 - len(numbers))
    # Files count from 1, or backwards from the end with negative numbers.
    indices = tuple(
        number + count if number < 0 else number - 1
        for number, count in zip(numbers, counts, strict=True)
    )
    if indices[0] < 0 or any(index >= count for index, count in zip(indices, counts, strict=True)):
        raise IndexError(f"a face refers to {corner}")
    return indices


def _looked_up(rows: NDArray[np.float64], indices: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rows (N, d) at `indices` (F, 3) as (F, 3, d); zeros where the index is -1."""
    padded = np.vstack([rows, np.zeros((1, rows.shape[1]))])
    return padded[indices]


def _numbers(lines: list[list[str]], keyword: str, columns: int) -> NDArray[np.float64]:
    rows = [words[1 : 1 + columns] for words in lines if words and words[0] == keyword]
    return np.array(rows, np.float64).reshape(-1, columns)


def _text(file: Traversable) -> str:
    # Material names in the wild are in whatever encoding; this one reads every byte.
    return file.read_text(encoding="latin-1")
