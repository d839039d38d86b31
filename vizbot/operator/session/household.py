"""What a map shows of the things and rooms of a household."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapping.clip.places.belief import Belief, PlaceBelief, against_rivals
from mapping.clip.places.place_rows import PlacedRows
from mapping.clip.scores import Query
from mapping.map_bundle import MapBundle
from vizbot.core.errors import ConfigError
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.pipeline import Pipeline


class HouseholdBeliefs:
    """Beliefs for words of the household, which follow a growing map.

    There is one for each word, and one for each thing that a room may be instead, whoever asks and
    however often. Its methods may be called from several threads; they work in the one that calls.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._map = -1
        self._questions: dict[str, Query | None] = {}
        self._beliefs: dict[tuple[bytes, bool], Belief] = {}
        self._places: NDArray[np.int64] = np.zeros((0, 2), np.int64)

    def __len__(self) -> int:
        """Number of beliefs that are kept."""
        return len(self._beliefs)

    def found(self, bundle: MapBundle, number: int, pipeline: Pipeline) -> list[str]:
        """The words that some place of the run's map `number` answers, in alphabetical order."""
        with self._lock:
            best = {
                text: float(belief.probabilities.max(initial=0.0))
                for text, belief in self._updated(HOUSEHOLD, bundle, number, pipeline)
            }
        least = pipeline.config.objectnav.answer_probability
        return sorted(text for text, probability in best.items() if probability > least)

    def in_view(self, bundle: MapBundle, number: int, pipeline: Pipeline) -> list[str]:
        """The words for the newest picture in the run's map `number`, the likeliest first."""
        best: dict[str, float] = {}
        newest = bundle.places.frames == bundle.places.frames.max(initial=-1)
        with self._lock:
            for text, belief in self._updated(HOUSEHOLD, bundle, number, pipeline):
                shown = (self._places[newest] - belief.low).T[::-1]
                best[text] = float(belief.probabilities[tuple(shown)].max(initial=0.0))
        least = pipeline.config.objectnav.answer_probability
        likely = [text for text, probability in best.items() if probability > least]
        return sorted(likely, key=lambda text: -best[text])

    def believed(
        self, words: Sequence[str], bundle: MapBundle, number: int, pipeline: Pipeline
    ) -> dict[str, PlaceBelief]:
        """What is believed for each word, all of the same places; arguments as for `found`.

        A word that the encoder has no name for is left out.
        """
        with self._lock:
            return dict(self._updated(words, bundle, number, pipeline))

    def _updated(
        self, words: Sequence[str], bundle: MapBundle, number: int, pipeline: Pipeline
    ) -> Iterator[tuple[str, PlaceBelief]]:
        """Each word that the encoder has a name for, with what is believed of it now."""
        placed = bundle.place_map().placed(bundle.keyframes.poses())
        if number != self._map:
            self._map, self._questions, self._beliefs = number, {}, {}
        self._places = placed.places
        rooms: dict[bytes, PlaceBelief] = {}

        def of_room(embedding: NDArray[np.float32], asked: Query) -> PlaceBelief:
            key = embedding.tobytes()
            if key not in rooms:
                alone = replace(asked, embedding=embedding, rivals=())
                rooms[key] = self._follow(alone, bundle, placed, room=True)
            return rooms[key]

        for text in sorted(words):
            if text not in self._questions:
                self._questions[text] = _question(text, pipeline)
            asked = self._questions[text]
            if asked is None:
                continue
            if len(asked.rivals) == 0:
                yield text, self._follow(asked, bundle, placed, room=False)
            else:
                own = of_room(asked.embedding, asked)
                rivals = [of_room(each, asked) for each in asked.rivals]
                yield text, against_rivals(own, rivals)

    def _follow(
        self, asked: Query, bundle: MapBundle, placed: PlacedRows, *, room: bool
    ) -> PlaceBelief:
        """What is believed now of a question by itself."""
        key = asked.embedding.tobytes(), room
        belief = self._beliefs.setdefault(key, Belief(asked, asked.weights, room=room))
        assert bundle.statistics is not None
        return belief.update(
            bundle.elements.embeddings, bundle.statistics, bundle.pictures, bundle.places, placed
        )


def _question(text: str, pipeline: Pipeline) -> Query | None:
    """The question for a word; None where the encoder has no name for it."""
    try:
        return pipeline.question(pipeline.goal(text))
    except ConfigError:
        return None
