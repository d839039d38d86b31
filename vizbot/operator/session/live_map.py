"""The map that a running robot has, and those that are kept: asked, limited, saved, changed.

Its functions wait for the robot's loop; call them from threads that may wait.
"""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mapping import map_bundle
from mapping.map_bundle import MapBundle
from vizbot.core.errors import ConfigError, DeviceTimeoutError, MapError
from vizbot.core.observer import Outcome
from vizbot.core.types import Tracking
from vizbot.objectnav.tasks import Goal
from vizbot.operator.session.place_answers import Answer, find_places, summary
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.pipeline import Pipeline

T = TypeVar("T")

MOST_ZONES = 100
_WITHIN = 10.0
"""A robot that is busy for longer is asked again [s]."""
_NAME = re.compile(r"\w[\w -]{0,59}")


def maps_folder() -> Path:
    """Where this user's maps are kept."""
    home = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    return Path(home) / "vizbot" / "maps"


class LiveMap:
    """Of one running robot."""

    def __init__(self, session: OperatorSession, folder: Path | None = None) -> None:
        """Nothing is asked yet.

        Args:
            session: Of the robot.
            folder: Where maps are kept; this user's by default.
        """
        self._session = session
        self._folder = folder or maps_folder()
        self._household: list[Goal] = []
        self._saving = threading.Lock()

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
        return find_places(bundle, text, goal.embedding, goal.threshold, agreement)

    def summary(self, answer: Answer) -> str:
        """An answer in a line, seen from where the robot is now."""
        step = self._session.newest_step()
        if step is None or step.estimate.tracking is Tracking.LOST:
            return summary(answer, None)
        return summary(answer, step.T_map_base)

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

    def set_keep_out(self, zones: Sequence[NDArray[np.float32]]) -> None:
        """Have the robot keep out of these zones and no others."""

        def change(pipeline: Pipeline) -> None:
            self._change_zones(pipeline, tuple(zones))

        self._wait(change)

    def add_zone(self, zone: NDArray[np.float32]) -> int:
        """Have the robot keep out of one more zone.

        Returns:
            How many zones there are then.

        Raises:
            ConfigError: there are too many already.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """

        def add(pipeline: Pipeline) -> int:  # the loop does one job at a time: no zone gets lost
            if len(pipeline.keep_out) >= MOST_ZONES:
                raise ConfigError(f"there are {MOST_ZONES} zones already; remove one first")
            return self._change_zones(pipeline, (*pipeline.keep_out, zone))

        return self._wait(add)

    def remove_zone(self, zone: NDArray[np.float32]) -> int:
        """Let the robot into a zone again.

        Returns:
            How many zones are left.

        Raises:
            ConfigError: there is no such zone.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """

        def remove(pipeline: Pipeline) -> int:
            left = tuple(one for one in pipeline.keep_out if not np.array_equal(one, zone))
            if len(left) == len(pipeline.keep_out):
                raise ConfigError("there is no such zone; somebody may have removed it")
            return self._change_zones(pipeline, left)

        return self._wait(remove)

    def names(self) -> list[str]:
        """Of the maps that are kept, the newest first."""
        written: dict[str, float] = {}
        for header in self._folder.glob(f"*/{map_bundle.HEADER}"):
            with suppress(OSError):  # one that is just being replaced
                written[header.parent.name] = header.stat().st_mtime
        names = [name for name in written if _NAME.fullmatch(name)]
        return sorted(names, key=lambda name: -written[name])

    def save(self, name: str, *, replace: bool = False) -> None:
        """Keep the map as it is now.

        Raises:
            ConfigError: the name is none, or another map has it.
            MapError: there is no map yet, or it cannot be written.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """
        path = self._path(name)
        bundle = self._wait(lambda pipeline: pipeline.bundle())
        if bundle is None:
            raise MapError("the robot has no map yet; ask again when it has seen something")
        with self._saving:
            if path.exists() and not replace:
                raise ConfigError(f"there is a map {name!r} already; replace it or name another")
            self._keep(bundle, path)
        self._session.write("map", f"the map is kept as {name!r}")

    def begin(self, name: str | None) -> str | None:
        """Have the robot leave its map and go on in one that is kept, or with None in an empty one.

        Returns:
            The name under which the map it has left is kept; None where that has one keyframe and
            no zones.

        Raises:
            ConfigError: the name is none, the robot has something to do, or somebody drives.
            MapError: there is no such map, or the robot cannot use it.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """
        kept = None if name is None else map_bundle.load(self._path(name))

        def leave(pipeline: Pipeline) -> MapBundle | None:
            self._require_idle()
            pipeline.require_usable(kept)
            return pipeline.bundle()

        def begin(pipeline: Pipeline) -> None:
            self._require_idle()
            pipeline.begin_map(kept)
            self._session.begin_map()
            begun = "a new map begins" if name is None else f"goes on in {name!r}"
            self._session.write("map", f"{begun}; keep-out zones: {len(pipeline.keep_out)}")

        left, left_as = self._wait(leave), None
        if left is not None and (len(left.keyframes.ids) > 1 or left.keep_out):
            left_as = f"left {datetime.now():%Y-%m-%d %H-%M-%S-%f}"
            with self._saving:
                self._keep(left, self._path(left_as))
        self._wait(begin)
        return left_as

    def _change_zones(self, pipeline: Pipeline, zones: tuple[NDArray[np.float32], ...]) -> int:
        """Within a job of the loop: the log tells changes in the order in which they are made."""
        pipeline.keep_out = zones
        self._session.write("map", f"keep-out zones: {len(zones)}")
        return len(zones)

    def _require_idle(self) -> None:
        if self._session.queue.current() is not None:
            raise ConfigError("the robot has something to do; stop it before it changes maps")
        if (who := self._session.lease.holder) is not None:
            raise ConfigError(f"{who} drives by hand; the wheel must be given back first")

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
        done = self._session.between_steps(job)
        try:
            try:
                return done.result(_WITHIN)
            except TimeoutError:
                if done.cancel():
                    raise
            return done.result()  # it has just begun, and what it does counts
        except (TimeoutError, CancelledError) as error:
            raise DeviceTimeoutError("the robot is busy or ends; ask again") from error
