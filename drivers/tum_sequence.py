"""Recorded RGB-D sequences in the folder layout of the TUM RGB-D benchmark.

A folder holds `associations.txt` with lines `stamp rgb_file stamp depth_file`, or `rgb.txt` and
`depth.txt` with lines `stamp file`; depth is a 16-bit PNG registered to colour. Source: Sturm et
al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", IROS 2012, and its file formats page.
"""

from __future__ import annotations

import itertools
import struct
from codecs import BOM_UTF8
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from drivers.ros_bags import require_no_bag
from vizbot.core.camera_limits import (
    LATEST_STAMP,
    MOST_PIXELS,
    is_stamp,
    require_camera,
    require_depth_scale,
    without_saturated,
)
from vizbot.core.closeable import Closeable
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.settings import causes
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

MAX_STAMP_DIFFERENCE = 0.02
"""Largest difference of the stamps of colour and depth in a pair (the benchmark's default) [s]."""

MAX_PIXELS, MAX_HEADER = 1 << 26, 1 << 18
"""Most pixels of an image that is decoded, and most bytes before its size is said."""
MAX_BYTES = 1 << 28
"""Most bytes of an image or list."""

_FARTHEST_SHIFT = 0.25
"""Most by which a lens may shift a pixel, in longest edges of the image; a Kinect's has 0.06."""

_LAYOUT = "give a folder in TUM's layout, a .db3 or a .bag file"
_REMEDY = "write a camera.json (width, height, fx, fy, cx, cy, depth_scale) or give --intrinsics"


