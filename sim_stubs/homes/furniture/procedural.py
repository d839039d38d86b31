"""Procedural furniture: recognisable, metric, of many looks.

The embedded CLIP is trained on it beside models, and homes without a catalogue have nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from sim_stubs.homes.floor_plan.staircase import staircase
from sim_stubs.homes.floor_plan.stairs import Stairs
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
from sim_stubs.homes.geometry.solids import Piece, by_material, moved_part, stretched, triangles
from vizbot.core.errors import ConfigError


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
