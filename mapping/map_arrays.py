"""`map.safetensors` of a saved map: what its arrays must be, and how they are read.

The table states every array's type, shape and range. Sizes are checked before anything is
allocated, contents before anything uses them: what comes from a file may be anything.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from mapping.clip.scores import LEAST_SPREAD
from mapping.map_segments import joined
from mapping.map_upgrade import ADDED, FORMER_SCHEMA, upgraded
from mapping.tensor_file import CODES
from vizbot.core.camera_limits import LATEST_STAMP, MOST_PIXELS
from vizbot.core.files import open_regular, parse_json

FARTHEST = 10_000.0
"""Farthest from the origin of its frame that anything is [m]."""
MOST_CELLS = 4096
"""Longest edge of the obstacle map, and of a square around it and all keyframes [cells]."""
MOST_PLACES = 1024
"""Longest edge of the part of the plan whose places were seen [places]."""
MOST_BYTES = 1 << 30
"""Largest file: some 16 000 steps of driving."""
GROWTH = 100_000_000
"""Room that a map needs where a robot goes on in it [bytes]: ten minutes or more of driving."""

_MOST_HEADER_BYTES = 1 << 20
_ROTATION_TOLERANCE = 1e-4
_UNIT_TOLERANCE = 0.01
_MOST = {"keyframe": 100_000, "dimension": 16_384, "row": MOST_CELLS, "col": MOST_CELLS}
_MOST_SPOTS = 1 << 24
_MOST_FRAMES = (1 << 31) - 1
_LEAST = {"dimension": 1, "row": 1, "col": 1}


@dataclass(frozen=True, slots=True)
class _Array:
    """What one array must be.

    Attributes:
        name: Group and column.
        dtype: Of the elements.
        shape: Lengths; a word stands for one length wherever it is used.
        low: Least value; None for any.
        high: Greatest value.
    """

    name: str
    dtype: DTypeLike
    shape: tuple[str | int, ...]
    low: float | None = None
    high: float | None = None


_TABLE = (
    _Array("keyframes.ids", np.int32, ("keyframe",), 0, _MOST["keyframe"]),
    _Array("keyframes.stamps", np.float64, ("keyframe",), -LATEST_STAMP, LATEST_STAMP),
    _Array("keyframes.Ts_map_cam", np.float64, ("keyframe", 4, 4), -FARTHEST, FARTHEST),
    _Array("views.pixels", np.float32, ("corner", 2), -1, MOST_PIXELS),
    _Array("views.descriptors", np.uint64, ("corner", 4)),
    _Array("views.points", np.float32, ("corner", 3), -FARTHEST, FARTHEST),
    _Array("views.keyframes", np.int32, ("corner",)),
    _Array("elements.embeddings", np.float32, ("element", "dimension"), -1.1, 1.1),
    _Array("elements.points_keyframe", np.float64, ("element", 3), -FARTHEST, FARTHEST),
    _Array("elements.keyframes", np.int32, ("element",)),
    _Array("elements.frames", np.int32, ("element",)),
    _Array("elements.boxes", np.int32, ("element", 4), 0, MOST_PIXELS),
    _Array("cloud.points_keyframe", np.float32, ("point", 3), -FARTHEST, FARTHEST),
    _Array("cloud.rgb", np.uint8, ("point", 3)),
    _Array("cloud.keyframes", np.int32, ("point",)),
    _Array("trajectory.stamps", np.float64, ("frame",), -LATEST_STAMP, LATEST_STAMP),
    _Array("trajectory.Ts_map_cam", np.float64, ("frame", 4, 4), -FARTHEST, FARTHEST),
    _Array("trajectory.keyframes", np.int32, ("frame",)),
    _Array("trajectory.Ts_keyframe_cam", np.float64, ("frame", 4, 4), -FARTHEST, FARTHEST),
    _Array("grid.occupancy", np.float32, ("row", "col"), 0, 1),
    _Array("elements.statistics", np.float32, ("statistic", 2), -1.1, 1.1),
    _Array("places.points_keyframe", np.float32, ("view", 3), -FARTHEST, FARTHEST),
    _Array("places.keyframes", np.int32, ("view",)),
    _Array("places.elements", np.int32, ("view", 3)),
    _Array("places.ranges", np.float32, ("view",), 0, 2 * FARTHEST),
    _Array("places.shares", np.float32, ("view",), 0, 1),
    _Array("places.spots", np.int32, ("view",), 0, _MOST_SPOTS),
    _Array("places.frames", np.int32, ("view",)),
    _Array("frames.numbers", np.int32, ("mapped",), 0, _MOST_FRAMES),
    _Array("frames.keyframes", np.int32, ("mapped",)),
    _Array("frames.Ts_keyframe_cam", np.float64, ("mapped", 4, 4), -FARTHEST, FARTHEST),
    _Array("frames.times", np.float64, ("mapped",), -LATEST_STAMP, LATEST_STAMP),
    _Array("elements.pictures", np.float32, ("picture", "dimension"), -1.1, 1.1),
)
_FORMER_TABLE = tuple(each for each in _TABLE if each.name not in (*ADDED, "places.frames"))


def _table(schema: int) -> tuple[_Array, ...]:
    """The arrays of a map of this schema."""
    return _FORMER_TABLE if schema == FORMER_SCHEMA else _TABLE


def read_arrays(
    files: Sequence[tuple[Path, int, str]], schema: int, created: datetime
) -> dict[str, NDArray[Any]]:
    """Read the arrays of a map and check each of them, and how they refer to one another.

    `files` are `map.safetensors` and the segments, each with the size [bytes] and SHA-256 that the
    map's header has of it, as it has its `schema` and when it was `created`.

    Raises:
        OSError: one cannot be read, is larger than any map, or is no regular file.
        ValueError: one is not of that size and checksum, or an array is not what it must be.
    """
    if sum(size for _, size, _ in files) > MOST_BYTES:
        raise ValueError(f"it has more than {MOST_BYTES} bytes")
    arrays = joined([_read_file(*file, schema) for file in files])
    if schema == FORMER_SCHEMA:
        arrays = upgraded(arrays, created)
    require_arrays(arrays)
    return arrays


def _read_file(path: Path, size: int, sha256: str, schema: int) -> dict[str, NDArray[Any]]:
    """The arrays of one file, whose content is not checked yet."""
    with open_regular(path, MOST_BYTES) as file:
        digest = hashlib.sha256()
        spans = _read_layout(file, size, digest, _table(schema))
        arrays = {array.name: _read(file, array, shape, digest) for array, shape in spans}
        if file.read(1) or digest.hexdigest() != sha256:
            raise ValueError(f"{path.name} has another checksum")
    return arrays


def read_array(path: Path, size: int, name: str, schema: int) -> NDArray[Any]:
    """Read one array of a map and check it by itself; the rest of the file is not read.

    `size` [bytes] and `schema` are those in the map's header; `name` is group and column.

    Raises:
        OSError: it cannot be read, is larger than any map, or is no regular file.
        ValueError: it is not of that size, or the array is not what it must be.
    """
    unused = hashlib.sha256()
    with open_regular(path, MOST_BYTES) as file:
        for array, shape in _read_layout(file, size, unused, _table(schema)):
            if array.name == name:
                content = _read(file, array, shape, unused)
                _require_range(array, content)
                return content
            file.seek(math.prod(shape) * np.dtype(array.dtype).itemsize, os.SEEK_CUR)
    raise ValueError(f"there is no {name}")


def require_arrays(arrays: Mapping[str, NDArray[Any]]) -> None:
    """Check each array of a map, by its name in the table, and how they refer to one another.

    Raises:
        ValueError: an array is not what it must be.
    """
    lengths: dict[str, int] = {}
    for array in _TABLE:
        content = arrays[array.name]
        if content.dtype != array.dtype:
            raise ValueError(f"{array.name} is of another type")
        _require_shape(array, content.shape, lengths)
        _require_range(array, content)
    for problem, holds in _relations(arrays):
        if not holds:
            raise ValueError(problem)


def require_extent(
    keyframe_poses: NDArray[np.float64],
    cells: tuple[int, ...],
    resolution: float,
    origin: tuple[float, float],
) -> None:
    """Reject an obstacle map that would have to grow beyond all measure to reach its keyframes.

    Args:
        keyframe_poses: Ts_map_cam (K, 4, 4).
        cells: Rows and columns of the obstacle map.
        resolution: Width of a cell [m].
        origin: x, y of the outer corner of cell [0, 0] in `map` [m].

    Raises:
        ValueError: they do not lie within one square of `MOST_CELLS` cells an edge.
    """
    corners = np.array([origin, np.add(origin, np.multiply(cells[::-1], resolution))])
    reached = np.concatenate([corners, keyframe_poses[:, :2, 3]])
    if np.ptp(reached, axis=0).max() > (MOST_CELLS + 0.5) * resolution:
        raise ValueError(f"grid and keyframes lie more than {MOST_CELLS} cells apart")


def require_places_extent(places: NDArray[np.int64]) -> None:
    """Reject places (R, 2) column, row that lie too far apart for a belief of all between them.

    Raises:
        ValueError: they do not lie within one square of `MOST_PLACES` an edge.
    """
    if len(places) and np.ptp(places, axis=0).max() >= MOST_PLACES:
        raise ValueError(f"places lie more than {MOST_PLACES} of them apart")


def is_rigid(Ts_a_b: NDArray[np.float64]) -> bool:
    """Whether all of (N, 4, 4) are rigid transforms, within rounding."""
    rotations = Ts_a_b[:, :3, :3]
    squares = np.einsum("nij,nkj->nik", rotations, rotations)
    return bool(
        np.abs(squares - np.eye(3)).max(initial=0.0) <= _ROTATION_TOLERANCE
        and (np.linalg.det(rotations) > 0.0).all()
        and (Ts_a_b[:, 3] == [0.0, 0.0, 0.0, 1.0]).all()
    )


def _read_layout(
    file: BufferedReader, size: int, digest: hashlib._Hash, table: Sequence[_Array]
) -> list[tuple[_Array, tuple[int, ...]]]:
    """The arrays with their shapes, in the order of the file; nothing of them is read."""
    if file.seek(0, 2) != size:
        raise ValueError(f"it has {file.tell()} bytes, not {size}")
    file.seek(0)
    prefix = file.read(8)
    length = int.from_bytes(prefix, "little")
    if len(prefix) < 8 or length > min(size - 8, _MOST_HEADER_BYTES):
        raise ValueError("its header is longer than it may be")
    content = file.read(length)
    digest.update(prefix + content)
    layout = parse_json(content)
    if not isinstance(layout, dict):
        raise ValueError("its header is not a table")
    layout.pop("__metadata__", None)
    if layout.keys() != {array.name for array in table}:
        raise ValueError("it holds other arrays than a map")
    lengths: dict[str, int] = {}
    spans = [(*_span(array, layout[array.name], lengths), array) for array in table]
    spans.sort(key=lambda span: span[:2])
    start = end = 8 + length
    for begin, shape, array in spans:
        if start + begin != end:
            raise ValueError(f"{array.name} does not follow the array before it")
        end += math.prod(shape) * np.dtype(array.dtype).itemsize
    if end != size:
        raise ValueError("its arrays are not as long as it")
    return [(array, shape) for _, shape, array in spans]


def _span(array: _Array, entry: Any, lengths: dict[str, int]) -> tuple[int, tuple[int, ...]]:
    """Where an array begins, and its shape; `lengths` collects what the words stand for."""
    match entry:
        case {"dtype": str(code), "shape": list(shape), "data_offsets": [int(begin), int(end)]}:
            pass
        case _:
            raise ValueError(f"{array.name} is not described")
    if CODES.get(code) is not array.dtype:
        raise ValueError(f"{array.name} is of another type")
    if any(type(n) is not int or n < 0 for n in shape):
        raise ValueError(f"{array.name} has another shape")
    _require_shape(array, tuple(shape), lengths)
    if begin < 0 or end - begin != math.prod(shape) * np.dtype(array.dtype).itemsize:
        raise ValueError(f"{array.name} has another size than its shape")
    return begin, tuple(shape)


def _require_shape(array: _Array, shape: tuple[int, ...], lengths: dict[str, int]) -> None:
    """Reject a shape; `lengths` collects what the words of the table stand for."""
    if len(shape) != len(array.shape):
        raise ValueError(f"{array.name} has another shape")
    for expected, found in zip(array.shape, shape, strict=True):
        if isinstance(expected, str):
            least, most = _LEAST.get(expected, 0), _MOST.get(expected, MOST_BYTES)
            if not least <= found <= most:
                raise ValueError(f"{array.name} has {found} {expected}s, not {least} to {most}")
            expected = lengths.setdefault(expected, found)
        if found != expected:
            raise ValueError(f"{array.name} has another shape")


def _read(
    file: BufferedReader, array: _Array, shape: tuple[int, ...], digest: hashlib._Hash
) -> NDArray[Any]:
    content = np.empty(shape, array.dtype)
    into = memoryview(content.reshape(-1).view(np.uint8).data)
    if file.readinto(into) != into.nbytes:
        raise ValueError("it has become shorter")
    digest.update(into)
    return content


def _require_range(array: _Array, content: NDArray[Any]) -> None:
    if array.low is None or array.high is None or content.size == 0:
        return
    low, high = content.min(), content.max()  # not a number where any is not one
    if not (array.low <= low and high <= array.high):
        raise ValueError(f"{array.name} is not within {array.low:g} to {array.high:g}")


def _relations(arrays: Mapping[str, NDArray[Any]]) -> Iterator[tuple[str, bool]]:
    """What must hold beyond each array's range, in an order in which each may rest on the last."""
    ids, stamps = arrays["keyframes.ids"], arrays["keyframes.stamps"]
    yield "keyframes.ids do not rise", bool((np.diff(ids) > 0).all())
    yield "frames.numbers do not rise", bool((np.diff(arrays["frames.numbers"]) > 0).all())
    rising = "keyframes.stamps", "trajectory.stamps", "views.keyframes", "frames.times"
    for name in (*rising, "places.frames"):
        yield f"{name} do not rise", bool((np.diff(arrays[name]) >= 0).all())
    for name in ("views", "elements", "cloud", "trajectory", "frames"):
        yield (
            f"{name}.keyframes refers to a keyframe that is not there",
            _are_among(arrays[f"{name}.keyframes"], ids),
        )
    online = "trajectory.Ts_map_cam", "trajectory.Ts_keyframe_cam"
    for name in ("keyframes.Ts_map_cam", *online, "frames.Ts_keyframe_cam"):
        yield f"{name} are not rigid transforms", is_rigid(arrays[name])
    frame_of, frame_stamps = arrays["trajectory.keyframes"], arrays["trajectory.stamps"]
    own = frame_stamps == stamps[np.searchsorted(ids, frame_of)]
    yield "a keyframe has no frame of its own", bool(np.isin(ids, frame_of[own]).all())
    boxes = arrays["elements.boxes"]
    for name in ("elements", "places"):
        known = np.isin(arrays[f"{name}.frames"], arrays["frames.numbers"])
        yield f"{name}.frames refers to a frame that is not there", bool(known.all())
    yield "elements.boxes are empty", bool((boxes[:, :2] < boxes[:, 2:]).all())
    for name in ("elements.embeddings", "elements.pictures"):
        norms = np.sqrt(np.einsum("nd,nd->n", arrays[name], arrays[name]))
        unit = (np.abs(norms - 1.0) <= _UNIT_TOLERANCE).all()
        yield f"{name} are not unit rows", bool(unit)
    statistics, elements = arrays["elements.statistics"], arrays["places.elements"]
    count = len(arrays["elements.keyframes"])
    yield "elements.statistics are not one for each element", len(statistics) in (0, count)
    yield "elements.statistics have no spread", bool((statistics[:, 1] >= LEAST_SPREAD).all())
    yield (
        "places.keyframes refers to a keyframe that is not there",
        _are_among(arrays["places.keyframes"], ids),
    )
    within = elements.min(initial=0) >= 0 and elements.max(initial=-1) < count
    yield "places.elements refers to an element that is not there", bool(within)


def _are_among(used: NDArray[np.int32], ids: NDArray[np.int32]) -> bool:
    """Whether all used ids are among these, which are 0 to the most keyframes."""
    known = np.zeros(_MOST["keyframe"] + 1, np.bool_)
    known[ids] = True
    within = used.min(initial=0) >= 0 and used.max(initial=0) < len(known)
    return bool(within and known[used].all())
