"""Homes that training takes pictures of: ours, those that others drew, and mixtures of both.

An encoder that knows our homes alone knows things by their company there. So it also sees our
furniture in rooms that others laid out, furniture of others in our rooms, and walls and furniture
in colours that our homes do not have.
"""

from __future__ import annotations

import colorsys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache, lru_cache
from pathlib import Path

import numpy as np

from sim_stubs.homes.furniture.catalogue import Entry, read_catalogue
from sim_stubs.homes.furniture.fitting import stretched_piece
from sim_stubs.homes.furniture.paint import painted_in_shades
from sim_stubs.homes.furniture.source import furniture_source
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.solids import Part, Piece
from sim_stubs.homes.home import home
from sim_stubs.world.world_file import read_world
from training.models import read_models
from training.variety import another, keeps_colours, varied
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import COLOURS
from vizbot.rehearsal.belief_fit.view_list import SEEN_WORLDS

IN_THE_WALL = frozenset({"door", "window", "stairs"})
"""Classes that stay where a home is furnished anew: their places are made for them."""
SWAPPED = 0.85
"""Share of the pieces of a mixed home that are replaced."""
MOST_STRETCH = 1.7
"""A piece is not replaced by one that would be stretched by more than this, against its size."""
PAINTED_WALLS, OF_WALLS = 0.4, 0.25
"""Share of the mixed homes whose walls are painted anew; in those, share of the pieces that are
painted like a wall."""
WALL = 2.2
"""A part of the structure that is higher than this is a wall, and neither door nor window [m]."""


class Mixture(StrEnum):
    """Where rooms and furniture of a training home come from."""

    OURS = "ours"
    """Rooms and furniture of ours."""
    VARIED = "varied"
    """The same, with furniture in other proportions and colours (`training.variety`)."""
    THEIR_FURNITURE = "their-furniture"
    """Our rooms with furniture of others."""
    THEIR_ROOMS = "their-rooms"
    """Rooms of others with our furniture."""
    THEIRS = "theirs"
    """Rooms and furniture of others."""
    MAKERS = "makers"
    """Rooms of ours and of others in turn, with models of several makers (`training.models`)."""


@dataclass(frozen=True, slots=True)
class TrainingHome:
    """A home to take pictures of.

    Attributes:
        mixture: Where rooms and furniture come from.
        seed: Of all that is drawn; of our rooms, the seed of the home.
        jar: Sweet Home 3D, with its example homes; None where it is not needed.
        models: Folder of the models of several makers; None where it is not needed.
    """

    mixture: Mixture
    seed: int
    jar: Path | None = None
    models: Path | None = None

    @property
    def name(self) -> str:
        """Unique among all training homes."""
        return f"{self.mixture}-{self.seed:04d}"

    def house(self) -> House:
        """The home, the same in every process.

        Raises:
            ConfigError: the example homes cannot be read.
        """
        rng = np.random.default_rng((self.seed, 4))
        match self.mixture:
            case Mixture.OURS:
                return home(self.seed)
            case Mixture.VARIED:
                return varied(home(self.seed), rng)
            case Mixture.THEIR_FURNITURE:
                return painted(refurnished(home(self.seed), self._theirs(), rng), rng)
            case Mixture.THEIR_ROOMS:
                return painted(refurnished(self._example(), our_piece, rng), rng)
            case Mixture.THEIRS:
                return painted(self._example(), rng)
            case Mixture.MAKERS:
                furnisher = self._made()
                rooms = self._example() if self.seed % 2 else home(self.seed)
                return painted(refurnished(rooms, furnisher, rng), rng)

    def _example(self) -> House:
        """The example home of this seed; they take turns."""
        return _read(self._require_jar() / SEEN_WORLDS[self.seed % len(SEEN_WORLDS)])

    def _theirs(self) -> Furnisher:
        models = models_in([_read(self._require_jar() / name) for name in SEEN_WORLDS])
        return lambda label, rng: _one_of(models.get(label, ()), rng)

    def _made(self) -> Furnisher:
        if self.models is None:
            raise ConfigError(f"training home {self.name} needs models; give them by --models")
        models = read_models(self.models)

        def piece(label: str, rng: np.random.Generator) -> Piece | None:
            drawn = _one_of(models.get(label, ()), rng)
            return None if drawn is None else another(drawn, rng)

        return piece

    def _require_jar(self) -> Path:
        if self.jar is None:
            raise ConfigError(f"training home {self.name} needs sweethome3d.jar; give it by --jar")
        return self.jar


