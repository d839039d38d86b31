"""A look from near by before the robot says that it has arrived.

An element lies at the mean of its patch's points (paper, equation 4). A patch that shows a door
frame and, through the door, a chair has its element between the two, in the doorway. Driving there
and stopping would be wrong, so the robot looks again: unless what is most similar in a frame taken
where it stopped is near by, that place counts no longer, and the search goes on. The paper has no
such step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.clip_mapper import ClipElements

NEARLY_BEST_HERE = 0.9
"""Share of the best similarity in the look from which an element counts as most similar, too."""
STILL_SIMILAR = 0.85
"""Share of the threshold that the look must reach: from close by less of a thing is in sight."""
NEARLY_BEST_ANYWHERE = 0.75
"""Share of the best similarity on the map that a look from near by must reach: what was better from
afar was something else."""


class Confirmation:
    """What has been looked at from near by while searching for one goal."""

    def __init__(self, near: float, radius: float) -> None:
        """Nothing has been refuted yet.

        Args:
            near: How far from the robot an element may be that confirms [m].
            radius: How far around a place one look tells that the goal is not there [m].
        """
        self._near = near
        self._radius = radius
        self._refuted_xy: list[NDArray[np.float64]] = []
        self._looking: tuple[int, float, NDArray[np.float64]] | None = None
        self._confirmed: int | None = None

    @property
    def confirmed(self) -> int | None:
        """Index of the most similar element near by that confirmed the goal; None before."""
        return self._confirmed

    @property
    def looking(self) -> bool:
        """Whether the robot stands and looks."""
        return self._looking is not None

    def believable(
        self, similarities: NDArray[np.float32], points: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """The similarities (N,) of elements at `points` (N, 3); -1 where a place was refuted."""
        if not self._refuted_xy:
            return similarities
        offsets = points[:, None, :2] - np.array(self._refuted_xy)
        refuted = (np.linalg.norm(offsets, axis=2) < self._radius).any(axis=1)
        return np.where(refuted, np.float32(-1.0), similarities)

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
        robot_xy: NDArray[np.float64],
    ) -> bool | None:
        """Whether the goal is here, once a frame has been embedded that tells.

        Args:
            elements: Of the CLIP map.
            similarities: (N,) of the elements to the goal.
            points: (N, 3) of the elements in `map` [m].
            robot_xy: (2,) where the robot stands, in `map` [m].

        Returns:
            None while no such frame has been embedded. False refutes the place.
        """
        if self._looking is None:
            return None
        first, threshold, place_xy = self._looking
        seen_here = elements.frames >= first
        if not seen_here.any():
            return None
        self._looking = None
        seen = similarities[seen_here]
        best_anywhere = float(self.believable(similarities, points).max())
        least = max(
            STILL_SIMILAR * threshold,
            NEARLY_BEST_HERE * float(seen.max()),
            NEARLY_BEST_ANYWHERE * best_anywhere,
        )
        near = np.linalg.norm(points[:, :2] - robot_xy, axis=1) <= self._near
        found = np.flatnonzero(seen_here & near & (similarities >= least))
        if len(found):
            self._confirmed = int(found[np.argmax(similarities[found])])
            return True
        self._refuted_xy.append(place_xy)
        return False
