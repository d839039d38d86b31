"""The split of the catalogue: models that train the embedded CLIP, and models for benchmarks.

The split is by design: recolours, mirror images and other sizes of one model stay together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

from sim_stubs.homes.furniture.catalogue import Entry, instances
from sim_stubs.homes.furniture.classes import CLASSES
from sim_stubs.homes.furniture.procedural import SHAPES

TRAINING_SHARE = 0.7
"""Share of the designs of a class that are for training."""

DESIGNS: tuple[tuple[str, ...], ...] = (
    ("Blend Swap CC-0#drawersCabinet", "Blend Swap CC-0#lowerCabinet",
     "Blend Swap CC-0#lowerCornerCabinet"),
    ("Blend Swap CC-0#glassDoorCabinet", "Blend Swap CC-0#smallUpperCabinet",
     "Blend Swap CC-0#upperCabinet"),
    ("Blend Swap CC-0#radiator", "Blend Swap CC-0#radiator2"),
    ("Blend Swap CC-0#speaker2", "Blend Swap CC-0#speaker3"),
    ("Blend Swap CC-0#winchesterArmchair", "Blend Swap CC-0#winchesterSofa"),
    ("Blend Swap CC-BY#kitchenDrawersCabinet", "Blend Swap CC-BY#kitchenLowerCabinet",
     "Blend Swap CC-BY#kitchenSmallLowerCabinet"),
    ("Blend Swap CC-BY#kitchenGlassDoorCabinet", "Blend Swap CC-BY#kitchenSmallUpperCabinet",
     "Blend Swap CC-BY#kitchenUpperCabinet"),
    ("Kator Legaz#exterior-door-01", "Kator Legaz#exterior-door-02", "Kator Legaz#exterior-door-03",
     "Kator Legaz#exterior-door-05", "Kator Legaz#exterior-door-07"),
    ("Kator Legaz#mid-century-bench-sofa", "Kator Legaz#mid-century-chair",
     "Kator Legaz#mid-century-sofa"),
    ("Kator Legaz#window-01", "Kator Legaz#window-08", "Kator Legaz#window-08-02"),
    ("Scopia#beige_sofa", "Scopia#beige_sofa_2seats"),
    ("Scopia#clothes_washing_machine", "Scopia#dryer_machine"),
    ("Scopia#door", "Scopia#glass_door"),
    ("Scopia#double_door", "Scopia#double_door_2", "Scopia#double_door_with_little_part"),
    ("Scopia#electric_water_heater", "Scopia#electric_water_heater_big"),
    ("Scopia#little_lamp1", "Scopia#little_lamp2", "Scopia#little_lamp3"),
    ("Scopia#window_2x3", "Scopia#window_2x3_arched", "Scopia#window_2x3_regular",
     "Scopia#window_2x4", "Scopia#window_2x4_arched", "Scopia#window_2x6"),
    ("Scopia#window_3x1", "Scopia#window_4x1"),
    ("Scopia#window_4x3", "Scopia#window_4x3_arched", "Scopia#window_4x5"),
    ("Scopia#wooden_office_alder_table", "Scopia#wooden_office_pear_table",
     "Scopia#wooden_office_pear_table_rect", "Scopia#wooden_office_teak_table"),
)  # fmt: skip
"""Ids of the models of one design: equal but for size, colour, side or a detail.

Found by comparing the vertices of all models in their bounding boxes, mirrored as well, and by
looking at every picture.
"""

SHARED_PICTURES: Mapping[str, str] = {
    "Blend Swap CC-0#oakTable": "Blend Swap CC-0#oakChair",
    "Blend Swap CC-0#speaker2": "Blend Swap CC-0#wardrobeWithSlidingDoors",
    "Blend Swap CC-0#speaker3": "Blend Swap CC-0#wardrobeWithSlidingDoors",
    "Blend Swap CC-0#table": "Blend Swap CC-0#chairWithCushion",
    "Blend Swap CC-BY#bedsideTable": "Blend Swap CC-BY#wardrobe",
    "Blend Swap CC-BY#kitchenDrawersCabinet": "Blend Swap CC-BY#kitchenSink",
    "Blend Swap CC-BY#kitchenIsland": "Blend Swap CC-BY#kitchenSink",
    "Blend Swap CC-BY#kitchenLowerCabinet": "Blend Swap CC-BY#kitchenSink",
    "Blend Swap CC-BY#kitchenSmallLowerCabinet": "Blend Swap CC-BY#kitchenSink",
    "Blend Swap CC-BY#simpleDesk": "Blend Swap CC-BY#wardrobe",
    "Scopia#cardboard-box": "Scopia#open-cardboard-box",
    "Scopia#chair4": "Scopia#table4",
}
"""Held-out models that show a picture of a model to train on, and that one, by their ids.

In homes to judge by the parts with that picture are plain, in its mean colour.
"""


@dataclass(frozen=True, slots=True)
class Count:
    """The numbers of models of a class.

    Attributes:
        training: Number of training models in the catalogue.
        held_out: Number of held-out models in the catalogue.
        shapes: Whether there are procedural shapes as well, one for each seed.
    """

    training: int
    held_out: int
    shapes: bool


def split(entries: Sequence[Entry]) -> tuple[tuple[Entry, ...], tuple[Entry, ...]]:
    """The models of all classes, to train on and held out; no design is on both sides.

    In each class about 70 % of the designs are to train on, ordered by a hash of the id, and at
    least one is on each side; a class with a single design keeps it for the benchmark.
    Classes with few designs choose first, for designs that belong to several.
    """
    classes = {
        label: sorted({design_of(entry) for entry in instances(label, entries)}, key=_order)
        for label in CLASSES
    }
    training: set[str] = set()
    held_out: set[str] = set()
    for label in sorted(classes, key=lambda label: (len(classes[label]), label)):
        designs = classes[label]
        if not designs:
            continue
        wanted = round(TRAINING_SHARE * len(designs))
        wanted = max(1, min(wanted, len(designs) - 1)) if len(designs) > 1 else 0
        wanted -= len(training.intersection(designs))
        free = [design for design in designs if design not in training | held_out]
        training.update(free[: max(0, wanted)])
        held_out.update(free[max(0, wanted) :])
    return (
        tuple(entry for entry in entries if design_of(entry) in training),
        tuple(entry for entry in entries if design_of(entry) in held_out),
    )


def counts(entries: Sequence[Entry]) -> dict[str, Count]:
    """The numbers of models on each side of the split, by label."""
    training, held_out = split(entries)
    return {
        label: Count(
            len(instances(label, training)) if label in CLASSES else 0,
            len(instances(label, held_out)) if label in CLASSES else 0,
            label in SHAPES,
        )
        for label in sorted({*CLASSES, *SHAPES})
    }


def design_of(entry: Entry) -> str:
    """Id that stands for the design of a model: the first one of its like."""
    return next((design[0] for design in DESIGNS if entry.id in design), entry.id)


def _order(design: str) -> str:
    return sha256(design.encode()).hexdigest()
