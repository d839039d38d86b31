"""Small pictures of the frames of a run, and of the places in them that match a goal."""

from __future__ import annotations

import errno
import os
import weakref
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Candidate, GoalReport
from vizbot.operator.figures.image_encoding import jpeg

_WIDTH = 400
"""[px]"""
_WAITING = 100
"""Pictures that wait in memory for their embedding."""
_SEGMENT = 5000
"""Pictures in one file."""
_MOST = 6
"""Pictures for a goal."""
_GREEN = (30, 150, 60)
Image = NDArray[np.uint8]


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


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """One of the best places for a goal, as the camera saw it.

    Attributes:
        picture: JPEG, the place's patch in green.
        rank: From 1, as the answer lists them.
        score: Of the place, as people read it.
    """

    picture: bytes
    rank: int
    score: str


def matches(report: GoalReport, frame_store: FrameStore) -> list[Match]:
    """The pictures of the best places of an answer, where they were kept."""
    shown = []
    for rank, candidate in enumerate(report.candidates[:_MOST], 1):
        score = report.measure.text(candidate.score)
        picture = picture_of(candidate, score, frame_store)
        if picture is not None:
            shown.append(Match(picture, rank, score))
    return shown


def picture_of(candidate: Candidate, score: str, frame_store: FrameStore) -> bytes | None:
    """JPEG of a place with its patch in green; None for one of another run, or of long ago."""
    kept = frame_store.get(candidate.frame)
    if kept is None:
        return None
    picture, scale = kept
    _box(picture, candidate.box * scale, _GREEN, score)
    return jpeg(picture)


def _box(
    picture: Image, box: NDArray[np.floating], colour: tuple[int, int, int], text: str
) -> None:
    u0, v0, u1, v1 = (round(float(edge)) for edge in box)
    cv2.rectangle(picture, (u0, v0), (u1 - 1, v1 - 1), colour, 2)
    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.4
    (width, height), _ = cv2.getTextSize(text, font, size, 1)
    cv2.rectangle(picture, (u0, v0), (u0 + width + 4, v0 + height + 6), colour, -1)
    cv2.putText(picture, text, (u0 + 2, v0 + height + 3), font, size, (255,) * 3, 1, cv2.LINE_AA)
