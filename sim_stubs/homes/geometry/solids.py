"""Triangle meshes of plain solids, of which procedural furniture and walls consist.

Sizes in metres, z up. Texture coordinates count repeats of the texture, which covers `tile` metres;
arguments of these functions go up the picture, those of a `Part` go down it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vizbot.core.geometry import transform
from vizbot.core.types import SE3

Surface = Path | Sequence[float]
"""A PNG file, or plain red, green, blue in [0, 1]."""
WHITE = (1.0, 1.0, 1.0)


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


def flat_panel(
    corner: ArrayLike,
    along: ArrayLike,
    up: ArrayLike,
    surface: Surface,
    tile: float = 1.0,
    cell: float = 0.5,
) -> Part:
    """A flat rectangle that is seen from the side that `along` x `up` points to.

    Args:
        corner: (3,) lower left corner.
        along: (3,) vector to the lower right corner.
        up: (3,) vector to the upper left corner.
        surface: Its surface.
        tile: Edge of the texture; 0 stretches one copy over the panel.
        cell: Longest edge of its triangles; light is computed at their corners.
    """
    origin, right, top = (np.asarray(v, np.float64) for v in (corner, along, up))
    width, height = float(np.linalg.norm(right)), float(np.linalg.norm(top))
    columns, rows = max(1, round(width / cell)), max(1, round(height / cell))
    s, t, faces = _unit_grid(rows, columns)
    vertices = origin + s * right + t * top
    scale = (1.0, 1.0) if tile == 0 else (width / tile, height / tile)
    normal = _cross(right, top) / (width * height)
    return _part(
        vertices,
        np.broadcast_to(normal, vertices.shape),
        np.hstack([s * scale[0], t * scale[1]]),
        faces,
        surface,
    )


def box(
    centre: ArrayLike, size: ArrayLike, surface: Surface, tile: float = 1.0, cell: float = 1.0
) -> Part:
    """An upright box; `centre` is the middle of its underside."""
    w, d, h = np.asarray(size, np.float64)
    x, y, z = np.asarray(centre, np.float64) - (w / 2, d / 2, 0.0)
    wx, dy, hz = (w, 0, 0), (0, d, 0), (0, 0, h)
    sides = (
        ((x, y, z), wx, hz),
        ((x + w, y, z), dy, hz),
        ((x + w, y + d, z), (-w, 0, 0), hz),
        ((x, y + d, z), (0, -d, 0), hz),
        ((x, y, z + h), wx, dy),
        ((x, y + d, z), wx, (0, -d, 0)),
    )
    return joined([flat_panel(a, b, c, surface, tile, cell) for a, b, c in sides])


def cylinder(
    centre: ArrayLike,
    radius: float,
    height: float,
    surface: Surface,
    top_radius: float | None = None,
    segments: int = 16,
) -> Part:
    """An upright cylinder or truncated cone; `centre` is the middle of its underside."""
    upper = radius if top_radius is None else top_radius
    profile = [(radius, 0.0), (upper, height)]
    slope = np.array([height, radius - upper]) / np.hypot(height, radius - upper)
    angles = np.linspace(0, 2 * np.pi, segments + 1)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    wall = np.concatenate([np.column_stack([ring * r, np.full(len(ring), z)]) for r, z in profile])
    normals = np.tile(np.column_stack([ring * slope[0], np.full(len(ring), slope[1])]), (2, 1))
    around = np.tile(angles * radius, 2)
    uv = np.column_stack([around, np.repeat([0.0, height], len(ring))])
    parts = [_part(wall, normals, uv, _grid_faces(1, segments), surface)]
    for (r, z), way in zip(profile, (-1.0, 1.0), strict=True):
        fan = np.array([(0, i, i + 1)[:: int(way)] for i in range(1, segments + 1)])
        cap = np.vstack([[0.0, 0.0, z], np.column_stack([ring * r, np.full(len(ring), z)])])
        parts.append(_part(cap, np.tile([0, 0, way], (len(cap), 1)), cap[:, :2], fan, surface))
    return moved_part(joined(parts), _shift(centre))


def cushion(
    centre: ArrayLike, size: ArrayLike, surface: Surface, roundness: float = 0.35, steps: int = 8
) -> Part:
    """A superquadric: a box with rounded edges (0.1), an ellipsoid (1.0).

    `centre` is the middle of its underside (Barr 1981, "Superquadrics and angle-preserving
    transformations").
    """
    half = np.asarray(size, np.float64) / 2
    v, u = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, steps + 1),
        np.linspace(-np.pi, np.pi, 2 * steps + 1),
        indexing="ij",
    )
    way = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=-1)
    factors = ((np.cos(v), np.cos(u)), (np.cos(v), np.sin(u)), (np.sin(v), np.ones_like(u)))

    def powers(exponent: float) -> NDArray[np.float64]:
        return np.stack([_power(a, exponent) * _power(b, exponent) for a, b in factors], axis=-1)

    vertices = powers(roundness).reshape(-1, 3) * half
    normals = (powers(2.0 - roundness) / half).reshape(-1, 3)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(lengths > 1e-6, normals / np.maximum(lengths, 1e-6), way.reshape(-1, 3))
    uv = np.column_stack([vertices[:, 0], vertices[:, 1] + vertices[:, 2]])
    rounded = _part(vertices, normals, uv, _grid_faces(steps, 2 * steps), surface)
    x, y, z = np.asarray(centre, np.float64)
    return moved_part(rounded, _shift((x, y, z + half[2])))


def meshed(
    vertices: NDArray[np.float64],
    normals: NDArray[np.float64],
    texcoords: NDArray[np.float64],
    shape: tuple[int, int],
    surface: Surface,
) -> Part:
    """A part over a grid of rows and columns of vertices, given row by row (R * C, 3)."""
    rows, columns = shape
    return _part(vertices, normals, texcoords, _grid_faces(rows - 1, columns - 1), surface)


def moved_part(part: Part, T_to_from: SE3) -> Part:
    """The part after a rigid motion."""
    return replace(
        part,
        vertices=transform(T_to_from, part.vertices).astype(np.float32),
        normals=(part.normals @ T_to_from[:3, :3].T).astype(np.float32),
    )


def stretched(parts: Iterable[Part], factors: ArrayLike) -> list[Part]:
    """Parts stretched by `factors` (3,) along x, y, z."""
    scale = np.asarray(factors, np.float64)
    result = []
    for part in parts:
        normals = part.normals / scale
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        result.append(
            replace(
                part,
                vertices=(part.vertices * scale).astype(np.float32),
                normals=normals.astype(np.float32),
            )
        )
    return result


def joined(parts: Sequence[Part]) -> Part:
    """Parts of one material as one."""
    starts = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    return replace(
        parts[0],
        vertices=np.concatenate([part.vertices for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        texcoords=np.concatenate([part.texcoords for part in parts]),
        faces=np.concatenate(
            [part.faces + np.int32(start) for part, start in zip(parts, starts, strict=True)]
        ),
    )


def by_material(parts: Sequence[Part]) -> tuple[Part, ...]:
    """One part for each material, in the order of first use."""
    groups: dict[tuple[Path | None, bytes], list[Part]] = {}
    for part in parts:
        groups.setdefault((part.texture, part.rgba.tobytes()), []).append(part)
    return tuple(joined(group) for group in groups.values())


def triangles(parts: Sequence[Part]) -> NDArray[np.float64]:
    """Corners (N, 3, 3) of every triangle."""
    corners = [part.vertices[part.faces] for part in parts]
    return np.concatenate(corners).astype(np.float64) if corners else np.zeros((0, 3, 3))


def _part(
    vertices: NDArray[np.float64],
    normals: NDArray[np.float64],
    texcoords: NDArray[np.float64],
    faces: NDArray[np.int64],
    surface: Surface,
) -> Part:
    texture = surface if isinstance(surface, Path) else None
    rgb = WHITE if isinstance(surface, Path) else surface
    return Part(
        vertices=vertices.astype(np.float32),
        normals=normals.astype(np.float32),
        texcoords=(texcoords * (1.0, -1.0)).astype(np.float32),
        faces=faces.astype(np.int32),
        rgba=np.array([*rgb, 1.0], np.float32),
        texture=texture,
    )


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cross product of two vectors (3,); NumPy's takes ten times as long for so few."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


@lru_cache(maxsize=256)
def _unit_grid(
    rows: int, columns: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Shares (N, 1) of the way right and up, 0 to 1, of a grid's vertices, and its faces.

    A home has many grids of few sizes.
    """
    s, t = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    return s.reshape(-1, 1), t.reshape(-1, 1), _grid_faces(rows, columns)


def _grid_faces(rows: int, columns: int) -> NDArray[np.int64]:
    """Two triangles for each cell of a grid of (rows + 1) x (columns + 1) vertices."""
    index = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = (
        i.ravel() for i in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1])
    )
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def _power(values: NDArray[np.float64], exponent: float) -> NDArray[np.float64]:
    """Signed power."""
    return np.sign(values) * np.abs(values) ** exponent


def _shift(offset: ArrayLike) -> SE3:
    T = np.eye(4)
    T[:3, 3] = offset
    return T
