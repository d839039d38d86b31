"""The saved maps of this machine's user: listed, shown, renamed, deleted, each by its name."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from mapping import map_bundle, map_folder
from mapping.map_bundle import load_grid
from mapping.map_folder import MapUse, is_readable
from mapping.map_header import HEADER, REMEDY
from vizbot.core.errors import ConfigError, MapError
from vizbot.core.files import user_folder
from vizbot.core.normal_text import normal_text
from vizbot.core.types import OccupancyGrid

_NAME = re.compile(r"\w(?:[\w -]|(?<=\d)\.(?=\d)){0,59}")


@dataclass(frozen=True, slots=True)
class MapEntry:
    """What the list of saved maps has of one.

    Attributes:
        name: Of its folder.
        saved_at: When it was written, in seconds since 1970.
        in_use: Whether a robot on this machine is in it.
    """

    name: str
    saved_at: float
    in_use: bool


def maps_folder() -> Path:
    """The folder of this user's saved maps."""
    return user_folder("XDG_DATA_HOME", ".local/share") / "maps"


def find_map(given: Path) -> Path:
    """The folder of the map that a person gives: a map's, a run's, or the name of a saved one.

    A folder that exists comes before a saved map of that name.

    Raises:
        MapError: there is neither.
    """
    folder, name = map_bundle.map_in(given), str(given)
    if is_readable(folder):
        return folder
    if _NAME.fullmatch(normal_text(name)) and is_readable(saved := _named(maps_folder(), name)):
        return saved
    raise MapError(f"no map at {given}: `vizbot map list` shows those saved by name, and {REMEDY}")


def _named(folder: Path, name: str) -> Path:
    """The map of a name, which need not be there: names that are written alike are the same.

    A folder whose name is written in another way, as systems that decompose letters do, is found,
    and keeps its name.
    """
    name = normal_text(name)
    with suppress(OSError):
        named = (each for each in folder.iterdir() if normal_text(each.name) == name)
        return max(named, key=lambda each: each.name == name, default=folder / name)
    return folder / name


class SavedMaps:
    """The saved maps in one folder, by their names; a `ConfigError` where one cannot be a name."""

    def __init__(self, folder: Path | None = None) -> None:
        """Look into a folder, which need not be there; this user's by default."""
        self.folder = folder or maps_folder()

    def path(self, name: str) -> Path:
        """The folder of a map, which need not be there."""
        if _NAME.fullmatch(normal_text(name)) is None:
            raise ConfigError(
                f"{name!r} is no name for a map; use letters, digits, spaces and -, 60 at most"
            )
        return _named(self.folder, name)

    def name_of(self, folder: Path) -> str | None:
        """The name of the saved map in a folder; None for a folder elsewhere."""
        folder = folder.absolute()
        name = normal_text(folder.name)
        is_one = folder.parent == self.folder.absolute() and _NAME.fullmatch(name)
        return name if is_one else None

    def maps(self) -> list[MapEntry]:
        """All of them, newest first."""
        found = []
        for header in self.folder.glob(f"*/{HEADER}"):
            name = normal_text(header.parent.name)
            with suppress(OSError):  # one that is just being replaced
                if _NAME.fullmatch(name):
                    in_use = map_folder.is_in_use(header.parent)
                    found.append(MapEntry(name, header.stat().st_mtime, in_use))
        return sorted(found, key=lambda each: (-each.saved_at, each.name))

    def grid(self, name: str) -> OccupancyGrid:
        """The obstacle map of one of them, with its zones.

        Raises:
            MapError: there is no such map, or it is damaged.
        """
        return load_grid(self.require(name))

    def rename(self, name: str, new: str) -> None:
        """Give one of them another name; a robot that is in it stays in it.

        Raises:
            MapError: there is no such map, another one has the name, or it cannot be renamed.
        """
        map_folder.move(self.require(name), self.path(new))

    def delete(self, name: str) -> None:
        """Delete one of them. Whenever that is interrupted, the map is whole or gone.

        Raises:
            MapError: there is no such map, a robot is in it, or it cannot be deleted.
        """
        map_folder.delete(self.require(name))

    def require(self, name: str) -> Path:
        """The folder of a map that is there.

        Raises:
            MapError: there is no such map.
        """
        path = self.path(name)
        if not (path / HEADER).exists():
            names = ", ".join(repr(each.name) for each in self.maps()) or "none"
            raise MapError(f"there is no saved map {name!r}; those that there are: {names}")
        return path

    def use(self, name: str) -> MapUse | None:
        """Claim one of them, so that nobody deletes it; None where it is gone."""
        with suppress(OSError):
            return MapUse(self.path(name))
        return None
