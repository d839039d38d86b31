"""Ways to spoil a saved map, drawn from a seed, and what may become of each."""

import hashlib
import json
import os
import random
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import fields
from pathlib import Path

import numpy as np
import safetensors.numpy

from mapping.clip.fitted.calibration import LIST_OF_VIEWS
from mapping.map_bundle import save
from tests.fuzz.trial import Allowed, Spoilt
from tests.helpers.bundles import GROUPS, bundle_of


def spoilt_maps(seed: int, flips: int) -> Iterator[Spoilt]:
    """All systematic ways, and `flips` bits of each kind."""
    rng = random.Random(seed)
    for _ in range(flips):
        yield _flip(rng, "map.json", Allowed.SAME)
        yield _flip(rng, "map.safetensors", Allowed.REFUSED)
        yield _flip(rng, "map.json", Allowed.ANY, checksums=True)
        yield _flip(rng, "map.safetensors", Allowed.ANY, checksums=True)
        yield _cut(rng.random(), rng.choice(("map.json", "map.safetensors")))
    yield from _wrong_arrays()
    yield from _wrong_layouts()
    yield from _wrong_headers()
    yield from _wrong_files()


def seal(folder: Path, **changes: object) -> None:
    """Make the checksums right, with these changes in `map.json`."""
    header, tensors = json.loads((folder / "map.json").read_bytes()), folder / "map.safetensors"
    header["tensors_size"] = tensors.stat().st_size
    header["tensors_sha256"] = hashlib.sha256(tensors.read_bytes()).hexdigest()
    del header["header_sha256"]
    header |= changes
    digest = hashlib.sha256(json.dumps(header, sort_keys=True).encode()).hexdigest()
    (folder / "map.json").write_text(json.dumps(header | {"header_sha256": digest}))


def _flip(rng: random.Random, file: str, allowed: Allowed, *, checksums: bool = False) -> Spoilt:
    place, bit = rng.random(), rng.randrange(8)

    def spoil(folder):
        content = bytearray((folder / file).read_bytes())
        content[int(place * len(content))] ^= 1 << bit
        (folder / file).write_bytes(content)
        if checksums:
            with suppress(ValueError, KeyError):  # it may be no JSON any more
                seal(folder)

    return Spoilt(f"bit {bit} at {place:.6f} of {file}, sealed {checksums}", allowed, spoil)


def _cut(share: float, file: str) -> Spoilt:
    def spoil(folder):
        os.truncate(folder / file, int(share * (folder / file).stat().st_size))

    return Spoilt(f"{file} cut at {share:.6f}", Allowed.REFUSED, spoil)


_VALID = {
    ("views.descriptors", "huge"),
    ("cloud.rgb", "huge"),
    ("views.points", "negative"),
    ("elements.points_keyframe", "negative"),
    ("cloud.points_keyframe", "negative"),
    ("elements.keyframes", "reversed"),
    ("elements.frames", "reversed"),
    ("cloud.keyframes", "reversed"),
    ("places.points_keyframe", "negative"),
    ("places.keyframes", "reversed"),
    ("places.ranges", "reversed"),
    ("places.shares", "reversed"),
    ("places.spots", "reversed"),
    ("frames.keyframes", "reversed"),
    ("elements.statistics", "empty"),
    ("elements.pictures", "empty"),
    ("elements.pictures", "shorter"),
    ("grid.occupancy", "shorter"),
    ("grid.occupancy", "wider"),
}
"""Changes that leave a valid map, of another home."""
_OTHER_WIDTH = {1: np.uint16, 4: np.float64, 8: np.float32}
_WRONG: dict[str, Callable] = {
    "of another type": lambda a: a.astype(np.int16),
    "of another width": lambda a: a.astype(_OTHER_WIDTH[a.itemsize]),
    "shorter": lambda a: a[:-1],
    "empty": lambda a: a[:0],
    "wider": lambda a: np.concatenate([a, a], axis=-1),
    "of five dimensions": lambda a: a.reshape(-1, 1, 1, 1, 1),
    "huge": lambda a: np.full_like(a, _greatest(a.dtype)),
    "negative": lambda a: None if a.dtype.kind == "u" else -np.abs(a) - 1,
    "reversed": lambda a: a[::-1] if a.ndim == 1 else None,
    "not a number": lambda a: _with_first(a, np.nan, len(a)),
    "not a number once": lambda a: _with_first(a, np.nan, 1),
    "infinite once": lambda a: _with_first(a, -np.inf, 1),
}
"""What is done to an array; None where that is not for its type."""


