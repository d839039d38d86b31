"""The score of a place, as a colour that keeps its meaning during a search."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Step

_GREY, _PALE = 150, 0.15


def painted(levels: NDArray[np.floating]) -> NDArray[np.uint8]:
    """RGB (N, 3) for levels (N,) from 0 to 1; low ones are pale, so that the others stand out."""
    indices = (255 * levels).astype(np.uint8)
    hues = cv2.applyColorMap(indices[:, None], cv2.COLORMAP_TURBO)[:, 0, ::-1]
    strength = np.maximum(levels, _PALE)[:, None]
    return np.asarray(strength * hues + (1.0 - strength) * 190.0, np.float64).astype(np.uint8)


class ColourScale:
    """A scale from half of the goal's first threshold to a little above it.

    A scale up to the best score so far would change all colours in every step.
    """

    def __init__(self) -> None:
        self._goal = ""
        self._threshold = 0.0

    def update(self, step: Step) -> None:
        """Change the scale where the goal has changed."""
        if step.goal != self._goal:
            self._goal, self._threshold = step.goal, step.threshold

    def levels(self, scores: NDArray[np.float32]) -> NDArray[np.float64]:
        """Levels (N,) from 0 to 1; all 0 without a goal."""
        low, high = 0.5 * self._threshold, 1.1 * self._threshold
        if not self._goal or high <= low:
            return np.zeros(len(scores))
        return np.clip((scores - low) / (high - low), 0.0, 1.0)

    def colours(self, scores: NDArray[np.float32]) -> NDArray[np.uint8]:
        """RGB (N, 3); grey without a goal."""
        if not self._goal or len(scores) == 0:
            return np.full((len(scores), 3), _GREY, np.uint8)
        return painted(self.levels(scores))
