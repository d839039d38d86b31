"""Sources of furniture for training homes and for held-out homes, without common models.

A training home draws about half of its furniture from the catalogue's training models, and half
from procedural shapes. A held-out home draws held-out models of the catalogue, and for classes that
the catalogue lacks procedural shapes with other seeds; where the two take turns, `procedural` says
so. No picture is on furniture of both sides.

The split of the catalogue is by design: recolours, mirror images and other sizes of one model stay
together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from hashlib import sha256

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.furniture.appearance import mean_colour
from sim_stubs.homes.furniture.catalogue import CLASSES, Entry, instances, load_model
from sim_stubs.homes.furniture.fitting import Source
from sim_stubs.homes.furniture.procedural import SHAPES
from sim_stubs.homes.geometry.solids import Part, Piece, moved_part
from vizbot.core.errors import ConfigError

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
HANGING: Mapping[str, float] = {
    "air conditioner": 1.9,
    "clock": 1.3,
    "curtain": 0.05,
    "mirror": 1.1,
    "picture": 1.2,
    "range hood": 1.6,
    "shelf": 1.3,
    "towel rack": 0.8,
    "wall cabinet": 1.45,
    "water heater": 1.2,
    "window": 0.9,
}
"""Classes that hang on a wall, and the usual height of their lower edge [m].

Every other piece stands on the floor, or on a piece. A model that hangs there all the same, as a
washbasin does, comes with the gap below it, as if it stood.
"""
CEILING = ("ceiling fan", "ceiling lamp")
"""Classes that hang from the ceiling, by their upper edge."""
_DRAWS = 50
_GOAL_KIN = ("armchair", "chair", "high chair", "office chair", "stool", "wheelchair")
"""Classes of chairs, none of which is yellow, because a yellow chair is the goal."""
_ON_A_STAND = ("tv",)
"""Classes whose models may hang in the catalogue but stand on furniture here."""
YELLOW_SHARE = 0.02
"""A chair with a larger share of yellow in one of its parts could be taken for the goal."""


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


def furniture_source(
    entries: Sequence[Entry], held_out: bool, shapes: Source | None = None
) -> Source:
    """The source of pieces for one side of the split; it raises `ConfigError` for an unknown label.

    Args:
        entries: The models; empty without a catalogue.
        held_out: Whether the pieces are those of held-out homes.
        shapes: Source of procedural shapes; None for shapes whose seeds the caller's generator
            draws.
    """
    models, known = _models(tuple(entries), held_out)
    shape = partial(_drawn_shape, held_out) if shapes is None else shapes
    by_id = {entry.id: entry for entry in entries}
    standing = cache(_standing)  # a home draws most of its models several times

    def piece(label: str, rng: np.random.Generator) -> Piece:
        for _ in range(_DRAWS):
            drawn = draw(label, rng)
            if label not in _GOAL_KIN or not _has_yellow(drawn):
                return drawn
        raise ConfigError(f"every {label} is yellow, which is the goal's colour: add others")

    def draw(label: str, rng: np.random.Generator) -> Piece:
        candidates = models.get(label, ())
        from_catalogue = bool(candidates) and (
            held_out or label not in procedural.SHAPES or rng.random() < 0.5
        )
        if from_catalogue:
            entry = candidates[rng.integers(len(candidates))]
            twin = by_id.get(SHARED_PICTURES.get(entry.id, "")) if held_out else None
            model = standing(entry, label)
            return model if twin is None else _without_pictures(model, load_model(twin, label))
        if held_out and label in known:
            raise ConfigError(f"the catalogue has no held-out {label}: correct the split")
        return shape(label, rng)

    return piece


@lru_cache(maxsize=4)
def _models(
    entries: tuple[Entry, ...], held_out: bool
) -> tuple[Mapping[str, tuple[Entry, ...]], frozenset[str]]:
    """The models on a side of the split by class, and the classes that have any on either side."""
    side = split(entries)[1 if held_out else 0]
    models = {label: instances(label, side) for label in CLASSES}
    return models, frozenset(label for label in CLASSES if instances(label, entries))


def _drawn_shape(held_out: bool, label: str, rng: np.random.Generator) -> Piece:
    """A shape of a seed that `rng` draws: even ones train and odd ones judge."""
    seed = 2 * int(rng.integers(2**40)) + int(held_out)
    shape = procedural.piece(label, np.random.default_rng(seed), held_out)
    return replace(shape, shape=f"{label} {seed}")


def _standing(entry: Entry, label: str) -> Piece:
    """A model with its origin on the floor, on a piece, or where its class hangs."""
    piece = load_model(entry, label)
    if entry.elevation == 0.0 or label in (*HANGING, *CEILING, *_ON_A_STAND):
        return piece
    lift = np.eye(4)
    lift[2, 3] = entry.elevation
    return replace(
        piece,
        size=piece.size + np.array([0.0, 0.0, entry.elevation]),
        parts=tuple(moved_part(part, lift) for part in piece.parts),
    )


def _without_pictures(piece: Piece, other: Piece) -> Piece:
    """`piece` with plain parts, in the mean colour, where it shows a picture of the `other`."""
    pictures = {part.texture for part in other.parts} - {None}
    parts = (
        replace(part, rgba=np.array([*mean_colour(part), part.rgba[3]], np.float32), texture=None)
        if part.texture in pictures
        else part
        for part in piece.parts
    )
    return replace(piece, parts=tuple(parts))


def _has_yellow(piece: Piece) -> bool:
    return any(_yellow_share(part) > YELLOW_SHARE for part in piece.parts)


def _yellow_share(part: Part) -> float:
    """Share of a part's colours, 0 to 1, that are saturated and between orange and lime."""
    colours: NDArray[np.float32] = part.rgba[None, None, :3].astype(np.float32)
    if part.texture is not None:
        texture = cv2.imread(str(part.texture))
        if texture is not None:
            colours = colours * (texture[..., ::-1].astype(np.float32) / np.float32(255.0))
    hue, saturation, value = np.moveaxis(cv2.cvtColor(colours, cv2.COLOR_RGB2HSV), 2, 0)
    return float(np.mean((hue > 38) & (hue < 75) & (saturation > 0.5) & (value > 0.3)))
