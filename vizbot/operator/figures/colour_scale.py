"""How similar something is to the goal, as a colour that keeps its meaning during a search."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Step

_GREY, _PALE = 150, 0.15


def painted(heat: NDArray[np.floating]) -> NDArray[np.uint8]:
    """RGB (N, 3) of numbers (N,) from 0 to 1; low ones are pale, so that the others stand out."""
    levels = (255 * heat).astype(np.uint8)
    hues = cv2.applyColorMap(levels[:, None], cv2.COLORMAP_TURBO)[:, 0, ::-1]
    strength = np.maximum(heat, _PALE)[:, None]
    return np.asarray(strength * hues + (1.0 - strength) * 190.0, np.float64).astype(np.uint8)


class ColourScale:
    """A scale from half of the goal's first threshold to a little above it.

    What is best so far would be another scale in every step, and all colours would have to change.
    """

    def __init__(self) -> None:
        """Nothing is sought yet."""
        self._goal = ""
        self._threshold = 0.0

    def follow(self, step: Step) -> None:
        """Begin another scale with another goal."""
        if step.goal != self._goal:
            self._goal, self._threshold = step.goal, step.threshold

    def of(self, similarities: NDArray[np.float32]) -> NDArray[np.float64]:
        """From 0 to 1 (N,), and 0 while nothing is sought."""
        low, high = 0.5 * self._threshold, 1.1 * self._threshold
        if not self._goal or high <= low:
            return np.zeros(len(similarities))
        return np.clip((similarities - low) / (high - low), 0.0, 1.0)

    def colours(self, similarities: NDArray[np.float32]) -> NDArray[np.uint8]:
        """RGB (N, 3), grey while nothing is sought."""
        if not self._goal or len(similarities) == 0:
            return np.full((len(similarities), 3), _GREY, np.uint8)
        return painted(self.of(similarities))
