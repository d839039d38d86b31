"""The pictures in which a goal was found, with a box around the patch that shows it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Candidate, GoalReport
from vizbot.operator.figures.image_encoding import jpeg
from vizbot.operator.report.frame_store import FrameStore

_MOST = 6
"""Pictures for a goal."""
_GREEN = (30, 150, 60)
Image = NDArray[np.uint8]


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
