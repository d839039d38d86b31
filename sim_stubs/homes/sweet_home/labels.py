"""Labels of pieces in a Sweet Home 3D home, by their own names or those of their catalogue."""

from __future__ import annotations

from collections.abc import Mapping

from sim_stubs.homes.furniture.classes import CLASSES
from sim_stubs.homes.sweet_home.plan import ListedPiece, plain_name
from vizbot.core.home_vocabulary import THINGS, class_of

LOW = 0.6
"""Height below which a table is a coffee table [m]."""

_TABLES = ("table", "round table", "square table", "oval table", "rectangular table")
_UNTOLD = ("box",)
"""Names without meaning: owners build everything else from blocks."""
_NAMES: Mapping[str, str] = {
    "chest": "chest of drawers",
    "clothes washer": "washing machine",
    "corner bunk bed": "bunk bed",
    "corner sofa": "sofa",
    "curve staircase": "stairs",
    "electric radiator": "radiator",
    "fitted bath": "bathtub",
    "flat tv": "tv",
    "floor uplight": "floor lamp",
    "fridge & freezer": "refrigerator",
    "fridge freezer": "refrigerator",
    "hood": "range hood",
    "hot water radiator": "radiator",
    "kitchen upper cabinet": "wall cabinet",
    "pendant lamp": "ceiling lamp",
    "spiral staircase": "stairs",
    "toilet unit": "toilet",
    "tv unit": "tv stand",
    "wall uplight": "wall lamp",
    "washbasin with cabinet": "sink",
    "work lamp": "table lamp",
}
"""Names in the program's own catalogue that differ from our classes."""


def label_of(item: ListedPiece) -> str | None:
    """The class of a piece; None without one, as for beams, pipes and blocks."""
    for name in (plain_name(item.name), item.catalogue_name):
        if name in _TABLES:
            return "coffee table" if item.size[2] < LOW else "dining table"
        if name in _NAMES:
            return _NAMES[name]
        label = class_of(name)
        if label in THINGS and label not in _UNTOLD:
            return label
        fitting = (label for label, rule in CLASSES.items() if rule.fits("", name, item.size[2]))
        if (label := next(fitting, None)) is not None:
            return label
    return None
