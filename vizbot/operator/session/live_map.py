"""The map of a running robot: people ask it, limit it by zones, save it, and load another one.

Its methods wait for the robot's loop, which gives them a snapshot and goes on; they save and answer
in the calling thread, which must be one that may wait.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapping import map_bundle
from mapping.map_bundle import MapBundle
from mapping.map_folder import MapUse
from mapping.map_snapshot import MapSnapshot
from vizbot.core.errors import ConfigError, MapError
from vizbot.core.observer import Outcome
from vizbot.core.program.interrupts import one_line
from vizbot.core.types import Tracking
from vizbot.objectnav.tasks import Goal
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.session.household import HouseholdBeliefs
from vizbot.operator.session.place_answers import (
    Answer,
    area_of,
    count_places,
    find_places,
    least_score,
    summary,
)
from vizbot.operator.session.room_areas import RoomArea, RoomAreas
from vizbot.operator.session.saved_maps import SavedMaps
from vizbot.operator.session.session import OperatorSession
from vizbot.pipeline import Pipeline

MOST_ZONES = 100


class LiveMap:
    """The map in which one robot is running, and those that are saved.

    What waits for the robot's loop raises a `ConfigError` where too much is asked at once, and a
    `DeviceTimeoutError` where the robot is too busy or its run ends.

    Attributes:
        saved: The saved maps of this user.
    """

    def __init__(self, session: OperatorSession, folder: Path | None = None) -> None:
        """Attach to a running robot; `folder` is that of the saved maps, this user's by default."""
        self._session = session
        self.saved = SavedMaps(folder)
        self._household = HouseholdBeliefs()
        self._rooms = RoomAreas(self._household)
        self._saving = threading.Lock()
        self._used: MapUse | None = None
        self._unsaved: int | None = None  # map that somebody knows cannot be saved
        if session.robot.begun_in is not None:
            self._use(self.saved.name_of(session.robot.begun_in))

    def places(self, text: str) -> Answer:
        """Look up where on the map a text is found."""
        goal, bundle, pipeline = self._asked(text)
        if bundle is None:
            least = least_score(goal, pipeline.config.objectnav)
            return Answer(text, Outcome.NOT_FOUND, least, (), goal.note)
        return find_places(bundle, goal, pipeline.config.objectnav)

    def summary(self, answer: Answer, language: Language = ENGLISH) -> str:
        """An answer in one line, seen from where the robot is now."""
        step = self._session.newest_step()
        if step is None or step.estimate.tracking is Tracking.LOST:
            return summary(answer, None, language)
        return summary(answer, step.T_map_base, language)

    def count(self, text: str) -> int:
        """How many places on the map look like a text."""
        goal, bundle, pipeline = self._asked(text)
        if bundle is None:
            return 0
        return count_places(
            bundle, pipeline.question(goal), pipeline.config.objectnav.answer_probability
        )

    def keep_out_of(self, text: str) -> tuple[float, float] | None:
        """Add a zone round what looks like a room.

        Returns:
            How wide and how deep it is, along x and y of `map` [m]; None where nothing on the map
            looks like it: then there is no zone.

        Raises:
            ConfigError: there are too many zones.
        """
        goal, bundle, pipeline = self._asked(text)
        if bundle is None:
            return None
        least = pipeline.config.objectnav.answer_probability
        zone = area_of(bundle, pipeline.question(goal), least)
        if zone is None:
            return None
        self.add_zone(zone)
        width, depth = np.ptp(zone, axis=0)
        return float(width), float(depth)

    def vocabulary(self) -> list[str]:
        """Things and rooms of a household that the map finds, in alphabetical order."""
        bundle, number, pipeline = self._whole()
        return [] if bundle is None else self._household.found(bundle, number, pipeline)

    def rooms(self) -> list[RoomArea]:
        """The rooms on the map, the largest first; an answer may be ten seconds old."""
        step = self._session.newest_step()
        return [] if step is None else self._rooms.found(step.map_number, self._whole)

    def in_view(self) -> list[str]:
        """What the newest mapped picture shows of a household, the surest first."""
        bundle, number, pipeline = self._whole()
        return [] if bundle is None else self._household.in_view(bundle, number, pipeline)

    def keep_out(self) -> tuple[NDArray[np.float32], ...]:
        """Zones that the robot must not enter: each (N, 2), corners x, y in `map` [m]."""
        return self._session.jobs.wait_for(lambda pipeline: pipeline.keep_out)

    def set_keep_out(self, zones: Sequence[NDArray[np.float32]]) -> None:
        """Replace all zones that the robot must not enter."""

        def change(pipeline: Pipeline) -> None:
            self._change_zones(pipeline, tuple(zones))

        self._session.jobs.wait_for(change)

    def add_zone(self, zone: NDArray[np.float32]) -> int:
        """Add a zone that the robot must not enter; return the number of zones, with it.

        Raises:
            ConfigError: there are too many already.
        """

        def add(pipeline: Pipeline) -> int:  # the loop does one job at a time: no zone gets lost
            if len(pipeline.keep_out) >= MOST_ZONES:
                raise ConfigError(f"there are {MOST_ZONES} zones already; remove one first")
            return self._change_zones(pipeline, (*pipeline.keep_out, zone))

        return self._session.jobs.wait_for(add)

    def remove_zone(self, zone: NDArray[np.float32]) -> int:
        """Remove a zone; return the number of zones that are left.

        Raises:
            ConfigError: there is no such zone.
        """

        def remove(pipeline: Pipeline) -> int:
            left = tuple(one for one in pipeline.keep_out if not np.array_equal(one, zone))
            if len(left) == len(pipeline.keep_out):
                raise ConfigError("there is no such zone; somebody may have removed it")
            return self._change_zones(pipeline, left)

        return self._session.jobs.wait_for(remove)

    def save(self, name: str, *, replace: bool = False) -> None:
        """Save the map as it is now.

        Raises:
            ConfigError: the name cannot be one, or another map has it.
            MapError: there is no map yet, or it cannot be written.
        """
        path = self.saved.path(name)
        snapshot = self._session.jobs.wait_for(lambda pipeline: pipeline.snapshot())
        if snapshot is None:
            raise MapError("the robot has no map yet; ask again when it has seen something")
        bundle = snapshot.bundle()
        with self._saving:
            if path.exists() and not replace:
                raise ConfigError(f"there is a map {name!r} already; replace it or name another")
            self._save_bundle(bundle, path)
            self._use(name)
        self._session.log.write("map", f"the map is kept as {name!r}")

    def begin(self, name: str | None) -> str | None:
        """Have the robot leave its map for a saved one, or with None for an empty one.

        A map that cannot be saved is left, and lost, when that is asked for once more.

        Returns:
            The name under which the map that it left is saved; None where that map has one
            keyframe at most and no zones, or cannot be saved.

        Raises:
            ConfigError: the name cannot be one, the robot has a task, or somebody drives.
            MapError: there is no such map, the robot cannot use it, or the map that it is in cannot
                be saved and this is asked for the first time since then.
        """
        saved = None
        if name is not None:
            map_bundle.require_growable(self.saved.path(name))
            saved = map_bundle.load(self.saved.path(name))

        def leave(pipeline: Pipeline) -> tuple[MapSnapshot | None, int]:
            self._require_idle()
            pipeline.require_usable(saved)
            return pipeline.snapshot(), pipeline.map.number

        def begin(pipeline: Pipeline) -> None:
            self._require_idle()
            pipeline.begin_map(saved)
            self._session.leave_map()
            begun = "a new map begins" if name is None else f"goes on in {name!r}"
            self._session.log.write("map", f"{begun}; keep-out zones: {len(pipeline.keep_out)}")

        (left, number), left_as = self._session.jobs.wait_for(leave), None
        if left is not None and (len(left.keyframe_poses) > 1 or left.keep_out):
            left_as = self._keep_left(left, number)
        self._session.jobs.wait_for(begin)
        with self._saving:
            self._use(name)
        return left_as

    def rename(self, name: str, new: str) -> None:
        """Give a saved map another name.

        Raises:
            ConfigError: a name cannot be one.
            MapError: there is no such map, another one has the name, or it cannot be renamed.
        """
        with self._saving:
            self.saved.rename(name, new)
        self._session.log.write("map", f"the map {name!r} is called {new!r} now")

    def delete(self, name: str) -> None:
        """Delete a saved map.

        Raises:
            ConfigError: the name cannot be one.
            MapError: there is no such map, a robot is in it, or it cannot be deleted.
        """
        with self._saving:
            self.saved.delete(name)
        self._session.log.write("map", f"the map {name!r} is deleted")

    def close(self) -> None:
        """Leave the saved map that the robot is in to others; twice is fine."""
        with self._saving:
            self._use(None)

    def _use(self, name: str | None) -> None:
        """Claim the saved map that the robot is in from now on, in place of the one before."""
        before = self._used
        self._used = None if name is None else self.saved.use(name)
        if before is not None:
            before.close()

    def _asked(self, text: str) -> tuple[Goal, MapBundle | None, Pipeline]:
        """The goal for a text, the map as it is now, and what answers questions about it."""
        bundle, _, pipeline = self._whole()
        return pipeline.goal(text), bundle, pipeline

    def _whole(self) -> tuple[MapBundle | None, int, Pipeline]:
        """The map as it is now, which map of the run it is, and what answers questions about it."""
        snapshot, number, pipeline = self._session.jobs.wait_for(
            lambda pipeline: (pipeline.snapshot(), pipeline.map.number, pipeline)
        )
        return None if snapshot is None else snapshot.bundle(), number, pipeline

    def _change_zones(self, pipeline: Pipeline, zones: tuple[NDArray[np.float32], ...]) -> int:
        """Within a job of the loop, so that the log has the changes in their order."""
        pipeline.keep_out = zones
        self._session.log.write("map", f"keep-out zones: {len(zones)}")
        return len(zones)

    def _require_idle(self) -> None:
        if self._session.queue.current() is not None:
            raise ConfigError("the robot has something to do; stop it before it changes maps")
        if (who := self._session.lease.holder) is not None:
            raise ConfigError(f"{who} drives by hand; the wheel must be given back first")

    def _keep_left(self, left: MapSnapshot, number: int) -> str | None:
        """The name under which a map that is left is saved; None where it is given up.

        Raises:
            MapError: it cannot be saved, and nobody knows that yet.
        """
        name = f"left {datetime.now():%Y-%m-%d %H-%M-%S-%f}"
        try:
            with self._saving:
                self._save_bundle(left.bundle(), self.saved.path(name))
        except Exception as error:  # whatever keeps it from being saved must not keep the robot
            if self._unsaved != number:
                self._unsaved = number
                raise MapError(
                    f"{one_line(error)}; or ask once more to leave this map, which is lost then"
                ) from error
            self._session.log.write("map", "the map that could not be saved is given up")
            return None
        return name

    def _save_bundle(self, bundle: MapBundle, path: Path) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            map_bundle.save(bundle, path)
        except OSError as error:
            raise MapError(f"{path} cannot be written: {error.strerror}") from error
