"""Small pictures of the frames of a run, to show later what a patch was cut from."""

from __future__ import annotations

import errno
import os
import weakref
from pathlib import Path
from tempfile import TemporaryFile

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.operator.figures.image_encoding import jpeg

_WIDTH = 400
"""[px]"""
_WAITING = 100
"""Pictures that wait in memory for their embedding."""
_SEGMENT = 5000
"""Pictures in one file."""


class FrameStore:
    """Pictures by the number of their frame, in unnamed files that vanish with the program.

    An answer needs the picture of a frame whose patches are on the map, and of no other. An
    embedding takes time: the last 100 pictures wait in memory for theirs (some 2 MB) and are then
    kept or dropped, so a robot that stands and adds nothing to the map adds nothing here. At least
    the last 5000 pictures that were kept are there, and at most 10 000 are on the disk (some
    200 MB).

    Attributes:
        close: Frees the disk space.
    """

    def __init__(self, folder: Path) -> None:
        """Begin an empty store on the disk of `folder`."""
        self._folder = folder
        self._waiting: dict[int, tuple[bytes, float]] = {}
        self._segments: list[_Segment] = []
        self.close = weakref.finalize(self, _close, self._segments)

    def add(self, number: int, rgb: NDArray[np.uint8]) -> None:
        """Hold a frame's picture (H, W, 3) until its patches arrive."""
        scale = min(_WIDTH / rgb.shape[1], 1.0)
        small = cv2.resize(rgb, None, fx=scale, fy=scale)
        self._waiting[number] = jpeg(np.asarray(small, np.uint8)), scale
        if len(self._waiting) > _WAITING:
            del self._waiting[next(iter(self._waiting))]

    def keep(self, numbers: NDArray[np.int32]) -> None:
        """Keep the pictures of frames whose patches (N,) are new on the map.

        Raises:
            OSError: the disk is full.
        """
        for number in np.unique(numbers).tolist():
            if number in self._waiting:
                self._write(number, *self._waiting[number])
        newest = numbers.max(initial=-1)  # patches arrive in the order of their frames
        for number in [number for number in self._waiting if number <= newest]:
            del self._waiting[number]

    def get(self, number: int) -> tuple[NDArray[np.uint8], float] | None:
        """A frame's picture and its scale; None if it was not kept."""
        found = self._waiting.get(number)
        for segment in self._segments:
            found = found or segment.read(number)
        if found is None:
            return None
        encoded, scale = found
        bgr = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR)
        return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8), scale

    def clear(self) -> None:
        """Drop all pictures: another map numbers its frames anew."""
        self._waiting = {}
        _close(self._segments)

    def _write(self, number: int, encoded: bytes, scale: float) -> None:
        if not self._segments or len(self._segments[-1]) == _SEGMENT:
            _close(self._segments, keep=1)
            self._segments.append(_Segment(self._folder))
        self._segments[-1].write(number, encoded, scale)


class _Segment:
    """Pictures in one file."""

    def __init__(self, folder: Path) -> None:
        self._file = TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115
        self._extents: dict[int, tuple[int, int, float]] = {}
        self.close = self._file.close

    def __len__(self) -> int:
        return len(self._extents)

    def write(self, number: int, encoded: bytes, scale: float) -> None:
        begin = self._file.seek(0, os.SEEK_END)
        if self._file.write(encoded) < len(encoded):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._extents[number] = begin, len(encoded), scale

    def read(self, number: int) -> tuple[bytes, float] | None:
        if number not in self._extents:
            return None
        begin, length, scale = self._extents[number]
        self._file.seek(begin)
        return self._file.read(length), scale


def _close(segments: list[_Segment], keep: int = 0) -> None:
    """Close all but the newest ones."""
    while len(segments) > keep:
        segments.pop(0).close()
