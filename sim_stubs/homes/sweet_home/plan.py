"""Pieces in the plan of a Sweet Home 3D home, in metres, y to the north.

In the file lengths are centimetres, y runs down the screen and angles run clockwise.

A `.sh3d` file is a zip archive: `Home.xml`, and the models and pictures that it refers to by their
names in the archive. The example homes lie in the same form in the program's own
`sweethome3d.jar`; they are named as if the archive were a folder: `sweethome3d.jar/Studio`.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import cos, sin
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.extent import WIDEST
from vizbot.core.errors import ConfigError

_EXAMPLES = "com/eteks/sweethome3d/io/resources/examples/"
_PLAN = "Home.xml"
Rgb = tuple[float, float, float]
_UPRIGHT = "1 0 0 0 1 0 0 0 1"
_FARTHEST = 10.0 * WIDEST
"""Largest coordinate in a plan, whose origin may be anywhere on a site [m]."""
_FURNITURE = ("pieceOfFurniture", "light", "doorOrWindow")


@dataclass(frozen=True, slots=True, eq=False)
class HomeFile:
    """An open file.

    Attributes:
        plan: The element `home`.
        archive: Holds models and pictures by the names that the plan gives them.
        content: The same as a folder.
    """

    plan: ElementTree.Element
    archive: zipfile.ZipFile
    content: zipfile.Path


def is_home(path: Path) -> bool:
    """Whether the path names a home: a `.sh3d` file, or one in a `.jar`."""
    return path.suffix == ".sh3d" or path.suffix == ".jar" or path.parent.suffix == ".jar"


@contextmanager
def open_home_file(path: Path) -> Iterator[HomeFile]:
    """The home that `path` names, open for reading.

    Raises:
        ConfigError: there is no such home in it, or it cannot be read.
    """
    in_jar = path.parent.suffix == ".jar"
    file = path.parent if in_jar else path
    try:
        with zipfile.ZipFile(file) as archive:
            name = f"{_EXAMPLES}{path.name}.xml" if in_jar else _PLAN
            if name not in archive.namelist():
                raise ConfigError(_missing(path, archive))
            plan = ElementTree.fromstring(archive.read(name))
            yield HomeFile(plan, archive, zipfile.Path(archive))
    except (OSError, EOFError, zipfile.BadZipFile) as error:
        raise ConfigError(f"world {file} is no .sh3d file ({error}); save it again") from error
    except ElementTree.ParseError as error:
        raise ConfigError(f"world {path}: the plan is torn ({error}); save it again") from error


def _missing(path: Path, archive: zipfile.ZipFile) -> str:
    examples = [
        Path(name).stem
        for name in sorted(archive.namelist())
        if name.startswith(_EXAMPLES) and name.endswith(".xml")
    ]
    if examples:
        jar = path if path.suffix == ".jar" else path.parent
        return f"world {path}: take one of {', '.join(f'{jar}/{name}' for name in examples)}"
    return f"world {path} holds no {_PLAN}; save it with Sweet Home 3D 5.3 or newer"


@dataclass(frozen=True, slots=True)
class SurfaceStyle:
    """A colour or a picture given to a surface.

    Attributes:
        rgb: In [0, 1]; None for a surface that is made invisible.
        image: Name of a picture in the file, instead of the colour; None for plain.
        width: Width of one copy of the picture [m].
        height: Height of one copy of the picture [m].
    """

    rgb: Rgb | None
    image: str | None = None
    width: float = 1.0
    height: float = 1.0


@dataclass(frozen=True, slots=True)
class ListedPiece:
    """A piece of furniture, a lamp, a door or a window.

    Attributes:
        is_opening: Whether it is a door or a window.
        name: Its owner's name for it ("Coffee table").
        catalogue_id: Its model in the catalogue of its library ("eTeks#bedsideTable").
        creator: Author of the model.
        model: Name of the model in the file.
        x: Middle of its footprint [m].
        y: Middle of its footprint [m].
        yaw: Yaw; at 0 its front faces -y [rad].
        elevation: Height above the floor of its level [m].
        size: Width, depth, height [m].
        rotation: Row-major 3x3 that brings the model upright.
        tilt: Pitch about its width and roll about its depth [rad].
        mirrored: Whether left and right are exchanged.
        look: Look of the whole piece, if it was changed.
        materials: Name and look of single materials that were changed.
        in_wall: From its back, where the wall begins and ends, as shares of its depth.
    """

    is_opening: bool
    name: str
    catalogue_id: str
    creator: str
    model: str
    x: float
    y: float
    yaw: float
    elevation: float
    size: tuple[float, float, float]
    rotation: tuple[float, ...]
    tilt: tuple[float, float]
    mirrored: bool
    look: SurfaceStyle | None
    materials: tuple[tuple[str, SurfaceStyle], ...]
    in_wall: tuple[float, float]

    @property
    def catalogue_name(self) -> str:
        """Its catalogue's name in English words ("bedside table")."""
        return plain_name(re.sub(r"([A-Z])", r" \1", self.catalogue_id.rpartition("#")[2]))

    @property
    def wall_centre(self) -> NDArray[np.float64]:
        """(2,) middle of the part of an opening that is in the wall [m]."""
        return np.array([self.x, self.y]) + self.facing * self.wall_offset

    @property
    def wall_offset(self) -> float:
        """Distance of the middle of the wall in front of the middle of an opening [m]."""
        return self.size[1] * (sum(self.in_wall) / 2 - 0.5)

    @property
    def facing(self) -> NDArray[np.float64]:
        """(2,) unit vector out of its front."""
        return np.array([sin(self.yaw), -cos(self.yaw)])


