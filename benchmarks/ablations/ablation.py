"""The parts that can be taken away from the search, and the search without each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from nav.frontier import FrontierSearch
from vizbot.config import Config
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.search_parts import ALL_PARTS, SearchParts


@dataclass(frozen=True, slots=True)
class Ablation:
    """What is left of the search.

    Attributes:
        parts: Its parts.
        commitment: Whether it rather goes on with what it does.
    """

    parts: SearchParts = ALL_PARTS
    commitment: bool = True

    def search(self, config: Config, frontiers: FrontierSearch) -> BeliefSearch:
        """The search that is left."""
        if not self.commitment:
            search = config.objectnav.search.model_copy(update={"aim_change_margin": 0.0})
            objectnav = config.objectnav.model_copy(update={"search": search})
            config = config.model_copy(update={"objectnav": objectnav})
        return BeliefSearch(config, frontiers, self.parts)


WHOLE = Ablation()
"""Nothing is taken away."""
_WEIGHTS = Path(__file__).parent

ABLATIONS: Mapping[str, Ablation] = {
    "likeness at frontiers": Ablation(SearchParts(likeness=False)),
    "commitment": Ablation(commitment=False),
    "z-score": Ablation(SearchParts(weights=_WEIGHTS / "without_z_score.json")),
    "joined views": Ablation(SearchParts(weights=_WEIGHTS / "without_joined_views.json")),
    "offsets of texts": Ablation(SearchParts(weights=_WEIGHTS / "without_offsets_of_texts.json")),
}
"""By the part that is taken away."""
