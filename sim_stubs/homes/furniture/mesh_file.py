"""Triangles of mesh files by material: COLLADA (`.dae`), STL and Wavefront OBJ.

COLLADA's unit is applied and its up axis passed over, as Gazebo does. What moves with a skeleton is
not read.
"""

from __future__ import annotations

import io
import logging
import re
from pathlib import Path

import numpy as np

from sim_stubs.homes.furniture.wavefront import Material, Surface, read_obj
from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular
from vizbot.core.geometry import transform

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
    if suffix == ".obj":
        return read_obj(file.parent, file.name)
    try:
        content = read_regular(file, _LARGEST)
        surfaces = _collada(file, content) if suffix == ".dae" else _stl(content)
    except ModuleNotFoundError as missing:
        message = f"mesh {file} needs {missing.name}, not installed: pip install pycollada"
        raise ConfigError(message) from missing
    except Exception as error:  # whatever a library runs into in a file by anybody
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise ConfigError(f"mesh {file} cannot be read ({reason}); export it again") from error
    if not sum(len(surface.corners) for surface in surfaces):
        raise ConfigError(f"mesh {file} has no triangles; export it again")
    return surfaces


def _stl(content: bytes) -> tuple[Surface, ...]:
    (count,) = np.frombuffer(content, "<u4", 1, _STL_HEAD - 4)
    if len(content) == _STL_HEAD + count * _STL.itemsize:  # both kinds may begin with "solid"
        corners = np.frombuffer(content, _STL, count, _STL_HEAD)["corners"].astype(np.float64)
    else:
        words = [line.split()[1:] for line in re.findall(rb"vertex[^\n]+", content)]
        corners = np.array(words, np.float64).reshape(-1, 3, 3)
    return (Surface(Material(), corners, np.zeros((len(corners), 3, 2))),)


def _collada(file: Path, content: bytes) -> tuple[Surface, ...]:
    import collada

    # Many files refer to what is not in them, which is passed over.
    document = collada.Collada(io.BytesIO(content), ignore=[collada.common.DaeError])
    surfaces = []
    for geometry in document.scene.objects("geometry"):
        outward = -1 if np.linalg.det(geometry.matrix[:3, :3]) < 0 else 1
        # Not the shapes in their place: for these pycollada takes what NumPy warns of.
        for shape in geometry.original.primitives:
            if isinstance(shape, collada.polylist.Polylist):
                shape = shape.triangleset()
            if not isinstance(shape, collada.triangleset.TriangleSet) or not len(shape):
                continue
            points = transform(geometry.matrix, shape.vertex)
            corners = points[shape.vertex_index] * (document.assetInfo.unitmeter or 1.0)
            texcoords = np.zeros((len(shape), 3, 2))
            if shape.texcoordset:
                texcoords = shape.texcoordset[0][shape.texcoord_indexset[0]][..., :2]
            material = Material()
            if (bound := geometry.materialnodebysymbol.get(shape.material)) is not None:
                diffuse = bound.target.effect.diffuse
                if isinstance(diffuse, collada.material.Map):
                    material = _pictured(file, diffuse.sampler.surface.image.path)
                elif diffuse is not None:
                    red, green, blue = diffuse[:3]
                    material = Material((red, green, blue, 1.0))
            surfaces.append(Surface(material, corners[:, ::outward], texcoords[:, ::outward]))
    return tuple(surfaces)


def _pictured(file: Path, picture: str) -> Material:
    # Gazebo looks in the second place, too: authors have their pictures elsewhere on their disks.
    for texture in (picture, f"../materials/textures/{Path(picture).name}"):
        if (file.parent / texture).is_file():
            return Material((1.0, 1.0, 1.0, 1.0), texture)
    _log.warning("mesh %s: its picture %s is missing, grey stands for it", file, picture)
    return Material()
