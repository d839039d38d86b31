"""What is left of the search without one of its parts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from vizbot.objectnav.search_parts import SearchParts

_WEIGHTS = Path(__file__).parent

ABLATIONS: Mapping[str, SearchParts] = {
    "likeness at frontiers": SearchParts(likeness=False),
    "z-score": SearchParts(weights=_WEIGHTS / "without_z_score.json"),
    "joined views": SearchParts(weights=_WEIGHTS / "without_joined_views.json"),
    "offsets of texts": SearchParts(weights=_WEIGHTS / "without_offsets_of_texts.json"),
}
"""By the part that is taken away."""
