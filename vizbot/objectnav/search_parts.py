"""Parts that the search by belief can do without, for those who ask what each is worth."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SearchParts:
    """What the search has.

    Attributes:
        most_looks: From so many spots a place is looked at.
        likeness: Whether what was seen near a frontier says what may be behind it.
    """

    most_looks: int = 3
    likeness: bool = True


ALL_PARTS = SearchParts()
