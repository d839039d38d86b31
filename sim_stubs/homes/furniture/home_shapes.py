"""Shapes of our own for one home, and the turns that they take with models of the catalogue.

The catalogue holds out a single model of several goals. So what counts as a goal of the paper comes
from a held-out model and from a shape in turn, from home `FIRST_IN_TURN` on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from zlib import crc32

import numpy as np

from sim_stubs.homes.floor_plan.staircase import staircase
from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.furniture.fitting import Source
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.solids import Piece
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import EVALUATION_CLASSES, kinds

FIRST_IN_TURN = 1020
"""First seed of the homes in which models and shapes take turns."""
DEVELOPMENT = range(1100, 1200)
"""Seeds of the held-out homes for development; all others from `FIRST_IN_TURN` on are boards."""
GOALS = EVALUATION_CLASSES[:16]
"""Goals of the paper."""
IN_TURN = frozenset(label for label in procedural.SHAPES if set(kinds(label)) & set(GOALS))
"""Classes whose instances count as a goal."""
_RANGES = {"boards": 1, "development": 2}
"""Ranges of seeds of shapes, by name. No seed of a shape for training is in any of them, as those
are plain numbers, which are never equal to a spawned sequence."""


class HomeShapes:
    """The shapes of one draw of a held-out home, each drawn from a seed of its own.

    That seed is made of the range, the home, the draw, the class and the number of the shape in its
    class, so that no shape of a home for development is drawn in a board, or the reverse.
    """

    def __init__(self, seed: int, draw: int) -> None:
        """Begin with number 0 of every class."""
        self._range = "development" if seed in DEVELOPMENT else "boards"
        self._seed, self._draw = seed, draw
        self._drawn = Counter[str]()

    def piece(self, label: str, _rng: np.random.Generator) -> Piece:
        """The next shape of a class, named in its attribute `shape`; a `Source`.

        Raises:
            ConfigError: there is no shape for `label`; stairs are built in their place.
        """
        if label == "stairs":
            raise ConfigError("stairs are built in their place, not drawn as a piece")
        rng, name = self._next(label)
        return replace(procedural.piece(label, rng, held_out=True), shape=name)

    def staircase(self, stairs: Stairs, height: float) -> Instance:
        """The next stairs, built in their place under a ceiling of a height [m]."""
        rng, name = self._next("stairs")
        built = staircase(stairs, height, rng, held_out=True)
        return replace(built, piece=replace(built.piece, shape=name))

    def _next(self, label: str) -> tuple[np.random.Generator, str]:
        """The generator of the next shape of a class, and the name of the shape."""
        number = self._drawn[label]
        self._drawn[label] += 1
        key = (_RANGES[self._range], self._draw, crc32(label.encode()), number)
        rng = np.random.default_rng(np.random.SeedSequence(self._seed, spawn_key=key))
        return rng, f"{label} {self._seed}-{self._draw}-{number} of {self._range}"


def in_turn(seed: int, models: Source, shapes: Source) -> Callable[[str], Source]:
    """Returns the source of the next piece of a class: `models`, or the two in turn for goals.

    Of the homes 2n and 2n + 1 one begins a class with a model and the other with a shape.
    """
    shape_is_next: dict[str, bool] = {}

    def source(label: str) -> Source:
        if label not in IN_TURN:
            return models
        own = shape_is_next.setdefault(label, _begins_with_shape(seed, label))
        shape_is_next[label] = not own
        return shapes if own else models

    return source


def _begins_with_shape(seed: int, label: str) -> bool:
    pair, second = divmod(seed, 2)
    first = np.random.default_rng((pair, crc32(label.encode()))).random() < 0.5
    return bool(first) != bool(second)
