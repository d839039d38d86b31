"""Elements of the CLIP map with their similarities to one goal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.likeliest_places import APART, MOST
from mapping.clip.retrieval import best
from mapping.map_bundle import MapBundle


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """The elements of the CLIP map, seen for one goal.

    Attributes:
        points: (N, 3) in `map` [m].
        similarities: (N,) float32 to the goal.
        seen_from: (N, 2) x, y where the camera saw them from, in `map` [m].
    """

    points: NDArray[np.float64]
    similarities: NDArray[np.float32]
    seen_from: NDArray[np.float64]

    @classmethod
    def from_bundle(cls, bundle: MapBundle, similarities: NDArray[np.float32]) -> Sightings:
        """The elements of a saved map with their similarities (N,)."""
        cameras = bundle.frames.Ts_map_cam(bundle.keyframes.poses())[:, :2, 3]
        frame_of = bundle.frames.rows_of(bundle.elements.frames)
        return cls(bundle.element_points(), similarities, cameras[frame_of])

    def answers(self, first: int | None = None) -> tuple[int, ...]:
        """Indices of the elements that answer a question to the whole map, the most similar first.

        Args:
            first: Index of an element that comes before all others; None without one.
        """
        ranks = self.similarities.copy()
        if first is not None:
            ranks[first] = 2.0
        return tuple(best(ranks, self.points, MOST, APART).tolist())