Furnisher = Callable[[str, np.random.Generator], Piece | None]
"""Returns one model of a class; None where there is none."""


def _one_of(models: Sequence[Piece], rng: np.random.Generator) -> Piece | None:
    return models[int(rng.integers(len(models)))] if models else None


@lru_cache(maxsize=len(SEEN_WORLDS))
def _read(world: Path) -> House:
    return read_world(world)


def models_in(houses: Sequence[House]) -> Mapping[str, Sequence[Piece]]:
    """The different models of some houses, by their class."""
    found: dict[str, dict[tuple[str, bytes], Piece]] = {}
    for instance in (each for house in houses for each in house.instances):
        piece = instance.piece
        key = piece.attribution, piece.size.round(2).tobytes()
        found.setdefault(instance.label, {}).setdefault(key, piece)
    return {label: list(models.values()) for label, models in found.items()}


def our_piece(label: str, rng: np.random.Generator) -> Piece | None:
    """A piece of furniture of our training homes; None for classes that they do not have."""
    try:
        return furniture_source(_catalogue(), held_out=False)(label, rng)
    except ConfigError:
        return None


@cache
def _catalogue() -> tuple[Entry, ...]:
    return read_catalogue()


def refurnished(house: House, furnisher: Furnisher, rng: np.random.Generator) -> House:
    """The home with most pieces replaced by others of their class and size."""
    return replace(
        house, instances=tuple(_replaced(each, furnisher, rng) for each in house.instances)
    )


def _replaced(instance: Instance, furnisher: Furnisher, rng: np.random.Generator) -> Instance:
    """The instance with another piece, stretched to its bounding box; itself where none fits."""
    is_named_by_colour = instance.label.split()[0] in COLOURS
    if instance.label in IN_THE_WALL or is_named_by_colour or rng.random() >= SWAPPED:
        return instance
    piece = furnisher(instance.label, rng)
    if piece is None:
        return instance
    scale = instance.piece.size / np.maximum(piece.size, 1e-3)
    if scale.max() / scale.min() > MOST_STRETCH:
        return instance
    return replace(instance, piece=stretched_piece(piece, scale))


def painted(house: House, rng: np.random.Generator) -> House:
    """The home with walls of other colours, some pieces among them; or as it is."""
    if rng.random() >= PAINTED_WALLS:
        return house
    colours = [
        colorsys.hsv_to_rgb(rng.uniform(), rng.beta(1.0, 1.5), rng.uniform(0.35, 1.0))
        for _ in range(3)
    ]
    structure = tuple(_painted_wall(part, colours, rng) for part in house.structure)
    instances = tuple(
        replace(each, piece=painted_in_shades(each.piece, (*colours[rng.integers(3)], 1.0)))
        if rng.random() < OF_WALLS and not keeps_colours(each.label)
        else each
        for each in house.instances
    )
    return replace(house, structure=structure, instances=instances)


def _painted_wall(
    part: Part, colours: Sequence[tuple[float, float, float]], rng: np.random.Generator
) -> Part:
    if np.ptp(part.vertices[:, 2]) < WALL or part.rgba[3] < 1.0:
        return part
    rgb = colours[min(int(rng.exponential(0.7)), len(colours) - 1)]
    return replace(part, rgba=np.array([*rgb, 1.0], np.float32), texture=None)
