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

from vizbot.operator.encoded import jpeg

_WIDTH = 400
"""[px]"""


class Album:
    """Pictures by the number of their frame, in a file without a name: it ends with the program.

    Attributes:
        close: Gives the space back.
    """

    def __init__(self, folder: Path) -> None:
        """Begin one on the disk of `folder`."""
        self._file = TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115
        self.close = weakref.finalize(self, self._file.close)
        self._places: dict[int, tuple[int, int, float]] = {}

    def add(self, number: int, rgb: NDArray[np.uint8]) -> None:
        """Keep a frame's picture (H, W, 3).

        Raises:
            OSError: the disk is full.
        """
        scale = min(_WIDTH / rgb.shape[1], 1.0)
        small = cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        encoded = jpeg(np.asarray(small, np.uint8))
        begin = self._file.seek(0, os.SEEK_END)
        if self._file.write(encoded) < len(encoded):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._places[number] = begin, len(encoded), scale

    def get(self, number: int) -> tuple[NDArray[np.uint8], float] | None:
        """A frame's picture and its scale; None if it was not kept."""
        if number not in self._places:
            return None
        begin, length, scale = self._places[number]
        self._file.seek(begin)
        bgr = cv2.imdecode(np.frombuffer(self._file.read(length), np.uint8), cv2.IMREAD_COLOR)
        return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8), scale
