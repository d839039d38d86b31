"""A look from near by before the robot says that it has arrived.

An element lies at the mean of its patch's points (paper, equation 4). A patch that shows a door
frame and, through the door, a chair has its element between the two, in the doorway. Driving there
and stopping would be wrong, so the robot looks again: unless a frame taken where it stopped holds
the goal too, the elements around that place count no longer, and the search goes on. The paper has
no such step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.clip_mapper import ClipElements


class Confirmation:
    """What has been looked at from near by while searching for one goal."""

    def __init__(self, radius: float) -> None:
        """Nothing has been refuted yet; `radius` [m] is how far around a place one look tells."""
        self._radius = radius
        self._refuted: set[int] = set()
        self._looking: tuple[int, float, NDArray[np.float64]] | None = None

    @property
    def looking(self) -> bool:
        """Whether the robot stands and looks."""
        return self._looking is not None

    def believable(self, similarities: NDArray[np.float32]) -> NDArray[np.float32]:
        """The similarities (N,), those of refuted elements at the least there is."""
        if not self._refuted:
            return similarities
        believable = similarities.copy()
        believable[list(self._refuted)] = -1.0
        return believable

    def begin(self, next_frame: int, threshold: float, place_xy: NDArray[np.float64]) -> None:
        """Look from here.

        Args:
            next_frame: Index of the first frame that counts.
            threshold: Similarity above which it holds the goal.
            place_xy: (2,) what the robot stopped for, in `map` [m].
        """
        self._looking = next_frame, threshold, place_xy

    def verdict(
        self,
        elements: ClipElements,
        similarities: NDArray[np.float32],
        points: NDArray[np.float64],
    ) -> bool | None:
        """Whether the goal is here, once a frame has been embedded that tells.

        Args:
            elements: Of the CLIP map.
            similarities: (N,) of the elements to the goal.
            points: (N, 3) of the elements in `map` [m].

        Returns:
            None while no such frame has been embedded. False refutes the elements around the
            place that were seen before.
        """
        if self._looking is None:
            return None
        first, threshold, place_xy = self._looking
        seen_here = elements.frames >= first
        if not seen_here.any():
            return None
        self._looking = None
        if similarities[seen_here].max() > threshold:
            return True
        near = np.linalg.norm(points[:, :2] - place_xy, axis=1) < self._radius
        self._refuted.update(np.flatnonzero(near & ~seen_here).tolist())
        return False
