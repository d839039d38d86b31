"""Procedural furniture: recognisable, metric, of many looks.

The embedded CLIP is trained on it beside models, and homes without a catalogue have nothing else.
The catalogue holds out a single model of several goals. So what counts as a goal of the paper comes
from a held-out model and from a shape in turn, from home `FIRST_IN_TURN` on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from zlib import crc32

import numpy as np

from sim_stubs.homes.floor_plan.staircase import staircase
from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.furniture.fitting import Source
from sim_stubs.homes.furniture.objects import (
    baskets,
    climate,
    devices,
    household_items,
    instruments,
    lights,
    ornaments,
    plants,
    vehicles,
)
from sim_stubs.homes.furniture.shapes import (
    appliances,
    baths,
    beds,
    chairs,
    cupboards,
    sanitary,
    sofas,
    tables,
    windows,
)
from sim_stubs.homes.furniture.shapes.materials import Random, Shape, pick
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.solids import Piece, by_material, moved_part, stretched, triangles
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import EVALUATION_CLASSES, kinds


def piece(label: str, rng: np.random.Generator, held_out: bool = False) -> Piece:
    """One model of the class `label`, whose looks `rng` draws; its name holds its material.

    Raises:
        ConfigError: there is no shape for `label`.
    """
    if label not in SHAPES:
        raise ConfigError(f"no shape for {label!r}; take one of {', '.join(sorted(SHAPES))}")
    shape = SHAPES[label](Random(rng, held_out))
    # No two are quite alike in their proportions.
    parts = by_material(stretched(shape.parts, rng.uniform(0.93, 1.07, 3)))
    corners = triangles(parts).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    to_origin = np.eye(4)
    to_origin[:3, 3] = (*(-(low + high)[:2] / 2), -low[2])
    name = f"{shape.material} {label}".strip()
    return Piece(label, name, high - low, tuple(moved_part(part, to_origin) for part in parts), "")


def _stairs(rng: Random) -> Shape:
    """A staircase of one storey: straight, around a corner, or spiral."""
    width, depth = rng.uniform(0.8, 1.2), rng.uniform(2.6, 3.6)
    straight = Stairs("up", "straight", 0.0, 0.0, "S", width, depth, ("left", "right"))
    width, depth = rng.uniform(1.9, 2.6), rng.uniform(2.0, 2.8)
    turning = Stairs("up", "quarter-turn", 0.0, 0.0, "S", width, depth)
    across = rng.uniform(1.4, 2.0)
    spiral = Stairs("up", "spiral", 0.0, 0.0, "S", across, across)
    place = pick(rng, (straight, replace(straight, open_sides=()), turning, spiral))
    return Shape("", list(staircase(place, rng.uniform(2.4, 3.2), rng, rng.held_out).piece.parts))


SHAPES: Mapping[str, Callable[[Random], Shape]] = {
    "air conditioner": climate.air_conditioner,
    "aquarium": ornaments.aquarium,
    "armchair": sofas.armchair,
    "backpack": baskets.backpack,
    "ball": ornaments.ball,
    "bathtub": baths.bathtub,
    "beanbag": sofas.beanbag,
    "bed": beds.bed,
    "bench": chairs.bench,
    "bicycle": vehicles.bicycle,
    "bidet": sanitary.bidet,
    "bookshelf": cupboards.bookshelf,
    "bunk bed": beds.bunk_bed,
    "cardboard box": baskets.cardboard_box,
    "carpet": household_items.carpet,
    "cat": ornaments.cat,
    "ceiling fan": climate.ceiling_fan,
    "ceiling lamp": lights.ceiling_lamp,
    "chair": chairs.chair,
    "changing table": cupboards.changing_table,
    "chest of drawers": cupboards.chest_of_drawers,
    "christmas tree": plants.christmas_tree,
    "clock": devices.clock,
    "clothes rack": cupboards.clothes_rack,
    "coat rack": household_items.coat_rack,
    "coffee machine": appliances.coffee_machine,
    "coffee table": tables.coffee_table,
    "computer": devices.computer,
    "crib": beds.crib,
    "curtain": household_items.curtain,
    "desk": tables.desk,
    "dining table": tables.dining_table,
    "dishwasher": appliances.dishwasher,
    "dog": ornaments.dog,
    "door": windows.door,
    "dressing table": tables.dressing_table,
    "dryer": appliances.dryer,
    "drying rack": household_items.drying_rack,
    "electric fan": climate.electric_fan,
    "filing cabinet": cupboards.filing_cabinet,
    "fire extinguisher": devices.fire_extinguisher,
    "fireplace": ornaments.fireplace,
    "floor lamp": lights.floor_lamp,
    "flowers": plants.flowers,
    "folding screen": cupboards.folding_screen,
    "freezer": appliances.freezer,
    "guitar": instruments.guitar,
    "high chair": vehicles.high_chair,
    "ironing board": household_items.ironing_board,
    "kitchen cabinet": cupboards.kitchen_cabinet,
    "kitchen island": cupboards.kitchen_island,
    "ladder": household_items.ladder,
    "laptop": devices.laptop,
    "laundry basket": baskets.laundry_basket,
    "microwave": appliances.microwave,
    "mirror": ornaments.mirror,
    "nightstand": cupboards.nightstand,
    "office chair": chairs.office_chair,
    "oven": appliances.oven,
    "piano": instruments.piano,
    "picture": ornaments.picture,
    "plant": plants.plant,
    "pool table": tables.pool_table,
    "printer": devices.printer,
    "pushchair": vehicles.pushchair,
    "radiator": climate.radiator,
    "range hood": cupboards.range_hood,
    "refrigerator": appliances.refrigerator,
    "rocking horse": ornaments.rocking_horse,
    "shelf": cupboards.shelf,
    "shower": baths.shower,
    "single bed": beds.single_bed,
    "sink": sanitary.sink,
    "sofa": sofas.sofa,
    "speaker": devices.speaker,
    "stairs": _stairs,
    "stool": chairs.stool,
    "suitcase": baskets.suitcase,
    "table": tables.any_table,
    "table lamp": lights.table_lamp,
    "teddy bear": ornaments.teddy_bear,
    "toaster": appliances.toaster,
    "toilet": sanitary.toilet,
    "towel rack": baths.towel_rack,
    "trash can": baskets.trash_can,
    "tv": devices.tv,
    "tv stand": cupboards.tv_stand,
    "umbrella": household_items.umbrella,
    "urinal": sanitary.urinal,
    "vacuum cleaner": household_items.vacuum_cleaner,
    "vase": plants.vase,
    "wall cabinet": cupboards.wall_cabinet,
    "wardrobe": cupboards.wardrobe,
    "washing machine": appliances.washing_machine,
    "water cooler": climate.water_cooler,
    "water heater": baths.water_heater,
    "wheelchair": vehicles.wheelchair,
    "whiteboard": devices.whiteboard,
    "window": windows.window,
}
"""Shapes by label, in the words of the catalogue's classes."""


FIRST_IN_TURN = 1020
"""First seed of the homes in which models and shapes take turns."""
DEVELOPMENT = range(1100, 1200)
"""Seeds of the held-out homes for development; all others from `FIRST_IN_TURN` on are boards."""
GOALS = EVALUATION_CLASSES[:16]
"""Goals of the paper."""
IN_TURN = frozenset(label for label in SHAPES if set(kinds(label)) & set(GOALS))
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
        return replace(piece(label, rng, held_out=True), shape=name)

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
