"""Elements of the CLIP map with their similarities to one goal."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapping.clip.placement import halvings
from mapping.clip.retrieval import best
from mapping.clip.view_agreement import AgreementRule, agreed_similarities
from mapping.map_bundle import MapBundle
from vizbot.config import AgreementConfig

CANDIDATES = 5
"""A question to the whole map has at most this number of answers."""
CANDIDATE_SPACING = 0.8
"""Answers are at least this far apart [m]."""
RANKED = 600
"""Agreement is computed around this number of most similar elements."""
AROUND = 0.35
"""An answer is the most similar element within this distance of the place on the plan [m]. Large
patches agree on where a cup is, and a small one shows it."""

_TIE = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """The elements of the CLIP map, seen for one goal.

    Attributes:
        points: (N, 3) in `map` [m].
        similarities: (N,) float32 to the goal.
        keyframes: (N,) ids of the keyframes that the elements are anchored to.
        frames: (N,) indices of the frames that show them.
        seen_from: (N, 2) x, y where the camera saw them from, in `map` [m].
        halvings: (N,) how often the width of the largest patch is halved to give that of each.
    """

    points: NDArray[np.float64]
    similarities: NDArray[np.float32]
    keyframes: NDArray[np.int32]
    frames: NDArray[np.int32]
    seen_from: NDArray[np.float64]
    halvings: NDArray[np.float32]

    @classmethod
    def from_bundle(cls, bundle: MapBundle, similarities: NDArray[np.float32]) -> Sightings:
        """The elements of a saved map with their similarities (N,)."""
        elements, cameras = bundle.elements, bundle.final_poses()[:, :2, 3]
        return cls(
            bundle.element_points(),
            similarities,
            elements.keyframes,
            elements.frames,
            cameras[elements.frames],
            halvings(elements.boxes),
        )

    def take(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Sightings:
        """The elements that a mask (N,) or indices choose."""
        return Sightings(
            self.points[chosen],
            self.similarities[chosen],
            self.keyframes[chosen],
            self.frames[chosen],
            self.seen_from[chosen],
            self.halvings[chosen],
        )

    def by_position(self, spacing: float) -> Sightings:
        """The same elements, but one keyframe for every `spacing` [m] that the camera moved."""
        # All elements of a frame are seen from one place.
        _, first, frame_of = np.unique(self.frames, return_index=True, return_inverse=True)
        positions = np.zeros(len(first), np.int32)
        anchor, position = np.full(2, np.inf), -1
        for frame, camera in enumerate(self.seen_from[first]):
            if not np.linalg.norm(camera - anchor) <= spacing:
                anchor, position = camera, position + 1
            positions[frame] = position
        return replace(self, keyframes=positions[frame_of])

    def agreed(self, config: AgreementConfig, floor: float) -> NDArray[np.float32]:
        """Similarity (N,) that several keyframes agree on around each element.

        It is `floor` for an element that is itself not above it (`mapping.clip.view_agreement`),
        and at most a little above the element's own similarity (`AgreementConfig.lent`).
        """
        agreed = np.full(len(self.similarities), floor, np.float32)
        above, discounted = self._above(config, floor)
        around = self.agreed_at(self.points[above, :2], config, floor)
        most = discounted + config.lent * np.abs(discounted)
        agreed[above] = np.minimum(around, most)
        return agreed

    def agreed_at(
        self, at_xy: NDArray[np.float64], config: AgreementConfig, floor: float
    ) -> NDArray[np.float32]:
        """Similarity (M,) that several keyframes agree on around places (M, 2)."""
        above, discounted = self._above(config, floor)
        rule = AgreementRule(floor, config.radius, config.views, config.falloff)
        return agreed_similarities(
            at_xy, self.points[above], discounted, self.keyframes[above], rule
        )

    def _above(
        self, config: AgreementConfig, floor: float
    ) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Elements whose discounted similarity is above `floor`, and that similarity."""
        above = np.flatnonzero(self.similarities > floor)  # a discount only lessens it
        discounted = self.take(above)._discounted(config)
        kept = discounted > floor
        return above[kept], discounted[kept]

    def ranks(self, config: AgreementConfig) -> NDArray[np.float32]:
        """How well each element (N,) answers a question to the whole map, without a threshold.

        The most similar elements rank by what several keyframes agree on around them, the others
        behind them by their own similarity.
        """
        similarities = self._discounted(config)
        chosen = np.argsort(-similarities, kind="stable")[:RANKED]
        if len(chosen) == 0:
            return similarities
        floor = float(similarities[chosen[-1]])
        ranks = (1 + _TIE) * similarities
        # Elements above each other share the agreement, so the most similar comes first.
        ranks[chosen] = _TIE * similarities[chosen] + self.take(chosen).agreed(config, floor)
        return ranks

    def answers(self, config: AgreementConfig | None, count: int = CANDIDATES) -> tuple[int, ...]:
        """Indices of the elements that answer a question to the whole map, best first.

        Args:
            config: How views are combined; None ranks elements by their similarity alone.
            count: Number of answers at most.
        """
        if config is None:
            return tuple(best(self.similarities, self.points, count, CANDIDATE_SPACING).tolist())
        places = best(self.ranks(config), self.points, count, CANDIDATE_SPACING)
        return tuple(self._most_similar_at(place) for place in places)

    def with_first(self, first: int, answers: tuple[int, ...]) -> tuple[int, ...]:
        """The answer `first`, known to be right, and behind it those `answers` elsewhere."""
        away = np.linalg.norm(self.points[list(answers)] - self.points[first], axis=1)
        others = [i for i, far in zip(answers, away >= CANDIDATE_SPACING, strict=True) if far]
        return (first, *others)[:CANDIDATES]

    def _most_similar_at(self, place: int) -> int:
        away = np.linalg.norm(self.points[:, :2] - self.points[place, :2], axis=1)
        around = np.flatnonzero(away <= AROUND)
        return int(around[np.argmax(self.similarities[around])])

    def _discounted(self, config: AgreementConfig) -> NDArray[np.float32]:
        """Similarities (N,), less for elements seen from afar and those of small patches."""
        ranges = np.linalg.norm(self.points[:, :2] - self.seen_from, axis=1)
        discount = config.range_doubt * np.maximum(ranges - config.clear_range, 0.0)
        discount = np.minimum(discount + config.halving_doubt * self.halvings, 1.0)
        return np.asarray(self.similarities - discount * np.abs(self.similarities), np.float32)
