"""The map that a running robot has, and those that are kept: asked, limited, saved, changed.

Its functions wait for the robot's loop; call them from threads that may wait.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from datetime import datetime
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mapping import map_bundle
from mapping.map_bundle import MapBundle
from vizbot.core.errors import ConfigError, DeviceTimeoutError, MapError
from vizbot.core.observation import Outcome
from vizbot.operator.answers import Answer, look_up
from vizbot.operator.desk import Desk
from vizbot.operator.household import HOUSEHOLD
from vizbot.pipeline import Pipeline
from vizbot.tasks import Goal

T = TypeVar("T")

_WITHIN = 10.0
"""A robot that is busy for longer is asked again [s]."""
_NAME = re.compile(r"\w[\w -]{0,59}")
_WORTH_KEEPING = 0.5
"""A map that is left is kept where the camera has moved so far [m]."""


def maps_folder() -> Path:
    """Where this user's maps are kept."""
    home = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    return Path(home) / "vizbot" / "maps"


class Atlas:
    """Of one running robot."""

    def __init__(self, desk: Desk, folder: Path | None = None) -> None:
        """Nothing is asked yet.

        Args:
            desk: Of the robot.
            folder: Where maps are kept; this user's by default.
        """
        self._desk = desk
        self._folder = folder or maps_folder()
        self._household: list[Goal] = []

    def places(self, text: str) -> Answer:
        """Where what these words ask for is.

        Raises:
            ConfigError: too much is asked at once.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """
        goal, bundle, agreement = self._wait(
            lambda pipeline: (
                pipeline.goal(text),
                pipeline.bundle(),
                pipeline.config.objectnav.agreement,
            )
        )
        if bundle is None:
            return Answer(text, Outcome.NOT_FOUND, goal.threshold, ())
        return look_up(bundle, text, goal.embedding, goal.threshold, agreement)

    def vocabulary(self) -> list[str]:
        """What of a household the map finds, in alphabetical order.

        Raises:
            ConfigError: too much is asked at once.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """
        bundle, goal_of = self._wait(lambda pipeline: (pipeline.bundle(), pipeline.goal))
        if bundle is None or len(bundle.elements.keyframes) == 0:
            return []
        if not self._household:  # no text is embedded twice
            self._household = [goal_of(phrase) for phrase in sorted(HOUSEHOLD)]
        asked = np.array([goal.embedding for goal in self._household])
        best = (bundle.elements.embeddings @ asked.T).max(axis=0)
        found = zip(self._household, best, strict=True)
        return [goal.text for goal, similarity in found if similarity > goal.threshold]

    def keep_out(self) -> tuple[NDArray[np.float32], ...]:
        """Zones that the robot must not enter."""
        return self._wait(lambda pipeline: pipeline.keep_out)

    def forbid(self, zones: Sequence[NDArray[np.float32]]) -> None:
        """Have the robot keep out of these zones and no others."""

        def change(pipeline: Pipeline) -> None:
            pipeline.keep_out = tuple(zones)

        self._wait(change)
        self._desk.write("map", f"{len(zones)} keep-out zones")

    def names(self) -> list[str]:
        """Of the maps that are kept, the newest first."""
        if not self._folder.is_dir():
            return []
        kept = [path for path in self._folder.iterdir() if (path / map_bundle.HEADER).is_file()]
        kept.sort(key=lambda path: -(path / map_bundle.HEADER).stat().st_mtime)
        return [path.name for path in kept]

    def save(self, name: str, *, replace: bool = False) -> None:
        """Keep the map as it is now.

        Raises:
            ConfigError: the name is none, or another map has it.
            MapError: there is no map yet, or it cannot be written.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """
        path = self._path(name)
        if path.exists() and not replace:
            raise ConfigError(f"there is a map {name!r} already; take another name or replace it")
        bundle = self._wait(lambda pipeline: pipeline.bundle())
        if bundle is None:
            raise MapError("the robot has no map yet; ask again when it has seen something")
        self._keep(bundle, path)
        self._desk.write("map", f"the map is kept as {name!r}")

    def begin(self, name: str | None) -> str | None:
        """Have the robot leave its map and go on in one that is kept, or with None in an empty one.

        Returns:
            The name under which the map it has left is kept; None where that holds too little.

        Raises:
            ConfigError: the name is none, or the robot has something to do.
            MapError: there is no such map, or the robot cannot use it.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """
        kept = None if name is None else map_bundle.load(self._path(name))
        left_as = f"left {datetime.now():%Y-%m-%d %H-%M-%S}"
        left = self._wait(lambda pipeline: pipeline.bundle())
        worth = left is not None and _extent(left) > _WORTH_KEEPING
        if left is not None and worth:  # before it is gone
            self._keep(left, self._path(left_as))

        def begin(pipeline: Pipeline) -> None:
            if self._desk.agenda.current() is not None:
                raise ConfigError("the robot has something to do; stop it before it changes maps")
            pipeline.begin_map(kept)
            self._desk.begin_map()

        self._wait(begin)
        self._desk.write("map", "a new map begins" if name is None else f"goes on in {name!r}")
        return left_as if worth else None

    def _path(self, name: str) -> Path:
        if _NAME.fullmatch(name) is None:
            raise ConfigError(f"{name!r} is no name for a map; use letters, digits, spaces and -")
        return self._folder / name

    def _keep(self, bundle: MapBundle, path: Path) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            map_bundle.save(bundle, path)
        except OSError as error:
            raise MapError(f"{path} cannot be written: {error.strerror}") from error

    def _wait(self, job: Callable[[Pipeline], T]) -> T:
        try:
            return self._desk.between_steps(job).result(_WITHIN)
        except (TimeoutError, CancelledError) as error:
            raise DeviceTimeoutError("the robot is busy or ends; ask again") from error


def _extent(bundle: MapBundle) -> float:
    """Diagonal of what the camera has passed through [m]."""
    poses = bundle.final_poses()
    return float(np.linalg.norm(np.ptp(poses[:, :3, 3], axis=0))) if len(poses) else 0.0