def _wrong_arrays() -> Iterator[Spoilt]:
    bundle = bundle_of(frames=9)
    arrays = {
        f"{group}.{column.name}": getattr(getattr(bundle, group), column.name)
        for group in GROUPS
        for column in fields(getattr(bundle, group))
    }
    arrays["grid.occupancy"] = bundle.grid.occupancy
    arrays["elements.statistics"] = bundle.statistics
    arrays["elements.pictures"] = bundle.pictures
    for name, array in arrays.items():
        for what, wrong in _WRONG.items():
            if wrong(array) is not None:
                allowed = Allowed.ANY if (name, what) in _VALID else Allowed.REFUSED
                yield Spoilt(f"{name} {what}", allowed, replacing(name, wrong))
        yield Spoilt(f"no {name}", Allowed.REFUSED, replacing(name, None))
    yield Spoilt("one array more", Allowed.REFUSED, replacing("more", lambda _: np.zeros(3)))


def _greatest(dtype):
    return np.finfo(dtype).max if dtype.kind == "f" else np.iinfo(dtype).max


def _with_first(array, value, count):
    if array.dtype.kind != "f":
        return None
    filled = array.copy()
    filled[:count] = value
    return filled


def replacing(name: str, wrong: Callable | None) -> Callable[[Path], object]:
    """What changes an array of a map, or with None removes it, and makes the checksums right."""

    def spoil(folder):
        file = folder / "map.safetensors"
        arrays = safetensors.numpy.load(file.read_bytes())
        before = arrays.pop(name, None)
        if wrong is not None:
            arrays[name] = np.ascontiguousarray(wrong(before))
        file.write_bytes(safetensors.numpy.save(arrays))
        seal(folder)

    return spoil


def _wrong_layouts() -> Iterator[Spoilt]:
    """A header of the arrays that lies about sizes and places."""
    entry = "elements.embeddings"
    for what, change in {
        "2^40 rows": {"shape": [2**40, 4]},
        "2^40 rows and bytes": {"shape": [2**40, 4], "data_offsets": [0, 2**44]},
        "2^62 rows twice": {"shape": [2**62, 2**62]},
        "a negative row": {"shape": [-1, -4]},
        "half a row": {"shape": [0.5, 4]},
        "true rows": {"shape": [True, 4]},
        "a begin of -8": {"data_offsets": [-8, 8]},
        "the end first": {"data_offsets": [64, 0]},
        "the place of others": {"data_offsets": [0, 16]},
        "three places": {"data_offsets": [0, 16, 32]},
        "no place": {"data_offsets": None},
        "no type": {"dtype": None},
        "a type of its own": {"dtype": "OBJECT"},
        "a list as type": {"dtype": ["F32"]},
    }.items():
        yield Spoilt(f"{entry} with {what}", Allowed.REFUSED, _relaid(entry, change))
    for what, head in {
        "deep": b"[" * 200_000,
        "no table": b"[]",
        "null": b"null",
        "not UTF-8": b"\xff" * 8,
        "empty": b"",
        "a table of lists": b'{"grid.occupancy": []}',
    }.items():
        yield Spoilt(f"a header of arrays that is {what}", Allowed.REFUSED, _headed(head))
    for length in (2**20 + 1, 2**40, 2**64 - 1):
        yield Spoilt(f"a header of {length} bytes", Allowed.REFUSED, _headed(b"{}", length))


def _relaid(name: str, change: dict) -> Callable[[Path], object]:
    def spoil(folder):
        content = (folder / "map.safetensors").read_bytes()
        length = int.from_bytes(content[:8], "little")
        layout = json.loads(content[8 : 8 + length])
        layout[name] |= change
        _write_headed(folder, json.dumps(layout).encode(), content[8 + length :])

    return spoil


def _headed(head: bytes, length: int | None = None) -> Callable[[Path], object]:
    return lambda folder: _write_headed(folder, head, b"\0" * 64, length)


def _write_headed(folder: Path, head: bytes, rest: bytes, length: int | None = None) -> None:
    prefix = (len(head) if length is None else length).to_bytes(8, "little")
    (folder / "map.safetensors").write_bytes(prefix + head + rest)
    seal(folder)


