"""The list of views that the belief is fitted to an encoder by.

In each home the robot looks around once and then goes from place to place, as in a search. Homes
are ours, and those of Sweet Home 3D's examples that training may see: an encoder that knows our
homes alone would be believed too much elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from zlib import crc32

import numpy as np

from sim_stubs.homes.furniture.catalogue import CATALOGUE, read_catalogue
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.home import home
from sim_stubs.world.world_file import read_world
from vizbot.core.errors import ConfigError
from vizbot.rehearsal.belief_fit.fit import walk
from vizbot.rehearsal.belief_fit.places import Places
from vizbot.rehearsal.belief_fit.seen_home import Station

OWN_HOMES = range(916, 926)
"""Training homes from 916 on serve for this: the embedded encoder learned in 0 to 399, its
threshold was chosen in 900 to 915."""
SEEN_WORLDS = (
    "3BedroomApartment", "3BedroomHouseWithAttic", "3BedroomHouseWithMezzanine", "4BedroomHouse",
    "Studio",
)  # fmt: skip
"""Example homes of Sweet Home 3D that training may see; its other four are to judge by."""
VIEWS_OF_HOME = 80
"""Views of each home, 1,200 in all."""
JAR = Path("/usr/share/sweethome3d/sweethome3d.jar")
"""Where Debian's package `sweethome3d` has the example homes."""


@dataclass(frozen=True, slots=True)
class ListedHome:
    """A home of the list.

    Attributes:
        name: Its seed, or the name of an example home.
        jar: Sweet Home 3D, for an example home; None for one of ours.
    """

    name: str
    jar: Path | None = None

    @property
    def seed(self) -> int:
        """Of all that is drawn in it."""
        return int(self.name) if self.jar is None else crc32(self.name.encode())

    def house(self) -> House:
        """The home, the same in every process.

        Raises:
            ConfigError: it cannot be read.
        """
        return home(self.seed) if self.jar is None else read_world(self.jar / self.name)

    def stations(self, places: Places) -> list[Station]:
        """Where its views are taken from, in their order."""
        return walk(places.xy, np.random.default_rng(self.seed), VIEWS_OF_HOME)[:VIEWS_OF_HOME]


def list_homes(jar: Path | None) -> list[ListedHome]:
    """The homes of the list; without Sweet Home 3D only ours.

    Args:
        jar: `sweethome3d.jar`; None for the one that is installed, if it is.

    Raises:
        ConfigError: what is given is no file.
    """
    if jar is not None and not jar.is_file():
        raise ConfigError(f"--jar {jar} is no file; give sweethome3d.jar, or leave it out")
    found = JAR if jar is None and JAR.is_file() else jar
    ours = [ListedHome(str(seed)) for seed in OWN_HOMES]
    return ours if found is None else [*ours, *(ListedHome(name, found) for name in SEEN_WORLDS)]


def require_simulator() -> None:
    """Refuse to render without what that needs, before anything is opened.

    Raises:
        ConfigError: MuJoCo or the furniture is not installed.
    """
    if find_spec("mujoco") is None:
        raise ConfigError("simulated homes need mujoco, not installed: pip install mujoco")
    if not read_catalogue():
        raise ConfigError(
            f"there is no furniture in {CATALOGUE}, and plain shapes calibrate no encoder: apt"
            " install sweethome3d-furniture"
        )
