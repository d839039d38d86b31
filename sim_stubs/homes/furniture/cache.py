"""Converted furniture on disk, under `$XDG_CACHE_HOME/vizbot/furniture` (default `~/.cache`).

One `.npz` for each piece with its parts one after another, and its textures as PNG files named by
their content. Every file is renamed into place whole, arrays last, so that programs that run side
by side can share the folder. A file that is torn all the same counts as missing.
"""

from __future__ import annotations

import io
import logging
import tempfile
import zipfile
import zlib
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sim_stubs.homes.geometry.solids import Part
from vizbot.core.errors import ConfigError
from vizbot.core.files import user_folder

if TYPE_CHECKING:
    from sim_stubs.homes.furniture.conversion import ConvertedPart

_VERSION = "v1"
"""Version of the conversion and of the layout of the files."""

_log = logging.getLogger(__name__)


def load_parts(key: str) -> tuple[Part, ...] | None:
    """The parts stored as `key`; None when they are not there, or torn."""
    path = _path(key)
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            stored = {name: arrays[name] for name in arrays.files}
        vertex_ends = stored["vertex_counts"].cumsum()[:-1]
        columns = zip(
            np.split(stored["vertices"], vertex_ends),
            np.split(stored["normals"], vertex_ends),
            np.split(stored["texcoords"], vertex_ends),
            np.split(stored["faces"], stored["face_counts"].cumsum()[:-1]),
            stored["rgba"],
            (_texture(path.parent, str(name)) for name in stored["textures"]),
            strict=True,
        )
        return tuple(Part(*column) for column in columns)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        _log.warning("cached furniture %s is torn, converting it again (%s)", path, error)
        return None


def store_parts(key: str, parts: Sequence[ConvertedPart]) -> tuple[Part, ...]:
    """Store `parts` as `key` and return them with their textures as files.

    Raises:
        ConfigError: The folder cannot be written.
    """
    path = _path(key)
    names = [f"{sha256(part.png).hexdigest()[:32]}.png" if part.png else "" for part in parts]
    arrays = io.BytesIO()
    np.savez(
        arrays,
        vertices=np.concatenate([part.vertices for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        texcoords=np.concatenate([part.texcoords for part in parts]),
        faces=np.concatenate([part.faces for part in parts]),
        rgba=np.stack([part.rgba for part in parts]),
        vertex_counts=np.array([len(part.vertices) for part in parts]),
        face_counts=np.array([len(part.faces) for part in parts]),
        textures=np.array(names),
    )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for name, part in zip(names, parts, strict=True):
            if part.png:
                _write(path.parent / name, part.png)
        _write(path, arrays.getvalue())
    except OSError as error:
        raise ConfigError(
            f"furniture cache {path.parent} cannot be written ({error.strerror}): "
            "set XDG_CACHE_HOME to a folder that can"
        ) from error
    return tuple(
        Part(
            part.vertices,
            part.normals,
            part.texcoords,
            part.faces,
            part.rgba,
            path.parent / name if name else None,
        )
        for name, part in zip(names, parts, strict=True)
    )


def _path(key: str) -> Path:
    cache = user_folder("XDG_CACHE_HOME", ".cache") / "furniture" / _VERSION
    return cache / f"{sha256(key.encode()).hexdigest()[:32]}.npz"


def _texture(folder: Path, name: str) -> Path | None:
    if not name:
        return None
    path = folder / name
    if not path.is_file() or not name.startswith(sha256(path.read_bytes()).hexdigest()[:32]):
        raise ValueError(f"texture {name} is missing or torn")
    return path


def _write(path: Path, content: bytes) -> None:
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".draft-", delete=False) as draft:
        draft.write(content)
    Path(draft.name).replace(path)
