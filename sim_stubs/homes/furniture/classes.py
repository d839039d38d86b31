"""Classes of the models of the Sweet Home 3D catalogue: chair, sofa, bed, ...

The catalogue has names and sections, no classes. The rules were made looking at every picture.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import inf


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule for the models that are instances of a class.

    Attributes:
        names: Pattern of the whole name, in lower case.
        heights: Least and greatest height [m].
        without: Ids of models that are not what they are called.
        only: Ids of the models among those of that name; empty for all of them.
    """

    names: str
    heights: tuple[float, float] = (0.0, inf)
    without: tuple[str, ...] = ()
    only: tuple[str, ...] = ()

    def fits(self, model_id: str, name: str, height: float) -> bool:
        """Whether the model is an instance."""
        return (
            self.heights[0] <= height <= self.heights[1]
            and model_id not in self.without
            and (not self.only or model_id in self.only)
            and _pattern(self.names).fullmatch(name.lower()) is not None
        )


@cache
def _pattern(names: str) -> re.Pattern[str]:
    return re.compile(names)  # for a whole catalogue `re` looks too long for what it has compiled


_TABLES = r"((oak|black|glass|round|folding|wooden|wooden alder) )?table( with tablecloth)?"

CLASSES: Mapping[str, Rule] = {
    "air conditioner": Rule("air conditioning - internal unit"),
    "aquarium": Rule("aquarium"),
    "armchair": Rule(r"(modern |winchester )?armchair", without=("Blend Swap CC-0#armchair",)),
    "backpack": Rule("backpack"),
    "ball": Rule(r"basketball|soccer ball"),
    "bathtub": Rule(r"((corner |island )?bath)(tub)?"),
    "beanbag": Rule("puff"),
    "bed": Rule(r"(iron |captain's |child |day )?bed"),
    "bench": Rule("bench"),
    "bicycle": Rule(r"bike|bicycle"),
    "bidet": Rule("bidet"),
    "bookshelf": Rule(
        r"(full )?bookcase|(vertical )?shelves",
        without=("Scopia#dining_room", "Scopia#office_furniture1", "Blend Swap CC-0#shelves"),
    ),
    "bunk bed": Rule(r"(bunk|mezzanine) bed"),
    "cardboard box": Rule(r"(open )?cardboard box"),
    "carpet": Rule(r"oriental rug|round carpet"),
    "cat": Rule(r"(siamese )?cat"),
    "ceiling fan": Rule("ceiling fan"),
    "ceiling lamp": Rule(r"(chandelier|pendant|ceiling) lamp|hanging light"),
    "chair": Rule(
        r"((oak|osaka|folding|plastic) )?chair( with cushion)?",
        without=("Blend Swap CC-0#antiqueChair",),
    ),
    "changing table": Rule("changing table"),
    "chest of drawers": Rule("dresser with drawers"),
    "christmas tree": Rule("christmas tree"),
    "clock": Rule("cuckoo clock"),
    "clothes rack": Rule("clothes rack"),
    "coffee machine": Rule(r"coffee (machine|maker|brewer)"),
    "coffee table": Rule(r"coffee table|table", heights=(0.3, 0.6)),
    "computer": Rule("apple imac.*"),
    "crib": Rule(r"crib|baby bed"),
    "curtain": Rule("curtain"),
    "desk": Rule(r"(wooden )?desk|desk table"),
    "dining table": Rule(
        rf"{_TABLES}|table on trestles",
        heights=(0.7, 0.95),
        without=("Blend Swap CC-BY#cafe_set_mota_table", "Scopia#wooden_office_pear_table"),
    ),
    "dog": Rule(r"(bull)?dog"),
    "door": Rule(r"((exterior|double|glass) )?door( with panes)?"),
    "dressing table": Rule("dressing table"),
    "dryer": Rule("dryer machine"),
    "drying rack": Rule("clothes horse"),
    "electric fan": Rule(r"(table|rigged) fan"),
    "filing cabinet": Rule("filing cabinet"),
    "fire extinguisher": Rule("extinguisher"),
    "fireplace": Rule("fireplace"),
    "floor lamp": Rule("lamp", heights=(1.0, 2.0)),
    "flowers": Rule(r"flowers|tulips|orchids|white lily"),
    "folding screen": Rule("screen"),
    "freezer": Rule("chest freezer"),
    "guitar": Rule("electric guitar"),
    "high chair": Rule("baby high chair"),
    "kitchen cabinet": Rule(r"(small )?(lower|drawers) cabinet|lower corner cabinet"),
    "kitchen island": Rule(r"island( extension)?"),
    "ladder": Rule(r"(small )?step ladder"),
    "laptop": Rule(r"laptop|apple ibook"),
    "laundry basket": Rule("clothes basket"),
    "microwave": Rule("microwave"),
    "nightstand": Rule("bedside table"),
    "office chair": Rule(
        "chair",
        only=(
            "Kator Legaz#office-chair",
            "Scopia#kids_desk_chair",
            "Scopia#office_chair",
        ),
    ),
    "oven": Rule(r"(double )?oven|(large|propane) stove"),
    "piano": Rule(r"(grand|upright) piano"),
    "plant": Rule(
        r".*plant|ficus|yucca|bamboo|cactus|bonsai tree|spathiphyllum", heights=(0.3, 2.0)
    ),
    "pool table": Rule("pool table"),
    "printer": Rule("inkjet printer and scanner"),
    "pushchair": Rule("stroller"),
    "radiator": Rule("radiator"),
    "range hood": Rule(r"(range )?hood"),
    "refrigerator": Rule(r"(large )?fridge|refrigerator"),
    "rocking horse": Rule("rocking horse"),
    "shower": Rule("shower stall"),
    "single bed": Rule(r"(captain's |child )bed"),
    "sink": Rule(r"sink( cabinet)?|washbasin|(double )?vanity|small lavatory"),
    "sofa": Rule(
        r"((corner|winchester|burlap|clear) )?sofa( \d seats)?|convertible sofa bz|(futon )?couch"
    ),
    "speaker": Rule("speaker"),
    "stairs": Rule("spiral staircase"),
    "stool": Rule(r"(bar )?stool|bar chair"),
    "suitcase": Rule("suitcase"),
    "table": Rule(rf"{_TABLES}|(coffee|bar) table|table on trestles"),
    "table lamp": Rule(
        r"((desk|little|pedestal vase) )?lamp",
        heights=(0.2, 1.0),
        without=("Blend Swap CC-0#lamp2",),
    ),
    "teddy bear": Rule("teddy bear"),
    "toaster": Rule("toaster"),
    "toilet": Rule("toilets unit"),
    "towel rack": Rule("towel rack"),
    "trash can": Rule("dustbin|bullet trash can|recycling bin"),
    "tv": Rule(r"tv( 16:9)?|wall flat tv"),
    "tv stand": Rule("tv stand"),
    "umbrella": Rule("umbrella", heights=(0.5, 1.2)),
    "urinal": Rule("urinal"),
    "vase": Rule("vase"),
    "wall cabinet": Rule(r"(small )?upper cabinet|glass door cabinet"),
    "wardrobe": Rule(r"wardrobe|cupboard"),
    "washing machine": Rule(r"(clothes )?washing machine"),
    "water cooler": Rule("water cooler"),
    "water heater": Rule(r"(electric|gaz) water heater"),
    "wheelchair": Rule("wheelchair"),
    "whiteboard": Rule("white board"),
    "window": Rule(r".+ window( .*)?"),
}
"""Classes by label: the paper's words for its goals, common words for the rest."""


@cache
def classes_of(model_id: str, name: str, height: float) -> frozenset[str]:
    """Labels of the classes that a model is an instance of.

    Args:
        model_id: Its id.
        name: Its name in the catalogue.
        height: Its height [m].
    """
    return frozenset(label for label, rule in CLASSES.items() if rule.fits(model_id, name, height))
