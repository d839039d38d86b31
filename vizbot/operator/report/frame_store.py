"""The pictures of a run, small, for whoever wants to see later what a patch was cut from."""

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
_ROLL = 5000


class FrameStore:
    """Pictures by the number of their frame, in files without a name: they end with the program.

    An answer needs the picture of a frame whose patches are on the map, and of no other. An
    embedding takes time: the last 100 pictures wait in memory for theirs (some 2 MB) and are then
    kept or forgotten, so who stands and adds nothing to the map adds nothing here. At least the
    last 5000 that were kept can be had, and at most 10 000 are on the disk (some 200 MB).

    Attributes:
        close: Gives the space back.
    """

    def __init__(self, folder: Path) -> None:
        """Begin one on the disk of `folder`."""
        self._folder = folder
        self._waiting: dict[int, tuple[bytes, float]] = {}
        self._rolls: list[_Segment] = []
        self.close = weakref.finalize(self, _close, self._rolls)

    def add(self, number: int, rgb: NDArray[np.uint8]) -> None:
        """Have a frame's picture (H, W, 3) wait for its patches."""
        scale = min(_WIDTH / rgb.shape[1], 1.0)
        small = cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
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
        for roll in self._rolls:
            found = found or roll.read(number)
        if found is None:
            return None
        encoded, scale = found
        bgr = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR)
        return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8), scale

    def clear(self) -> None:
        """Forget all: another map numbers its frames anew."""
        self._waiting = {}
        _close(self._rolls)

    def _write(self, number: int, encoded: bytes, scale: float) -> None:
        if not self._rolls or len(self._rolls[-1]) == _ROLL:
            _close(self._rolls, but=1)
            self._rolls.append(_Segment(self._folder))
        self._rolls[-1].write(number, encoded, scale)


class _Segment:
    """So many pictures in one file."""

    def __init__(self, folder: Path) -> None:
        self._file = TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115
        self._places: dict[int, tuple[int, int, float]] = {}
        self.close = self._file.close

    def __len__(self) -> int:
        return len(self._places)

    def write(self, number: int, encoded: bytes, scale: float) -> None:
        begin = self._file.seek(0, os.SEEK_END)
        if self._file.write(encoded) < len(encoded):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._places[number] = begin, len(encoded), scale

    def read(self, number: int) -> tuple[bytes, float] | None:
        if number not in self._places:
            return None
        begin, length, scale = self._places[number]
        self._file.seek(begin)
        return self._file.read(length), scale


def _close(rolls: list[_Segment], but: int = 0) -> None:
    """All but so many of the newest."""
    while len(rolls) > but:
        rolls.pop(0).close()
