"""Which models of the Sweet Home 3D catalogue are a chair, a sofa, a bed, ...

The catalogue has names and sections, no classes. The rules were made looking at every picture.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf


@dataclass(frozen=True, slots=True)
class Rule:
    """Which models are instances of a class.

    Attributes:
        names: Pattern of the whole name, in lower case.
        heights: Least and greatest height [m].
        without: Ids of models that are not what they are called.
    """

    names: str
    heights: tuple[float, float] = (0.0, inf)
    without: tuple[str, ...] = ()

    def fits(self, model_id: str, name: str, height: float) -> bool:
        """Whether the model is an instance."""
        return (
            re.fullmatch(self.names, name.lower()) is not None
            and self.heights[0] <= height <= self.heights[1]
            and model_id not in self.without
        )


_TABLES = r"((oak|black|glass|round|folding|wooden|wooden alder) )?table( with tablecloth)?"

CLASSES: Mapping[str, Rule] = {
    "aquarium": Rule("aquarium"),
    "armchair": Rule(r"(modern |winchester )?armchair", without=("Blend Swap CC-0#armchair",)),
    "backpack": Rule("backpack"),
    "bathtub": Rule(r"((corner |island )?bath)(tub)?"),
    "bed": Rule(r"(iron |captain's |child |day )?bed"),
    "bench": Rule("bench"),
    "bidet": Rule("bidet"),
    "bookshelf": Rule(
        r"(full )?bookcase|(vertical )?shelves",
        without=("Scopia#dining_room", "Scopia#office_furniture1", "Blend Swap CC-0#shelves"),
    ),
    "bunk bed": Rule(r"(bunk|mezzanine) bed"),
    "cardboard box": Rule(r"(open )?cardboard box"),
    "carpet": Rule(r"oriental rug|round carpet"),
    "ceiling lamp": Rule(r"(chandelier|pendant|ceiling) lamp|hanging light"),
    "chair": Rule(
        r"((oak|osaka|folding|plastic) )?chair( with cushion)?",
        without=("Blend Swap CC-0#antiqueChair",),
    ),
    "chest of drawers": Rule("dresser with drawers"),
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
    "door": Rule(r"((exterior|double|glass) )?door( with panes)?"),
    "dressing table": Rule("dressing table"),
    "dryer": Rule("dryer machine"),
    "electric fan": Rule(r"(table|rigged) fan"),
    "fireplace": Rule("fireplace"),
    "floor lamp": Rule("lamp", heights=(1.0, 2.0)),
    "guitar": Rule("electric guitar"),
    "kitchen cabinet": Rule(r"(small )?(lower|drawers) cabinet|lower corner cabinet"),
    "laptop": Rule(r"laptop|apple ibook"),
    "laundry basket": Rule("clothes basket"),
    "microwave": Rule("microwave"),
    "nightstand": Rule("bedside table"),
    "oven": Rule(r"(double )?oven|(large|propane) stove"),
    "piano": Rule(r"(grand|upright) piano"),
    "plant": Rule(
        r".*plant|ficus|yucca|bamboo|cactus|bonsai tree|spathiphyllum", heights=(0.3, 2.0)
    ),
    "radiator": Rule("radiator"),
    "range hood": Rule(r"(range )?hood"),
    "refrigerator": Rule(r"(large )?fridge|refrigerator"),
    "shower": Rule("shower stall"),
    "sink": Rule(r"sink( cabinet)?|washbasin|(double )?vanity|small lavatory"),
    "sofa": Rule(
        r"((corner|winchester|burlap|clear) )?sofa( \d seats)?|convertible sofa bz|(futon )?couch"
    ),
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
    "toilet": Rule("toilets unit"),
    "trash can": Rule("dustbin|bullet trash can|recycling bin"),
    "tv": Rule(r"tv( 16:9)?|wall flat tv"),
    "tv stand": Rule("tv stand"),
    "vase": Rule("vase"),
    "wall cabinet": Rule(r"(small )?upper cabinet|glass door cabinet"),
    "wardrobe": Rule(r"wardrobe|cupboard"),
    "washing machine": Rule(r"(clothes )?washing machine"),
    "window": Rule(r".+ window( .*)?"),
}
"""Classes by label: the paper's words for its goals, common words for the rest."""
