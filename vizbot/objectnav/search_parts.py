"""Parts of the search by belief that can be left out, to measure what each is worth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mapping.clip.evidence import WEIGHTS_FILE


@dataclass(frozen=True, slots=True)
class SearchParts:
    """Which parts the search has.

    Attributes:
        likeness: Whether what was seen near a frontier says what may be behind it.
        weights: File of the numbers that make a belief of what was seen.
    """

    likeness: bool = True
    weights: Path = WEIGHTS_FILE


ALL_PARTS = SearchParts()
