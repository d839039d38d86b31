"""Conversion of a catalogue's model to the parts of a piece: metres, z up, few triangles, PNGs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from importlib.resources.abc import Traversable

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from sim_stubs.homes.furniture.decimation import decimated
from sim_stubs.homes.furniture.wavefront import Material, Surface, read_obj
from vizbot.core.errors import ConfigError

_INVISIBLE = 0.05
"""Opacity below which authors hide helper shapes rather than draw glass."""

_SAME_COLOUR = 0.06
"""Distance in RGBA within which plain surfaces become one part."""

_MAX_PLAIN_PARTS = 8
"""Each part is a mesh and a draw call of the world."""

_CREASE = float(np.cos(np.radians(40.0)))
"""Edges sharper than this are shaded as edges."""


_OPEN = 0.3
"""Openness from which a shape is drawn from both sides."""

_CLOSED = 0.001
"""Openness up to which a shape has an inside and an outside."""


@dataclass(frozen=True, slots=True, eq=False)
class ConvertedPart:
    """Triangles of one material, its texture not yet a file.

    Attributes:
        vertices: (V, 3) float32 [m], V >= 4.
        normals: (V, 3) float32 unit.
        texcoords: (V, 2) float32; u to the right, v down the image, from its top left corner.
        faces: (F, 3) int32, none of them degenerate.
        rgba: (4,) float32.
        png: The texture, encoded; None for plain `rgba`.
    """

    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    texcoords: NDArray[np.float32]
    faces: NDArray[np.int32]
    rgba: NDArray[np.float32]
    png: bytes | None


def convert(
    folder: Traversable,
    name: str,
    rotation: NDArray[np.float64],
    size: NDArray[np.float64],
    max_triangles: int,
    max_texture: int,
) -> tuple[ConvertedPart, ...]:
    """Parts of the model `name` in `folder`, standing on z = 0, its footprint around the origin.

    Args:
        folder: Holds the model, its materials and textures.
        name: The OBJ file: y up, front towards +z (Sweet Home 3D's convention).
        rotation: (3, 3) applied to the model first.
        size: (3,) extent along x, y, z [m] to stretch it to: z up, front towards -y.
        max_triangles: About how many are kept; sheets are then drawn from both sides.
        max_texture: Longest side of a texture [px].

    Raises:
        ConfigError: The model cannot be read, or nothing of it can be seen.
    """
    surfaces = _placed(read_obj(folder, name), rotation, size)
    return converted(surfaces, folder, name, max_triangles, max_texture)


def converted(
    surfaces: Iterable[Surface],
    folder: Traversable,
    name: str,
    max_triangles: int,
    max_texture: int,
) -> tuple[ConvertedPart, ...]:
    """Parts of the surfaces of the model `name`, in their frame [m].

    Other arguments and errors are those of `convert`.
    """
    surfaces = [surface for surface in surfaces if surface.material.rgba[3] >= _INVISIBLE]
    named = {surface.material.texture for surface in surfaces if surface.texcoords.any()} - {None}
    images = {
        name: png for name in named if (png := _png(_image(folder, named, name), max_texture))
    }
    drafts = [
        _part(surface, images.get(surface.material.texture))
        for surface in decimated(_merged(surfaces, images), max_triangles)
    ]
    parts = tuple(part for part in drafts if part is not None)
    if not parts:
        raise ConfigError(f"{name}: nothing of the model can be seen, take another one")
    return parts


def _placed(
    surfaces: Sequence[Surface], rotation: NDArray[np.float64], size: NDArray[np.float64]
) -> list[Surface]:
    """The surfaces in metres in the frame of the piece."""
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]) @ rotation
    turned = [surface.corners @ upright.T for surface in surfaces]
    low = np.min([corners.min(axis=(0, 1)) for corners in turned], axis=0)
    high = np.max([corners.max(axis=(0, 1)) for corners in turned], axis=0)
    scale = size / np.maximum(high - low, 1e-9)
    origin = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    return [
        replace(surface, corners=(corners - origin) * scale)
        for surface, corners in zip(surfaces, turned, strict=True)
    ]


def _merged(surfaces: Iterable[Surface], images: Mapping[str | None, bytes]) -> list[Surface]:
    """One surface for each texture, one for each distinguishable plain colour."""
    groups: dict[Material, list[Surface]] = {}
    # Large surfaces first: they give the colour, small ones join.
    for surface in sorted(surfaces, key=_area, reverse=True):
        groups.setdefault(_key(surface, images, list(groups)), []).append(surface)
    return [
        Surface(
            material,
            np.concatenate([member.corners for member in members]),
            np.concatenate([member.texcoords for member in members]),
        )
        for material, members in groups.items()
    ]


def _key(
    surface: Surface, images: Mapping[str | None, bytes], known: Sequence[Material]
) -> Material:
    """The material to draw `surface` with: its texture's, one of the `known`, or a new one."""
    material = surface.material
    if material.texture in images and surface.texcoords.any():
        return Material((1.0, 1.0, 1.0, material.rgba[3]), material.texture)
    plain = [other for other in known if other.texture is None]
    if plain:
        distances = [float(np.linalg.norm(np.subtract(p.rgba, material.rgba))) for p in plain]
        nearest = int(np.argmin(distances))
        if distances[nearest] < _SAME_COLOUR or len(plain) == _MAX_PLAIN_PARTS:
            return plain[nearest]
    return Material(material.rgba)


def _area(surface: Surface) -> float:
    return float(np.linalg.norm(_facing(surface.corners), axis=1).sum() / 2)


def _facing(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(F, 3) normals of triangles (F, 3, 3), twice as long as the triangle's area."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _part(surface: Surface, png: bytes | None) -> ConvertedPart | None:
    """Indexed triangles with normals; None when nothing but slivers is left."""
    corners, texcoords = _faced(surface.corners, surface.texcoords)
    solid = np.linalg.norm(_facing(corners), axis=1) > 1e-9
    corners, texcoords = corners[solid], texcoords[solid]
    if not len(corners):
        return None
    normals = _normals(corners)
    rows = np.concatenate([corners, normals, texcoords], axis=2)
    # What is open shows its inside too, and renderers draw the front of a triangle only.
    behind = rows[_openness(corners)[0] > _OPEN, ::-1] * ([1.0] * 3 + [-1.0] * 3 + [1.0] * 2)
    rows = np.concatenate([rows, behind]).reshape(-1, 8)
    _, first, inverse = np.unique(np.round(rows, 5), axis=0, return_index=True, return_inverse=True)
    if len(first) < 4:  # MuJoCo takes no mesh with fewer
        return None
    vertices = rows[first].astype(np.float32)
    return ConvertedPart(
        vertices=vertices[:, :3],
        normals=vertices[:, 3:6],
        texcoords=np.column_stack([vertices[:, 6], 1.0 - vertices[:, 7]]),
        faces=inverse.reshape(-1, 3).astype(np.int32),
        rgba=np.array(surface.material.rgba, np.float32).clip(0.0, 1.0),
        png=png,
    )


def _faced(
    corners: NDArray[np.float64], texcoords: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Both (F, 3, d) with closed shapes that were drawn inside out turned outward."""
    openness, volume = _openness(corners)
    inverted = ((openness < _CLOSED) & (volume < 0.0))[:, None, None]
    return (
        np.where(inverted, corners[:, ::-1], corners),
        np.where(inverted, texcoords[:, ::-1], texcoords),
    )


def _openness(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How open the connected shape of each triangle (F, 3, 3) is, and six times its volume.

    The area vectors of a closed shape sum to nothing (divergence theorem): (F,) length of the sum
    over the sum of lengths, 0 for a box, about 0.2 for one without lid, 1 for a sheet.
    """
    _, points = np.unique(np.round(corners.reshape(-1, 3), 5), axis=0, return_inverse=True)
    faces = points.reshape(-1, 3)
    links = coo_matrix((np.ones(len(points)), (faces.ravel(), np.roll(faces, 1, axis=1).ravel())))
    size = faces.max(initial=-1) + 1
    links.resize(size, size)
    _, shape_of_point = connected_components(links, directed=False)
    shape = shape_of_point[faces[:, 0]]
    facing = _facing(corners)
    sums = np.stack([np.bincount(shape, facing[:, axis]) for axis in range(3)], axis=1)
    areas = np.bincount(shape, np.linalg.norm(facing, axis=1))
    volumes = np.bincount(shape, (corners[:, 0] * facing).sum(axis=1))
    openness = np.linalg.norm(sums, axis=1) / np.maximum(areas, 1e-12)
    return openness[shape], volumes[shape]


def _normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(F, 3, 3) unit normals of the corners: smooth, except across creases."""
    facing = _facing(corners)
    _, inverse = np.unique(np.round(corners.reshape(-1, 3), 5), axis=0, return_inverse=True)
    sums = np.zeros((inverse.max(initial=-1) + 1, 3))
    np.add.at(sums, inverse.ravel(), np.repeat(facing, 3, axis=0))
    smooth = _unit(sums)[inverse].reshape(-1, 3, 3)
    flat = np.broadcast_to(_unit(facing)[:, None], smooth.shape)
    creased = (smooth * flat).sum(axis=-1, keepdims=True) < _CREASE
    return np.where(creased, flat, smooth)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))


def _image(folder: Traversable, named: Set[str | None], name: str | None) -> Traversable:
    """The file of texture `name`: where it is missing, the one image that no material names."""
    file = folder / str(name)
    if file.is_file():
        return file
    images = [
        other
        for other in folder.iterdir()
        if other.name.lower().endswith((".jpg", ".jpeg", ".png"))
    ]
    unnamed = [other for other in images if other.name not in named]
    return unnamed[0] if len(unnamed) == 1 else file


def _png(file: Traversable, max_side: int) -> bytes | None:
    """The image as an opaque PNG of at most `max_side` pixels a side; None if it is not one."""
    if not file.is_file():
        return None
    encoded = np.frombuffer(file.read_bytes(), np.uint8)
    image = cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED) if len(encoded) else None
    if image is None or image.dtype != np.uint8:
        return None
    if image.ndim == 2:
        image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    if image.shape[2] == 4:
        image = _opaque(image)
    shrink = max_side / max(image.shape[:2])
    if shrink < 1.0:
        width, height = (max(1, round(shrink * side)) for side in image.shape[1::-1])
        image = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    return bytes(cv2.imencode(".png", image)[1])


def _opaque(bgra: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(H, W, 3): transparent texels take the mean colour of the opaque ones."""
    alpha = bgra[..., 3:] / 255.0
    mean = (bgra[..., :3] * alpha).sum(axis=(0, 1)) / max(float(alpha.sum()), 1.0)
    return np.asarray(bgra[..., :3] * alpha + mean * (1.0 - alpha)).round().astype(np.uint8)