def _wrong_headers() -> Iterator[Spoilt]:
    """Values in `map.json` that no map has, with a right checksum."""
    eye = np.eye(4).tolist()
    shear = (np.eye(4) + np.eye(4, k=1)).tolist()
    mirror = np.diag([1.0, 1.0, -1.0, 1.0]).tolist()
    camera = {"width": 640, "height": 480, "fx": 600.0, "fy": 600.0, "cx": 320.0, "cy": 240.0}
    wrong: dict[str, list] = {
        "schema_version": [1, 2, 3, 4, 7, -3, "3x", None, [[3]], 10**400],
        "created": ["yesterday", None, 1e300, []],
        "model_id": ["", None, 5, "m" * 100_000, "\ud800"],
        "phrases_id": [5, [], "p" * 1000],
        "notice": [5, [], "n" * 100_000],
        "intrinsics": [None, [], {}]
        + [camera | {key: value} for key in camera for value in (None, 1e30, "wide", 10**400)]
        + [camera | {key: -1} for key in ("width", "height", "fx", "fy")],
        "T_base_cam": [None, [], eye[:3], shear, mirror, np.zeros((4, 4)).tolist()]
        + [[[*row[:3], value] for row in eye] for value in (1e9, 1e308, float("nan"))],
        "grid_resolution": [0, -0.05, 1e-300, 1e300, float("nan"), float("inf"), None, "wide"],
        "grid_origin": [[0], [0, 0, 0], [1e300, 0], [5e3, 0], [float("nan"), 0], None],
        "keep_out": [None, {}, [[]], [[[0, 0], [1, 1]]], [[[0, 0], [1, 1], [1e39, 0]]]],
        "counts": [{}, None, {"keyframes": -1}, {"keyframes": 3, "elements": 10**30}],
        "tensors_size": [0, -1, 2**62, None],
        "tensors_sha256": ["", None, "0" * 64],
        "calibration": [5, [], {}, {"views": LIST_OF_VIEWS}],
        "unknown": [1],
        "format": ["another", None, 7],
    }
    for key, values in wrong.items():
        for value in values:
            name = f"{key} = {repr(value)[:60]}"
            yield Spoilt(name, Allowed.REFUSED, lambda f, k=key, v=value: seal(f, **{k: v}))


def _wrong_files() -> Iterator[Spoilt]:
    """Things in the place of a file, or of the folder, that are not what they should be."""

    def instead(path: Path, make: Callable[[Path], object]) -> None:
        if path.is_dir():
            for file in path.iterdir():
                file.unlink()
            path.rmdir()
        else:
            path.unlink()
        make(path)

    def sparse(path: Path) -> None:
        path.touch()
        os.truncate(path, 40 << 30)

    things: dict[str, Callable[[Path], object]] = {
        "a pipe": os.mkfifo,
        "a link to /dev/zero": lambda path: path.symlink_to("/dev/zero"),
        "a link to /dev/stdin": lambda path: path.symlink_to("/dev/stdin"),
        "a link to itself": lambda path: path.symlink_to(path),
        "a link to nothing": lambda path: path.symlink_to(path.parent / "nothing"),
        "a folder": lambda path: path.mkdir(),
        "an empty file": lambda path: path.touch(),
        "a sparse file of 40 GB": sparse,
        "nothing": lambda path: None,
        "noise": lambda path: path.write_bytes(random.Random(1).randbytes(5000)),
        "100 000 open brackets": lambda path: path.write_bytes(b"[" * 100_000),
        "a million open tables": lambda path: path.write_bytes(b'{"a":' * 700_000),
        "UTF-16": lambda path: path.write_bytes('{"format": "vizbot map"}'.encode("utf-16")),
        "a long number": lambda path: path.write_bytes(b"9" * 100_000),
    }
    for what, make in things.items():
        for file in ("map.json", "map.safetensors", "."):
            yield Spoilt(
                f"{what} for {file}", Allowed.REFUSED, lambda f, p=file, m=make: instead(f / p, m)
            )

    def exchange(folder: Path, file: str) -> None:
        other = folder.with_name("other")
        save(bundle_of(seed=99, frames=9, model_id="mean-colours"), other)
        (other / file).replace(folder / file)

    def swap(folder: Path) -> None:
        (folder / "map.json").rename(folder / "swap")
        (folder / "map.safetensors").rename(folder / "map.json")
        (folder / "swap").rename(folder / "map.safetensors")

    yield Spoilt("the files' names exchanged", Allowed.REFUSED, swap)
    for file in ("map.json", "map.safetensors"):
        yield Spoilt(f"{file} of another map", Allowed.REFUSED, lambda f, n=file: exchange(f, n))
    deep = "[" * 900 + "]" * 900
    yield Spoilt(
        "a header with a deep list",
        Allowed.REFUSED,
        lambda folder: (folder / "map.json").write_text(
            '{"format": "vizbot map", "schema_version": ' + deep + "}"
        ),
    )
