"""What the CLIP map says about a goal, element by element."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapping.clip.retrieval import best
from mapping.clip.view_agreement import AgreementRule, agreed_similarities
from mapping.map_bundle import MapBundle
from vizbot.config import AgreementConfig

CANDIDATES = 5
"""So many places answer a question at most ..."""
CANDIDATE_SPACING = 0.8
"""... this far apart [m]."""
PLACES = 600
"""A map that is asked for its best places looks for agreement around so many elements."""
AROUND = 0.35
"""The answer is what is most similar so near to the place on the plan [m]: large patches agree on
where a cup is, and a small one shows it."""

_TIE = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """The elements of the CLIP map, as far as they concern one goal.

    Attributes:
        points: (N, 3) in `map` [m].
        similarities: (N,) float32 to the goal.
        keyframes: (N,) ids of the keyframes they are anchored to.
        frames: (N,) index of the frame of each.
        seen_from: (N, 2) where the camera was, in `map` [m].
        halvings: (N,) how many times the width of the largest patch was halved to that of each.
    """

    points: NDArray[np.float64]
    similarities: NDArray[np.float32]
    keyframes: NDArray[np.int32]
    frames: NDArray[np.int32]
    seen_from: NDArray[np.float64]
    halvings: NDArray[np.float32]

    @classmethod
    def of(cls, bundle: MapBundle, similarities: NDArray[np.float32]) -> Sightings:
        """Those of a kept map, with the similarities (N,) of its elements."""
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
        """Those of a mask (N,) or of indices."""
        return Sightings(
            self.points[chosen],
            self.similarities[chosen],
            self.keyframes[chosen],
            self.frames[chosen],
            self.seen_from[chosen],
            self.halvings[chosen],
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

        `floor` for an element that is itself no more similar (`mapping.clip.view_agreement`), and
        for others little more than their own similarity (`AgreementConfig.lent`).
        """
        agreed = np.full(len(self.similarities), floor, np.float32)
        sure = self._sure(config)
        above = np.flatnonzero(sure > floor)
        around = self._agreed_at(self.points[above, :2], sure, config, floor)
        most = sure[above] + config.lent * np.abs(sure[above])
        agreed[above] = np.minimum(around, most)
        return agreed

    def agreed_at(
        self, at_xy: NDArray[np.float64], config: AgreementConfig, floor: float
    ) -> NDArray[np.float32]:
        """(M,) what several keyframes agree on around places (M, 2)."""
        return self._agreed_at(at_xy, self._sure(config), config, floor)

    def _agreed_at(
        self,
        at_xy: NDArray[np.float64],
        sure: NDArray[np.float32],
        config: AgreementConfig,
        floor: float,
    ) -> NDArray[np.float32]:
        rule = AgreementRule(floor, config.radius, config.views, config.falloff)
        return agreed_similarities(at_xy, self.points, sure, self.keyframes, rule)

    def ranks(self, config: AgreementConfig) -> NDArray[np.float32]:
        """How well each element (N,) answers a question to the whole map, whatever the threshold.

        In essence what several keyframes agree on around the most similar elements; the similarity
        of the others, which rank behind them.
        """
        similarities = self._sure(config)
        chosen = np.argsort(-similarities, kind="stable")[:PLACES]
        if len(chosen) == 0:
            return similarities
        floor = float(similarities[chosen[-1]])
        ranks = (1 + _TIE) * similarities
        # Elements above each other share what is agreed on: the most similar comes first.
        ranks[chosen] = _TIE * similarities[chosen] + self.take(chosen).agreed(config, floor)
        return ranks

    def answers(self, config: AgreementConfig, count: int = CANDIDATES) -> tuple[int, ...]:
        """Indices of the elements that answer a question to the whole map, the best first."""
        places = best(self.ranks(config), self.points, count, CANDIDATE_SPACING)
        return tuple(self._most_similar_at(place) for place in places)

    def behind(self, first: int, answers: tuple[int, ...]) -> tuple[int, ...]:
        """An answer that is known to be right, and `answers` elsewhere behind it."""
        away = np.linalg.norm(self.points[list(answers)] - self.points[first], axis=1)
        others = [i for i, far in zip(answers, away >= CANDIDATE_SPACING, strict=True) if far]
        return (first, *others)[:CANDIDATES]

    def _most_similar_at(self, place: int) -> int:
        away = np.linalg.norm(self.points[:, :2] - self.points[place, :2], axis=1)
        around = np.flatnonzero(away <= AROUND)
        return int(around[np.argmax(self.similarities[around])])

    def _sure(self, config: AgreementConfig) -> NDArray[np.float32]:
        """Similarities (N,), less for what was seen from afar and for what small patches show."""
        ranges = np.linalg.norm(self.points[:, :2] - self.seen_from, axis=1)
        doubt = config.range_doubt * np.maximum(ranges - config.clear_range, 0.0)
        doubt = np.minimum(doubt + config.halving_doubt * self.halvings, 1.0)
        return np.asarray(self.similarities - doubt * np.abs(self.similarities), np.float32)


def halvings(boxes: NDArray[np.int32]) -> NDArray[np.float32]:
    """How many times (N,) the width of the largest patch was halved to those of `boxes` (N, 4)."""
    widths = (boxes[:, 2] - boxes[:, 0]).astype(np.float32)
    return np.asarray(np.log2(widths.max(initial=1.0) / np.maximum(widths, 1.0)), np.float32)
