"""Scores of places: what a search decides by, as people are shown it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

UNSEEN = -1.0
"""Score of a place that was not seen: no other is lower."""


class Measure(StrEnum):
    """What a score is."""

    PROBABILITY = "probability"
    SIMILARITY = "similarity"

    def text(self, score: float) -> str:
        """A score as people read it."""
        return f"{score:.0%}" if self is Measure.PROBABILITY else f"{score:.3f}"


@dataclass(frozen=True, slots=True, eq=False)
class PlaceScores:
    """Scores of the places on a part of the plan.

    Attributes:
        low: (2,) column, row of the first place, counted from the origin of `map`.
        size: Edge of a place, a cell of the plan [m].
        values: (rows, cols) float32; `UNSEEN` where nothing was seen.
    """

    low: NDArray[np.int64]
    size: float
    values: NDArray[np.float32]

    @classmethod
    def of_points(
        cls, points: NDArray[np.float64], scores: NDArray[np.float32], size: float
    ) -> PlaceScores:
        """The highest scores (N,) of points (N, 2 or 3) in each place of this size [m]."""
        if len(points) == 0:
            return cls(np.zeros(2, np.int64), size, np.zeros((0, 0), np.float32))
        cells = np.floor(points[:, :2] / size).astype(np.int64)
        low = cells.min(axis=0)
        columns, rows = (cells - low).T
        values = np.full((rows.max() + 1, columns.max() + 1), UNSEEN, np.float32)
        np.maximum.at(values, (rows, columns), scores)
        return cls(low, size, values)

    @property
    def best(self) -> float | None:
        """The highest score; None where nothing was seen."""
        highest = float(self.values.max(initial=UNSEEN))
        return None if highest == UNSEEN else highest

    def xy(self, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Centres (N, 2) of places in `map` [m]."""
        cells = np.stack([columns, rows], axis=-1) + self.low
        return np.asarray((cells + 0.5) * self.size, np.float64)

    def look_up(self, points: NDArray[np.float64]) -> NDArray[np.float32]:
        """Scores (N,) of the places of points (N, 2 or 3) in `map` [m]."""
        columns, rows = (np.floor(points[:, :2] / self.size).astype(np.int64) - self.low).T
        inside = (rows >= 0) & (columns >= 0)
        inside &= (rows < self.values.shape[0]) & (columns < self.values.shape[1])
        scores = np.full(len(points), UNSEEN, np.float32)
        scores[inside] = self.values[rows[inside], columns[inside]]
        return scores
