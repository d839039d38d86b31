"""Parts that the search by belief can do without, for those who ask what each is worth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mapping.clip.evidence import WEIGHTS_FILE


@dataclass(frozen=True, slots=True)
class SearchParts:
    """What the search has.

    Attributes:
        most_looks: From so many spots a place is looked at.
        likeness: Whether what was seen near a frontier says what may be behind it.
        weights: File of the numbers that make a belief of what was seen.
    """

    most_looks: int = 3
    likeness: bool = True
    weights: Path = WEIGHTS_FILE


ALL_PARTS = SearchParts()