class _CameraFile(BaseModel):
    """`camera.json`; other keys are ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    width: int = Field(gt=0, le=MOST_PIXELS)
    height: int = Field(gt=0, le=MOST_PIXELS)
    fx: FiniteFloat = Field(gt=0)
    fy: FiniteFloat = Field(gt=0)
    cx: FiniteFloat
    cy: FiniteFloat
    depth_scale: FiniteFloat = Field(gt=0)
    no_depth: int = Field(default=0, ge=0, le=65535)
    """Value of a depth image that means that nothing was measured, besides 0 and 65535."""
    distortion: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] | None = None
    """k1, k2, p1, p2, k3 of the lens of both images, as OpenCV defines them; None for none."""

    @property
    def intrinsics(self) -> Intrinsics:
        return Intrinsics(self.width, self.height, self.fx, self.fy, self.cx, self.cy)


class _Pair(NamedTuple):
    stamp: float
    rgb: Path
    depth: Path


class RecordedSequence(Closeable):
    """A `Camera` that reads a folder, one pair of images for each `read`.

    Where `camera.json` tells of a lens, frames are free of its distortion: they have the same size
    and intrinsics, and are black and without depth where the picture as taken shows nothing.

    Args:
        folder: The sequence.
        intrinsics: Intrinsics instead of those in `camera.json`; width and height 0 stand for those
            of the first image.
        depth_scale: Units of the depth images per metre, with `intrinsics`.

    Raises:
        ConfigError: the folder, a file that it lists, or the calibration is missing, no camera has
            that calibration, or the first pair of images does not match it.
    """

    def __init__(
        self, folder: Path, intrinsics: Intrinsics | None = None, depth_scale: float | None = None
    ) -> None:
        require_no_bag(folder)
        if not folder.is_dir():
            raise ConfigError(f"sequence {folder}: no such folder; {_LAYOUT}")
        self._no_depth, distortion = 0, None
        if intrinsics is None or depth_scale is None:
            camera = _read_calibration(folder)
            intrinsics, depth_scale = camera.intrinsics, camera.depth_scale
            self._no_depth, distortion = camera.no_depth, camera.distortion
        self._folder = folder
        self._pairs = _read_pairs(folder)
        self._next = 0
        self._closed = False
        self._depth_scale = depth_scale
        if intrinsics.width == 0:
            height, width = _decode(self._pairs[0].rgb).shape[:2]
            f, c = (intrinsics.fx, intrinsics.fy), (intrinsics.cx, intrinsics.cy)
            intrinsics = Intrinsics(width, height, *f, *c)
        try:
            require_camera(intrinsics)
            require_depth_scale(depth_scale)
        except ValueError as error:
            raise ConfigError(f"sequence {folder}: {error}; {_REMEDY}") from error
        self._intrinsics = intrinsics
        self._sources: NDArray[np.float32] | None = None
        self._load(self._pairs[0])
        if distortion is not None:  # of images that have turned out to be of a camera's size
            self._sources = _sources(folder, intrinsics, distortion)

    @property
    def intrinsics(self) -> Intrinsics:
        """Of the colour image, to which depth is registered."""
        return self._intrinsics

    @property
    def stamps(self) -> NDArray[np.float64]:
        """Of all frames (F,), ascending [s]."""
        return np.array([pair.stamp for pair in self._pairs])

    def __len__(self) -> int:
        return len(self._pairs)

    def undistorted(self, u: int, v: int) -> tuple[int, int]:
        """Column and row in frames of what is at `u`, `v` in the picture as it was taken [px]."""
        if self._sources is None:
            return u, v
        away = ((self._sources - np.array((u, v), np.float32)) ** 2).sum(axis=2)
        row, column = divmod(int(away.argmin()), self._intrinsics.width)
        return column, row

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """Return the next frame, newer than any before; None at the end. Never waits.

        Raises:
            ConfigError: an image does not decode or is of the wrong size or type.
            DeviceError: the sequence is closed.
        """
        if self._closed:
            raise DeviceError(f"sequence {self._folder}: already closed; open it again")
        if self._next == len(self._pairs):
            return None
        self._next += 1
        return self.frame(self._next - 1)

    def frame(self, index: int) -> RGBDFrame:
        """Return one of `len(self)` frames, independent of `read`.

        Raises:
            ConfigError: an image does not decode or is of the wrong size or type.
        """
        return self._load(self._pairs[index])

    def close(self) -> None:
        """Refuse further reads; twice is fine."""
        self._closed = True

    def _load(self, pair: _Pair) -> RGBDFrame:
        bgr, raw = _decode(pair.rgb), _decode(pair.depth)
        if bgr.ndim == 2 and bgr.dtype == np.uint8:
            bgr = cv2.cvtColor(bgr, cv2.COLOR_GRAY2BGR)
        if bgr.ndim != 3 or bgr.shape[2] < 3 or bgr.dtype != np.uint8:
            raise ConfigError(f"image {pair.rgb}: not 8-bit colour; list colour before depth")
        if raw.ndim != 2 or raw.dtype != np.uint16:
            raise ConfigError(f"image {pair.depth}: not 16-bit depth; save depth as 16-bit PNG")
        size = self._intrinsics.width, self._intrinsics.height
        for path, image in ((pair.rgb, bgr), (pair.depth, raw)):
            if image.shape[1::-1] != size:
                found, wanted = "x".join(map(str, image.shape[1::-1])), "x".join(map(str, size))
                raise ConfigError(
                    f"image {path}: {found} pixels where the calibration says {wanted}; "
                    "give the calibration of these images, with depth registered to colour"
                )
        if self._sources is not None:
            bgr = cv2.remap(bgr, self._sources, None, cv2.INTER_LINEAR)
            raw = cv2.remap(raw, self._sources, None, cv2.INTER_NEAREST)
        rgb = np.ascontiguousarray(bgr[..., 2::-1], np.uint8)
        measured = without_saturated(raw.astype(np.uint16, copy=False)).astype(np.float32)
        measured[raw == self._no_depth] = 0.0
        depth = measured / np.float32(self._depth_scale)
        return RGBDFrame(pair.stamp, rgb, depth, self._intrinsics, ImuSamples.none())


def parse_intrinsics(text: str) -> tuple[Intrinsics, float]:
    """Intrinsics and depth scale [1/m] from `fx,fy,cx,cy,scale`.

    The text does not say how large the images are: width and height are 0, which stands for the
    size of the first image (see `RecordedSequence`).

    Raises:
        ConfigError: not five finite numbers, or a focal length or the scale is not positive.
    """
    try:
        fx, fy, cx, cy, scale = (float(part) for part in text.split(","))
    except ValueError:
        fx = fy = cx = cy = scale = np.nan
    if not np.isfinite([fx, fy, cx, cy, scale]).all() or min(fx, fy, scale) <= 0:
        raise ConfigError(
            f"intrinsics {text!r}: expected fx,fy,cx,cy,scale as in 525,525,319.5,239.5,5000"
        )
    return Intrinsics(0, 0, fx, fy, cx, cy), scale


def _read_calibration(folder: Path) -> _CameraFile:
    path = folder / "camera.json"
    if not path.is_file():
        raise ConfigError(f"sequence {folder}: no camera.json; {_REMEDY}")
    try:
        return _CameraFile.model_validate_json(_bytes(path, "calibration").removeprefix(BOM_UTF8))
    except ValidationError as error:
        first = causes(error.errors())[0]
        where = ".".join(map(str, first["loc"])) or "the file"
        raise ConfigError(
            f"{path}: {where}: {first['msg']}, not {str(first['input'])[:40]!r}; {_REMEDY}"
        ) from error


def _sources(
    folder: Path, camera: Intrinsics, distortion: tuple[float, ...]
) -> NDArray[np.float32]:
    """Column and row (H, W, 2) in the picture as taken of each pixel without distortion [px]."""
    size, lens = (camera.width, camera.height), np.array(distortion)
    columns, rows = cv2.initUndistortRectifyMap(camera.K, lens, None, camera.K, size, cv2.CV_32FC1)
    u, v = (np.arange(length, dtype=np.float32) for length in size)
    shift = float(np.maximum(np.abs(columns - u).max(), np.abs(rows - v[:, None]).max()))
    if not shift <= (most := _FARTHEST_SHIFT * max(size)):  # it may be NaN
        raise ConfigError(
            f"{folder / 'camera.json'}: distortion {list(distortion)} shifts a pixel by"
            f" {shift:.3g} px, a lens's by {most:g} at most; give k1, k2, p1, p2, k3 as OpenCV has"
            " them, or --intrinsics to read the images as they are"
        )
    return np.dstack((columns, rows))


def _read_pairs(folder: Path) -> list[_Pair]:
    """Pairs sorted by the stamp of colour; a repeated stamp is dropped."""
    both, rgb, depth = (folder / name for name in ("associations.txt", "rgb.txt", "depth.txt"))
    if both.is_file():
        pairs = [_Pair(float(row[0]), Path(row[1]), Path(row[3])) for row in _read_rows(both, 4)]
    elif rgb.is_file() and depth.is_file():
        pairs = _associate(_read_rows(rgb, 2), _read_rows(depth, 2))
    else:
        raise ConfigError(
            f"sequence {folder}: neither associations.txt nor rgb.txt and depth.txt in it; "
            "give a TUM-layout folder"
        )
    pairs = [_Pair(p.stamp, folder / p.rgb, folder / p.depth) for p in sorted(pairs)]
    pairs = [next(same) for _, same in itertools.groupby(pairs, key=lambda pair: pair.stamp)]
    if not pairs:
        raise ConfigError(f"sequence {folder}: no pair of colour and depth; check its lists")
    for pair in pairs:
        for path in (pair.rgb, pair.depth):
            if not _is_file(path):
                raise ConfigError(
                    f"image {str(path)[:200]}: listed but missing; copy the sequence again"
                )
    return pairs


def _read_rows(path: Path, columns: int) -> list[list[str]]:
    """Lines of a list, split, each with stamps in its even columns; comments start with `#`."""
    lines = _bytes(path, "list").decode("utf-8-sig", errors="replace").splitlines()
    rows = []
    for number, line in enumerate(lines, start=1):
        row = line.split()
        if not row or row[0].startswith("#"):
            continue
        if len(row) < columns or not all(_is_stamp(cell) for cell in row[0:columns:2]):
            raise ConfigError(
                f"{path}: line {number} is {line[:60]!r}; expected "
                + ("`stamp rgb_file stamp depth_file`" if columns == 4 else "`stamp file`")
                + f" with stamps of at most {LATEST_STAMP:g} s"
            )
        rows.append(row)
    return rows


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that is too long
        return False


def _is_stamp(text: str) -> bool:
    try:
        return is_stamp(float(text))
    except ValueError:
        return False


def _associate(rgb: list[list[str]], depth: list[list[str]]) -> list[_Pair]:
    """Pairs that are each other's nearest in time, within `MAX_STAMP_DIFFERENCE`."""
    if not rgb or not depth:
        return []
    rgb_stamps, depth_stamps = (np.array([float(r[0]) for r in rows]) for rows in (rgb, depth))
    to_depth = _nearest(depth_stamps, rgb_stamps)
    to_rgb = _nearest(rgb_stamps, depth_stamps)
    return [
        _Pair(float(rgb_stamps[i]), Path(rgb[i][1]), Path(depth[j][1]))
        for i, j in enumerate(to_depth)
        if to_rgb[j] == i and abs(rgb_stamps[i] - depth_stamps[j]) <= MAX_STAMP_DIFFERENCE
    ]


