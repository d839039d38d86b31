"""A file of arrays in the format of safetensors, written piece by piece.

The library's own writer copies all arrays into one block of bytes, twice, and lets no other thread
work meanwhile: with a large map the robot's loop would stand still.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

CODES = {"F32": np.float32, "F64": np.float64, "I32": np.int32, "U8": np.uint8, "U64": np.uint64}
"""Types of numbers by their names in the format."""
_NAMES = {np.dtype(kind): code for code, kind in CODES.items()}
_PIECE = 1 << 20
"""Bytes that are written at once."""


def size_of(arrays: Mapping[str, NDArray[Any]]) -> int:
    """Size of the file [bytes]."""
    return len(_head(arrays)) + sum(array.nbytes for array in arrays.values())


def write_through(path: Path, arrays: Mapping[str, NDArray[Any]]) -> str:
    """Write arrays to the disk; return the file's SHA-256.

    Raises:
        OSError: it cannot be written.
    """
    digest = hashlib.sha256()
    with path.open("wb") as file:
        for piece in _pieces(arrays):
            digest.update(piece)
            file.write(piece)
        file.flush()
        os.fsync(file.fileno())
    return digest.hexdigest()


def _pieces(arrays: Mapping[str, NDArray[Any]]) -> Iterator[bytes | memoryview]:
    yield _head(arrays)
    for name in _order(arrays):
        content = memoryview(np.ascontiguousarray(arrays[name]).reshape(-1).view(np.uint8).data)
        for start in range(0, content.nbytes, _PIECE):
            yield content[start : start + _PIECE]


def _order(arrays: Mapping[str, NDArray[Any]]) -> list[str]:
    """Names in the order of the file: wide numbers first, so that all of them are aligned."""
    return sorted(arrays, key=lambda name: (-arrays[name].itemsize, name))


def _head(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """What comes before the numbers: the length of the table, and the table of arrays."""
    table, end = {}, 0
    for name in _order(arrays):
        array, begin = arrays[name], end
        end += array.nbytes
        code, shape = _NAMES[array.dtype], list(array.shape)
        table[name] = {"dtype": code, "shape": shape, "data_offsets": [begin, end]}
    content = json.dumps(table, separators=(",", ":")).encode()
    content += b" " * (-len(content) % 8)
    return len(content).to_bytes(8, "little") + content
