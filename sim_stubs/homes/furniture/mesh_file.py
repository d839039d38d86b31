"""Triangles of mesh files by material: COLLADA (`.dae`), STL and Wavefront OBJ.

COLLADA's up axis is passed over, as Gazebo does, and its unit is applied. What moves with a
skeleton is not read.
"""

from __future__ import annotations

import io
import logging
import re
from pathlib import Path
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furniture.wavefront import Material, Surface, read_obj
from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular

_LARGEST = 128 * 1024 * 1024
"""Size of a mesh file that is read [bytes]."""
_STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_STL_HEAD = 84
"""Bytes before the first triangle."""

_log = logging.getLogger(__name__)


def read_mesh(file: Path) -> tuple[Surface, ...]:
    """Surfaces of a mesh in metres; their textures are paths from its folder.

    Raises:
        ConfigError: The format is none of these, the file cannot be read, or it has no triangles.
    """
    suffix = file.suffix.lower()
    if suffix not in (".dae", ".stl", ".obj"):
        raise ConfigError(f"mesh {file} is no .dae, .stl or .obj; convert it to one of these")
    try:
        if suffix == ".obj":
            return read_obj(file.parent, file.name)
        content = read_regular(file, _LARGEST)
        surfaces = _collada(file, content) if suffix == ".dae" else _stl(content)
    except ConfigError:
        raise
    except Exception as error:  # whatever a library runs into in a file by anybody
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise ConfigError(f"mesh {file} cannot be read ({reason}); export it again") from error
    if not sum(len(surface.corners) for surface in surfaces):
        raise ConfigError(f"mesh {file} has no triangles; export it again")
    return surfaces


def _stl(content: bytes) -> tuple[Surface, ...]:
    (count,) = np.frombuffer(content, "<u4", 1, _STL_HEAD - 4)
    if len(content) == _STL_HEAD + count * _STL.itemsize:  # text may begin with "solid", too
        corners = np.frombuffer(content, _STL, count, _STL_HEAD)["corners"].astype(np.float64)
    else:
        words = [line.split()[1:] for line in re.findall(rb"vertex[^\n]+", content)]
        corners = np.array(words, np.float64).reshape(-1, 3, 3)
    return (Surface(Material(), corners, np.zeros((len(corners), 3, 2))),)


def _collada(file: Path, content: bytes) -> tuple[Surface, ...]:
    try:
        import collada
    except ModuleNotFoundError as missing:
        raise ConfigError(
            f"mesh {file} needs pycollada, not installed: pip install pycollada"
        ) from missing
    # Most files by others have a reference to nowhere, which is passed over.
    document = collada.Collada(io.BytesIO(content), ignore=[collada.common.DaeError])
    surfaces = []
    for geometry in document.scene.objects("geometry"):
        turn = int(np.sign(np.linalg.det(geometry.matrix[:3, :3]))) or 1
        for shape in geometry.primitives():
            if isinstance(shape, collada.polylist.BoundPolylist):
                shape = shape.triangleset()
            if not isinstance(shape, collada.triangleset.BoundTriangleSet) or not len(shape):
                continue
            texcoords = np.zeros((len(shape), 3, 2))
            if shape.texcoordset:
                texcoords = shape.texcoordset[0][shape.texcoord_indexset[0]][..., :2]
            corners = shape.vertex[shape.vertex_index] * (document.assetInfo.unitmeter or 1.0)
            effect = None if shape.material is None else shape.material.effect
            material = Material() if effect is None else _material(file, effect.diffuse)
            surfaces.append(Surface(material, corners[:, ::turn], texcoords[:, ::turn]))
    return tuple(surfaces)


def _material(file: Path, diffuse: object) -> Material:
    """The material with a diffuse colour of COLLADA: four numbers, a texture, or nothing."""
    import collada

    if isinstance(diffuse, collada.material.Map):
        named = unquote(diffuse.sampler.surface.image.path)
        # Gazebo looks there, too: authors have their pictures elsewhere on their disks.
        for texture in (named, f"../materials/textures/{Path(named).name}"):
            if (file.parent / texture).is_file():
                return Material((1.0, 1.0, 1.0, 1.0), texture)
        _log.warning("mesh %s: its picture %s is missing, a plain colour stands for it", file, named)
    if not isinstance(diffuse, (tuple, list, np.ndarray)):
        return Material()
    red, green, blue = (float(part) for part in diffuse[:3])
    return Material((red, green, blue, 1.0))
