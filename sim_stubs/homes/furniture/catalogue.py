"""Furniture of the Sweet Home 3D catalogue, from Debian's package `sweethome3d-furniture`.

A library is a zip file (`.sh3f`) of models and a list of them, `PluginFurnitureCatalog.properties`
(Sweet Home 3D user's guide, "Furniture library file format"). A model is converted once and kept
under `~/.cache/vizbot/furniture` (`furniture.cache`).

The catalogue has names and sections, no classes. The rules were made looking at every picture.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sim_stubs.homes.furniture import cache as piece_cache
from sim_stubs.homes.geometry.solids import Piece
from vizbot.core.errors import ConfigError

if TYPE_CHECKING:
    from sim_stubs.homes.furniture.conversion import ConvertedPart

CATALOGUE = Path("/usr/share/sweethome3d/furniture")
"""Folder of the libraries of Debian's package `sweethome3d-furniture`."""
_LIST = "PluginFurnitureCatalog.properties"
_UPRIGHT = "1 0 0 0 1 0 0 0 1"
_OUTDOORS = ("Exterior",)


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
def _pattern(names: str) -> re.Pattern[str]:
    return re.compile(names)  # for a whole catalogue `re` looks too long for what it has compiled


@cache
def classes_of(model_id: str, name: str, height: float) -> frozenset[str]:
    """Labels of the classes that a model with this name and `height` [m] is an instance of."""
    return frozenset(label for label, rule in CLASSES.items() if rule.fits(model_id, name, height))


@dataclass(frozen=True, slots=True)
class Entry:
    """One model as a library lists it.

    Attributes:
        id: Unique over all libraries ("Scopia#bed1").
        name: English name ("Bed").
        category: Section of the catalogue ("Bedroom").
        size: Width, depth, height [m]: along x, y, z of the piece.
        elevation: Height above the floor at which it hangs [m]; a loaded piece stands on z = 0.
        rotation: Row-major 3x3 that brings the model upright and its front towards its +z.
        creator: Author of the model.
        licence: Licence of the library.
        library: The `.sh3f` file.
        model: OBJ file in it.
    """

    id: str
    name: str
    category: str
    size: tuple[float, float, float]
    elevation: float
    rotation: tuple[float, ...]
    creator: str
    licence: str
    library: Path
    model: str


def read_catalogue(folder: Path = CATALOGUE) -> tuple[Entry, ...]:
    """Every model of the libraries in `folder`, ordered by id; empty without the package.

    Raises:
        ConfigError: A library cannot be read.
    """
    entries = [entry for path in folder.glob("*.sh3f") for entry in _read_library(path)]
    return tuple(sorted(entries, key=lambda entry: entry.id))


def instances(label: str, entries: Sequence[Entry]) -> tuple[Entry, ...]:
    """The `entries` of class `label` meant for indoors, in their order.

    Raises:
        ConfigError: `label` is no class.
    """
    if label not in CLASSES:
        raise ConfigError(f"furniture class {label!r} is unknown: take one of {', '.join(CLASSES)}")
    return tuple(
        entry
        for entry in entries
        if entry.category not in _OUTDOORS
        and label in classes_of(entry.id, entry.name, entry.size[2])
    )


def load_model(
    entry: Entry, label: str, max_triangles: int = 3000, max_texture: int = 256
) -> Piece:
    """The model of `entry` as an instance of `label`, from the cache or converted now.

    Texture coordinates of its parts run u to the right and v down the image, from the top left
    corner, and repeat outside [0, 1].

    Args:
        entry: Entry of the model.
        label: Class given to the piece.
        max_triangles: Approximate limit; with 3000 triangles furniture stays recognisable.
        max_texture: Longest side of a texture [px].

    Raises:
        ConfigError: The model cannot be read, or the cache cannot be written.
    """
    try:
        library = entry.library.stat()
        key = repr((entry, library.st_size, library.st_mtime_ns, max_triangles, max_texture))
        parts = piece_cache.load_parts(key)
        if parts is None:
            parts = piece_cache.store_parts(key, _converted(entry, max_triangles, max_texture))
    except (OSError, zipfile.BadZipFile) as error:
        raise ConfigError(f"furniture library {entry.library} cannot be read: {error}") from error
    return Piece(
        label=label,
        name=entry.name,
        size=np.array(entry.size),
        parts=parts,
        attribution=f"{entry.name} ({entry.id}) by {entry.creator}, {entry.licence}",
    )


def _converted(entry: Entry, max_triangles: int, max_texture: int) -> tuple[ConvertedPart, ...]:
    from sim_stubs.homes.furniture.conversion import convert  # loads numba and much of SciPy

    folder, _, name = entry.model.rpartition("/")
    with zipfile.ZipFile(entry.library) as archive:
        return convert(
            zipfile.Path(archive, f"{folder}/"),
            name,
            np.array(entry.rotation).reshape(3, 3),
            np.array(entry.size),
            max_triangles,
            max_texture,
        )


def _read_library(path: Path) -> list[Entry]:
    try:
        with zipfile.ZipFile(path) as archive:
            text = archive.read(_LIST).decode("latin-1")
        common, models = _properties(text)
        return [
            _entry(path, common, fields)
            for _, fields in sorted(models.items())
            if "model" in fields
        ]
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise ConfigError(
            f"furniture library {path} cannot be read ({error}): reinstall sweethome3d-furniture"
        ) from error


def _properties(text: str) -> tuple[dict[str, str], dict[int, dict[str, str]]]:
    """Fields of the library ("name=...") and of each model by number ("name#7=...")."""
    common: dict[str, str] = {}
    models: dict[int, dict[str, str]] = {}
    for line in text.splitlines():
        if match := re.match(r"(\w+)(?:#(\d+))?\s*=\s*(.*)", line.strip()):
            key, number, value = match.groups()
            fields = models.setdefault(int(number), {}) if number else common
            # Java writes what is not Latin-1 as \uXXXX.
            fields[key] = re.sub(r"\\u([0-9a-fA-F]{4})", lambda m: chr(int(m[1], 16)), value)
    return common, models


def _entry(path: Path, common: Mapping[str, str], fields: Mapping[str, str]) -> Entry:
    width, depth, height = (float(fields[key]) / 100.0 for key in ("width", "depth", "height"))
    return Entry(
        id=fields["id"],
        name=fields["name"],
        category=fields.get("category", ""),
        size=(width, depth, height),
        elevation=float(fields.get("elevation", 0.0)) / 100.0,
        rotation=tuple(float(number) for number in fields.get("modelRotation", _UPRIGHT).split()),
        creator=fields.get("creator", "unknown author"),
        licence=" ".join(common.get("license", "licence not stated").split()),
        library=path,
        model=fields["model"].lstrip("/"),
    )
