"""What a map tells of the things and rooms of a household."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapping.clip.belief import Belief, PlaceBelief
from mapping.clip.place_rows import PlaceMap
from mapping.clip.weights import fitted_weights
from mapping.map_bundle import MapBundle
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.pipeline import Pipeline


class HouseholdBeliefs:
    """Beliefs for words of the household, which follow a growing map.

    Its methods may be called from several threads.
    """

    def __init__(self, words: Sequence[str] | None = None) -> None:
        """Begin without a map; all words of the household by default."""
        self._words = words
        self._lock = threading.Lock()
        self._map = -1
        self._beliefs: dict[str, Belief] = {}
        self._places: NDArray[np.int64] = np.zeros((0, 2), np.int64)
        self._moved = 0

    def found(self, bundle: MapBundle, number: int, pipeline: Pipeline) -> list[str]:
        """The words that some place of the map answers, in alphabetical order.

        Args:
            bundle: The map as it is now.
            number: Counts the maps of the run.
            pipeline: Embeds the words, and says how probable an answer has to be.
        """
        with self._lock:
            best = {
                text: float(belief.probabilities.max(initial=0.0))
                for text, belief in self._updated(bundle, number, pipeline).items()
            }
        least = pipeline.config.objectnav.found
        return sorted(text for text, probability in best.items() if probability > least)

    def in_view(self, bundle: MapBundle, number: int, pipeline: Pipeline) -> list[str]:
        """The words for what the newest mapped picture shows, the most probable first.

        Args:
            bundle: The map as it is now.
            number: Counts the maps of the run.
            pipeline: Embeds the words, and says how probable a place has to be.
        """
        with self._lock:
            beliefs = self._updated(bundle, number, pipeline)
            frames = bundle.elements.frames[bundle.places.elements[:, 0]]
            shown = self._places[frames == frames.max(initial=-1)]
            best = {
                text: float(belief.probabilities[tuple((shown - belief.low).T[::-1])].max())
                for text, belief in beliefs.items()
                if len(shown)
            }
        least = pipeline.config.objectnav.found
        likely = [text for text, probability in best.items() if probability > least]
        return sorted(likely, key=lambda text: -best[text])

    def believed(
        self, bundle: MapBundle, number: int, pipeline: Pipeline
    ) -> dict[str, PlaceBelief]:
        """What is believed for each word, all of the same places; arguments as for `found`."""
        with self._lock:
            return self._updated(bundle, number, pipeline)

    def _updated(
        self, bundle: MapBundle, number: int, pipeline: Pipeline
    ) -> dict[str, PlaceBelief]:
        """What is believed now, for each word."""
        assert bundle.statistics is not None
        placed = PlaceMap(bundle.places).placed(bundle.keyframes.poses())
        places, known = placed.places, len(self._places)
        if number != self._map or len(places) < known:
            self._map, self._beliefs = number, _begun(self._words, pipeline)
        elif not np.array_equal(places[:known], self._places):
            self._moved += 1
        self._places = places
        return {
            text: belief.update(
                bundle.elements.embeddings,
                bundle.statistics,
                bundle.pictures,
                bundle.places,
                replace(placed, moved=self._moved),
            )
            for text, belief in self._beliefs.items()
        }


def _begun(words: Sequence[str] | None, pipeline: Pipeline) -> dict[str, Belief]:
    """Beliefs of an empty map."""
    texts = sorted(HOUSEHOLD if words is None else words)
    questions = {text: pipeline.question(pipeline.goal(text)) for text in texts}
    return {text: Belief(each, fitted_weights()) for text, each in questions.items()}
