"""Evidence from near by before the robot says that it has arrived.

What was similar from across the room may be something else. On the way to it the robot sees it
again and again, and it stops and looks before it says anything: unless views from several positions
near by agree that it is there, what has been seen of the place until then counts no longer, and the
search goes on. The paper has no such step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.config import ConfirmationConfig
from vizbot.sightings import Sightings


class Confirmation:
    """What has been looked at from near by while searching for one goal."""

    def __init__(self, config: ConfirmationConfig) -> None:
        """Nothing has been refuted yet."""
        self._config = config
        self._refuted: list[tuple[NDArray[np.float64], int]] = []
        self._looking: tuple[int, float, NDArray[np.float64]] | None = None

    @property
    def looking(self) -> bool:
        """Whether the robot stands and looks."""
        return self._looking is not None

    def believable(self, sightings: Sightings) -> NDArray[np.float32]:
        """The similarities (N,), less what was refuted.

        -1 for what was seen of a refuted place before; what is seen of it later counts less with
        every time that it was refuted.
        """
        similarities = sightings.similarities
        for place_xy, frame in self._refuted:
            there = self._at(sightings, place_xy)
            doubted = np.where(
                sightings.frames < frame, np.float32(-1.0), similarities - self._config.doubt
            )
            similarities = np.where(there, doubted, similarities)
        return similarities

    def begin(self, next_frame: int, threshold: float, place_xy: NDArray[np.float64]) -> None:
        """Look from here.

        Args:
            next_frame: Index of the first frame that was taken standing.
            threshold: Similarity above which it is the goal.
            place_xy: (2,) what the robot stopped for, in `map` [m].
        """
        self._looking = next_frame, threshold, place_xy

    def verdict(self, sightings: Sightings, frame: int, floor_share: float) -> bool | None:
        """Whether the goal is here, once what is seen from here has been embedded.

        Args:
            sightings: Of the map, with believable similarities.
            frame: Index of the newest frame.
            floor_share: Share of the threshold that a view counts with that shows nothing better
                (`mapping.agreement`); it must lie below `share`, or every look confirms.

        Returns:
            None while nothing has been embedded. False refutes the place.
        """
        if self._looking is None:
            return None
        config = self._config
        first, threshold, place_xy = self._looking
        # Nothing is ever embedded of a view without depth.
        if not (sightings.frames >= first).any() and frame < first + config.patience:
            return None
        self._looking = None
        distances = np.linalg.norm(sightings.seen_from - place_xy, axis=1)
        near = sightings.take(distances <= config.near).by_position(config.spacing)
        [agreed] = near.agreed_at(place_xy[None], config.agreement, floor_share * threshold)
        if agreed < config.share * threshold:
            self._refuted.append((place_xy, frame + 1))
            return False
        return True

    def _at(self, sightings: Sightings, place_xy: NDArray[np.float64]) -> NDArray[np.bool_]:
        offsets = sightings.points[:, :2] - place_xy
        return np.asarray(np.linalg.norm(offsets, axis=1) <= self._config.agreement.radius)
