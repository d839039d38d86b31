"""Compaction: pictures that were taken again later leave a CLIP map, with all that they show.

A map is compacted beside the robot's loop, from tables that do not change. What was added meanwhile
follows when the compacted map takes the place of the other one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import chosen_rows
from mapping.clip.mapped_frames import MappedFrames
from mapping.clip.mapper import ClipElements
from mapping.clip.places.place_rows import PlaceRows

LEAST, SHARE = 30, 0.2
"""A map is compacted where so many of its pictures, and such a share of them, were taken again."""


@dataclass(frozen=True, slots=True, eq=False)
class ClipTables:
    """All that a CLIP map has of its frames.

    Attributes:
        elements: The elements.
        statistics: (N, 2) of them, as of `Background.statistics`.
        places: The views of places.
        frames: The frames.
    """

    elements: ClipElements
    statistics: NDArray[np.float32]
    places: PlaceRows
    frames: MappedFrames

    def without(self, numbers: NDArray[np.int32]) -> ClipTables:
        """The tables without the frames of these numbers (M,)."""
        kept = ~np.isin(self.elements.frames, numbers)
        row_of = np.cumsum(kept) - 1
        places = chosen_rows(self.places, ~np.isin(self.places.frames, numbers))
        return ClipTables(
            chosen_rows(self.elements, kept),
            self.statistics[kept],
            replace(places, elements=row_of[places.elements].astype(np.int32)),
            chosen_rows(self.frames, ~np.isin(self.frames.numbers, numbers)),
        )

    def since(self, before: ClipTables) -> ClipTables:
        """What was added to earlier tables of the same map; elements count from the first of it."""
        first = len(before.statistics)
        places = chosen_rows(self.places, slice(len(before.places), None))
        return ClipTables(
            chosen_rows(self.elements, slice(first, None)),
            self.statistics[first:],
            replace(places, elements=(places.elements - first).astype(np.int32)),
            chosen_rows(self.frames, slice(len(before.frames), None)),
        )


def is_due(retaken: int, frames: int) -> bool:
    """Whether a map of so many frames is compacted, of which so many were taken again."""
    return retaken >= max(LEAST, SHARE * frames)
