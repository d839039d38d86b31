"""What the CLIP map says about a goal, element by element."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapping.agreement import agreement
from vizbot.config import AgreementConfig

PLACES = 600
"""A map that is asked for its best places looks for agreement around so many elements."""

_TIE = 1e-3


def rank(
    points: NDArray[np.float64],
    similarities: NDArray[np.float32],
    keyframes: NDArray[np.int32],
    config: AgreementConfig,
) -> NDArray[np.float32]:
    """How well elements answer a question to the whole map, whatever the threshold.

    Args:
        points: (N, 3) in `map` [m].
        similarities: (N,) to the question.
        keyframes: (N,) ids of the elements' keyframes.
        config: How many views must agree.

    Returns:
        (N,) in essence what several keyframes agree on around the most similar elements; the
        similarity of the others, which rank behind them.
    """
    if len(points) == 0:
        return similarities
    chosen = np.argsort(-similarities, kind="stable")[:PLACES]
    floor = float(similarities[chosen[-1]])
    ranks = (1 + _TIE) * similarities
    # Elements above each other share what is agreed on: the most similar comes first.
    ranks[chosen] = _TIE * similarities[chosen] + agreement(
        points[chosen, :2], points[chosen], similarities[chosen], keyframes[chosen],
        floor=floor, radius=config.radius, views=config.views, falloff=config.falloff,
    )  # fmt: skip
    return ranks


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """The elements of the CLIP map, as far as they concern one goal.

    Attributes:
        points: (N, 3) in `map` [m].
        similarities: (N,) float32 to the goal.
        keyframes: (N,) ids of the keyframes they are anchored to.
        frames: (N,) index of the frame of each.
        seen_from: (N, 2) where the camera was, in `map` [m].
    """

    points: NDArray[np.float64]
    similarities: NDArray[np.float32]
    keyframes: NDArray[np.int32]
    frames: NDArray[np.int32]
    seen_from: NDArray[np.float64]

    def take(self, chosen: NDArray[np.bool_]) -> Sightings:
        """Those of a mask (N,)."""
        return Sightings(
            self.points[chosen],
            self.similarities[chosen],
            self.keyframes[chosen],
            self.frames[chosen],
            self.seen_from[chosen],
        )

    def by_position(self, spacing: float) -> Sightings:
        """The same, but what the camera saw while it was within `spacing` [m] is one keyframe."""
        positions = np.zeros(len(self.frames), np.int32)
        anchor, position = np.full(2, np.inf), -1
        for i in np.argsort(self.frames, kind="stable"):
            if not np.linalg.norm(self.seen_from[i] - anchor) <= spacing:
                anchor, position = self.seen_from[i], position + 1
            positions[i] = position
        return replace(self, keyframes=positions)

    def agreed(self, config: AgreementConfig, floor: float) -> NDArray[np.float32]:
        """(N,) what several keyframes agree on around each element.

        `floor` for an element that is itself no more similar (`mapping.agreement`).
        """
        agreed = np.full(len(self.similarities), floor, np.float32)
        above = np.flatnonzero(self.similarities > floor)
        agreed[above] = self.agreed_at(self.points[above, :2], config, floor)
        return agreed

    def agreed_at(
        self, at_xy: NDArray[np.float64], config: AgreementConfig, floor: float
    ) -> NDArray[np.float32]:
        """(M,) what several keyframes agree on around places (M, 2)."""
        return agreement(
            at_xy,
            self.points,
            self.similarities,
            self.keyframes,
            floor=floor,
            radius=config.radius,
            views=config.views,
            falloff=config.falloff,
        )