def ground_level(plan: Element) -> str | None:
    """Id of the level nearest to the ground; None for a home without levels."""
    levels = [level for level in plan.iter("level") if level.get("viewable") != "false"]
    lowest = min(levels, key=lambda level: abs(metres(level, "elevation")), default=None)
    return None if lowest is None else lowest.get("id")


def list_pieces(plan: Element, level: str | None) -> list[ListedPiece]:
    """Everything with a model that is on a level and visible, in the file's order."""
    return [_listed(element) for element in _visible(plan, level, level)]


def metres(element: Element, name: str, default: float = 0.0) -> float:
    """A length of an element [m].

    Raises:
        ValueError: it is no number, or too large for a plan.
    """
    return _metres(name, element.get(name, default * 100.0), WIDEST)


def point(element: Element, x: str = "x", y: str = "y") -> NDArray[np.float64]:
    """(2,) a point of an element [m].

    Raises:
        KeyError: it has none.
        ValueError: a coordinate is no number, or too large for a plan.
    """
    at = [_metres(name, element.attrib[name], _FARTHEST) for name in (x, y)]
    return np.array([at[0], -at[1]])


def look(element: Element, colour: str, texture: str | None = None) -> SurfaceStyle | None:
    """Its texture with this attribute, else this colour; None where it has neither."""
    for child in element.findall("texture"):
        if child.get("attribute") == texture:
            size = (metres(child, "width", 1.0), metres(child, "height", 1.0))
            return SurfaceStyle((1.0, 1.0, 1.0), child.attrib["image"], *size)
    value = element.get(colour)
    return None if value is None else SurfaceStyle(_rgb(value))


def plain_name(name: str) -> str:
    """A name in lower case without numbers: "Bedroom #2" is "bedroom"."""
    return " ".join(re.sub(r"#?\d+(x\d+)?", " ", name).casefold().split())


def _metres(name: str, centimetres: str | float, most: float) -> float:
    length = float(centimetres) / 100.0
    if not abs(length) <= most:
        raise ValueError(f"{name} is {length:g} m, of {most:g} m at most")
    return length


def _visible(element: Element, level: str | None, inherited: str | None) -> Iterator[Element]:
    for child in element:
        if child.get("visible") == "false" or child.tag not in (*_FURNITURE, "furnitureGroup"):
            continue
        own = child.get("level", inherited)
        if child.tag == "furnitureGroup":
            yield from _visible(child, level, own)
        elif own == level and child.get("model"):
            yield child


def _listed(element: Element) -> ListedPiece:
    x, y = point(element)
    wall = float(element.get("wallDistance", 0.0))
    return ListedPiece(
        is_opening=element.tag == "doorOrWindow",
        name=element.get("name", ""),
        catalogue_id=element.get("catalogId", ""),
        creator=element.get("creator", "unknown author"),
        model=element.attrib["model"].lstrip("/"),
        x=float(x),
        y=float(y),
        yaw=-float(element.get("angle", 0.0)),
        elevation=metres(element, "elevation"),
        size=(metres(element, "width"), metres(element, "depth"), metres(element, "height")),
        rotation=tuple(float(n) for n in element.get("modelRotation", _UPRIGHT).split()),
        tilt=(float(element.get("pitch", 0.0)), float(element.get("roll", 0.0))),
        mirrored=element.get("modelMirrored") == "true",
        look=look(element, "color"),
        materials=tuple(
            (child.get("name", ""), changed)
            for child in element.findall("material")
            if (changed := look(child, "color")) is not None
        ),
        in_wall=(wall, wall + float(element.get("wallThickness", 1.0))),
    )


def _rgb(value: str) -> Rgb | None:
    """Colour of AARRGGBB; the program writes a plain 0 for a material that is not to be seen."""
    if int(value, 16) == 0:
        return None
    red, green, blue = bytes.fromhex(value.zfill(8))[1:]
    return red / 255, green / 255, blue / 255