def _nearest(stamps: NDArray[np.float64], wanted: NDArray[np.float64]) -> NDArray[np.int64]:
    """Indices (N,) of the nearest of `stamps`, in any order, to each of `wanted` (N,)."""
    order = np.argsort(stamps, kind="stable")
    after = np.searchsorted(stamps[order], wanted).clip(0, len(stamps) - 1)
    before = (after - 1).clip(0)
    closer = np.abs(stamps[order[before]] - wanted) <= np.abs(stamps[order[after]] - wanted)
    return order[np.where(closer, before, after)]


def _bytes(path: Path, what: str) -> bytes:
    """The content of a file that is not too large for its kind."""
    try:
        size = path.stat().st_size
        if size <= MAX_BYTES:
            return path.read_bytes()
    except OSError as error:
        raise ConfigError(f"{what} {path}: {error.strerror}; copy the sequence again") from error
    raise ConfigError(f"{what} {path}: {size / 1e6:.0f} MB are too many; copy the sequence again")


def _decode(path: Path) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """Pixels as stored, colour in the order of OpenCV (BGR)."""
    encoded = np.frombuffer(_bytes(path, "image"), np.uint8)
    width, height = image_size(encoded[:MAX_HEADER].tobytes()) or (0, 0)
    if width * height > MAX_PIXELS:
        raise ConfigError(
            f"image {path}: {width}x{height} pixels are more than any camera's; copy it again"
        )
    image = cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED) if len(encoded) else None
    if image is None:
        raise ConfigError(f"image {path}: does not decode; copy it again")
    return np.asarray(image)


_PNG = b"\x89PNG\r\n\x1a\n"
_FRAMES = frozenset({*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC})
"""JPEG markers that begin a frame."""


def image_size(data: bytes) -> tuple[int, int] | None:
    """Width and height [px] that a PNG or JPEG says it has; None where it says nothing."""
    if data.startswith(_PNG) and len(data) >= 24:
        width, height = struct.unpack(">II", data[16:24])
        return width, height
    return _jpeg_size(data) if data.startswith(b"\xff\xd8") else None


def _jpeg_size(data: bytes) -> tuple[int, int] | None:
    place = 2
    while place + 9 <= len(data) and data[place] == 0xFF:
        marker = data[place + 1]
        if marker in _FRAMES:
            height, width = struct.unpack(">HH", data[place + 5 : place + 9])
            return width, height
        place += 2 + struct.unpack(">H", data[place + 2 : place + 4])[0]
    return None
