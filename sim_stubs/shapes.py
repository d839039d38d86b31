"""Furniture of our own: recognisable, metric, of many looks.

It is what the embedded CLIP trains on beside models, and what homes without a catalogue have.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from sim_stubs import (
    appliances,
    bathroom,
    beds,
    chairs,
    cupboards,
    electronics,
    household,
    lights,
    ornaments,
    sofas,
    tables,
    textiles,
    toys,
    windows,
)
from sim_stubs.joinery import Random, Shape, pick
from sim_stubs.piece import Piece
from sim_stubs.solids import by_material, moved, triangles
from sim_stubs.staircase import staircase
from sim_stubs.stairs import Stairs
from vizbot.core.errors import ConfigError


def piece(label: str, rng: Random) -> Piece:
    """One model of the class `label`, whose looks `rng` draws; its name tells its material.

    Raises:
        ConfigError: there is no shape for `label`.
    """
    if label not in SHAPES:
        raise ConfigError(f"no shape for {label!r}; take one of {', '.join(sorted(SHAPES))}")
    shape = SHAPES[label](rng)
    parts = by_material(shape.parts)
    corners = triangles(parts).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    to_origin = np.eye(4)
    to_origin[:3, 3] = (*(-(low + high)[:2] / 2), -low[2])
    name = f"{shape.material} {label}".strip()
    return Piece(label, name, high - low, tuple(moved(part, to_origin) for part in parts), "")


def recoloured(piece: Piece, label: str, rgb: tuple[float, float, float]) -> Piece:
    """`piece` in one plain colour, as an instance of `label`."""
    rgba = np.array([*rgb, 1.0], np.float32)
    parts = by_material([replace(part, rgba=rgba, texture=None) for part in piece.parts])
    return replace(piece, label=label, parts=parts)


def _stairs(rng: Random) -> Shape:
    """A staircase of one storey: straight, around a corner, or spiral."""
    width, depth = rng.uniform(0.8, 1.2), rng.uniform(2.6, 3.6)
    straight = Stairs("up", "straight", 0.0, 0.0, "S", width, depth, ("left", "right"))
    width, depth = rng.uniform(1.9, 2.6), rng.uniform(2.0, 2.8)
    turning = Stairs("up", "quarter-turn", 0.0, 0.0, "S", width, depth)
    across = rng.uniform(1.4, 2.0)
    spiral = Stairs("up", "spiral", 0.0, 0.0, "S", across, across)
    place = pick(rng, (straight, replace(straight, open_sides=()), turning, spiral))
    return Shape("", list(staircase(place, rng.uniform(2.4, 3.2), rng, False).piece.parts))


SHAPES: Mapping[str, Callable[[Random], Shape]] = {
    "air conditioner": appliances.air_conditioner,
    "aquarium": ornaments.aquarium,
    "armchair": sofas.armchair,
    "backpack": textiles.backpack,
    "ball": toys.ball,
    "bathtub": bathroom.bathtub,
    "beanbag": sofas.beanbag,
    "bed": beds.bed,
    "bench": chairs.bench,
    "bicycle": toys.bicycle,
    "bidet": bathroom.bidet,
    "bookshelf": cupboards.bookshelf,
    "bunk bed": beds.bunk_bed,
    "cardboard box": textiles.cardboard_box,
    "carpet": textiles.carpet,
    "cat": toys.cat,
    "ceiling fan": appliances.ceiling_fan,
    "ceiling lamp": lights.ceiling_lamp,
    "chair": chairs.chair,
    "changing table": cupboards.changing_table,
    "chest of drawers": cupboards.chest_of_drawers,
    "christmas tree": ornaments.christmas_tree,
    "clock": electronics.clock,
    "clothes rack": cupboards.clothes_rack,
    "coat rack": household.coat_rack,
    "coffee machine": appliances.coffee_machine,
    "coffee table": tables.coffee_table,
    "computer": electronics.computer,
    "crib": beds.crib,
    "curtain": textiles.curtain,
    "desk": tables.desk,
    "dining table": tables.dining_table,
    "dishwasher": appliances.dishwasher,
    "dog": toys.dog,
    "door": windows.door,
    "dressing table": tables.dressing_table,
    "dryer": appliances.dryer,
    "drying rack": textiles.drying_rack,
    "electric fan": appliances.electric_fan,
    "filing cabinet": cupboards.filing_cabinet,
    "fire extinguisher": electronics.fire_extinguisher,
    "fireplace": ornaments.fireplace,
    "floor lamp": lights.floor_lamp,
    "flowers": ornaments.flowers,
    "folding screen": cupboards.folding_screen,
    "freezer": appliances.freezer,
    "guitar": toys.guitar,
    "high chair": toys.high_chair,
    "ironing board": household.ironing_board,
    "kitchen cabinet": cupboards.kitchen_cabinet,
    "kitchen island": tables.kitchen_island,
    "ladder": household.ladder,
    "laptop": electronics.laptop,
    "laundry basket": textiles.laundry_basket,
    "microwave": appliances.microwave,
    "mirror": ornaments.mirror,
    "nightstand": cupboards.nightstand,
    "office chair": chairs.office_chair,
    "oven": appliances.oven,
    "piano": toys.piano,
    "picture": ornaments.picture,
    "plant": ornaments.plant,
    "pool table": tables.pool_table,
    "printer": electronics.printer,
    "pushchair": toys.pushchair,
    "radiator": appliances.radiator,
    "range hood": appliances.range_hood,
    "refrigerator": appliances.refrigerator,
    "rocking horse": toys.rocking_horse,
    "shelf": household.shelf,
    "shower": bathroom.shower,
    "single bed": beds.single_bed,
    "sink": bathroom.sink,
    "sofa": sofas.sofa,
    "speaker": electronics.speaker,
    "stairs": _stairs,
    "stool": chairs.stool,
    "suitcase": textiles.suitcase,
    "table": tables.table,
    "table lamp": lights.table_lamp,
    "teddy bear": toys.teddy_bear,
    "toaster": appliances.toaster,
    "toilet": bathroom.toilet,
    "towel rack": bathroom.towel_rack,
    "trash can": textiles.trash_can,
    "tv": electronics.tv,
    "tv stand": cupboards.tv_stand,
    "umbrella": household.umbrella,
    "urinal": bathroom.urinal,
    "vacuum cleaner": household.vacuum_cleaner,
    "vase": ornaments.vase,
    "wall cabinet": cupboards.wall_cabinet,
    "wardrobe": cupboards.wardrobe,
    "washing machine": appliances.washing_machine,
    "water cooler": appliances.water_cooler,
    "water heater": bathroom.water_heater,
    "wheelchair": toys.wheelchair,
    "whiteboard": electronics.whiteboard,
    "window": windows.window,
}
"""Shapes by label, in the words of the catalogue's classes."""
