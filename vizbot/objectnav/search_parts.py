"""Parts of the search by belief that can be left out, to measure what each is worth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class SearchParts:
    """Which parts the search has.

    Attributes:
        likeness: Whether what was seen near a frontier says what may be behind it.
        weights: File of the numbers that make a belief of what was seen; None for those that were
            fitted to the encoder.
    """

    likeness: bool = True
    weights: Path | None = None


ALL_PARTS = SearchParts()
