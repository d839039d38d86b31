"""The pictures in which a goal was found, with a box around each patch that matched."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import GoalReport, Step
from vizbot.core.place_scores import UNSEEN
from vizbot.operator.figures.image_encoding import jpeg
from vizbot.operator.report.frame_store import FrameStore

_MOST = 6
"""Pictures for a goal."""
_FIRST, _OTHER = (30, 150, 60), (240, 150, 30)
Image = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """One of the best places for a goal, as the camera saw it.

    Attributes:
        picture: JPEG, the place's patch in green, others that matched in orange.
        rank: From 1, as the answer lists them.
        score: Of the place, as people read it.
        others: How many others matched in this picture.
    """

    picture: bytes
    rank: int
    score: str
    others: int


def matches(report: GoalReport, last: Step, frame_store: FrameStore) -> list[Match]:
    """The pictures of the best places of an answer, where they were kept.

    Args:
        report: The answer.
        last: The step before the answer. If it looked for the same goal, every patch above its
            threshold is boxed, too.
        frame_store: Pictures of the run on this map.
    """
    shown = []
    for rank, candidate in enumerate(report.candidates[:_MOST], 1):
        kept = frame_store.get(candidate.frame)
        if kept is None:
            continue  # a picture of another run, or of long ago
        picture, scale = kept
        here = last.frames == candidate.frame
        same = (last.boxes == candidate.box).all(axis=1)
        others = np.flatnonzero(here & ~same)
        scores = _scores(report, last, others)
        alike = scores > last.threshold
        for i, score in zip(others[alike], scores[alike], strict=True):
            _box(picture, last.boxes[i] * scale, _OTHER, report.measure.text(score))
        found = report.measure.text(candidate.score)
        _box(picture, candidate.box * scale, _FIRST, found)
        shown.append(Match(jpeg(picture), rank, found, int(np.count_nonzero(alike))))
    return shown


def _scores(report: GoalReport, last: Step, elements: NDArray[np.int64]) -> NDArray[np.float32]:
    """Scores of the places of some elements, for the goal of an answer."""
    if last.goal != report.text or last.scores is None:
        return np.full(len(elements), UNSEEN, np.float32)
    return last.scores.look_up(last.points[elements])


def _box(
    picture: Image, box: NDArray[np.floating], colour: tuple[int, int, int], text: str
) -> None:
    u0, v0, u1, v1 = (round(float(edge)) for edge in box)
    cv2.rectangle(picture, (u0, v0), (u1 - 1, v1 - 1), colour, 2)
    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.4
    (width, height), _ = cv2.getTextSize(text, font, size, 1)
    cv2.rectangle(picture, (u0, v0), (u0 + width + 4, v0 + height + 6), colour, -1)
    cv2.putText(picture, text, (u0 + 2, v0 + height + 3), font, size, (255,) * 3, 1, cv2.LINE_AA)
