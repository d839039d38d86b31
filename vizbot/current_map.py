"""The map that the robot is in, and everything that is valid only there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapping.map_bundle import MapBundle
from mapping.map_snapshot import MapSnapshot
from vizbot.behaviours.docking import HomePlaces
from vizbot.behaviours.progress_guard import ProgressGuard, SecondTry
from vizbot.behaviours.safety import GyroSettling, SafetyBehaviours
from vizbot.behaviours.short_motion import ShortMotion, StepMotion
from vizbot.behaviours.waypoint_drive import WaypointDrive
from vizbot.config import Config
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, OccupancyGrid
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.exploration import Exploration
from vizbot.objectnav.looks import LookAround
from vizbot.objectnav.paper_search import PaperSearch
from vizbot.objectnav.search import Search
from vizbot.objectnav.tasks import Decision
from vizbot.perception.depth_loss import unseen_ahead
from vizbot.perception.perception import Perception


class CurrentMap:
    """Holds what lives as long as a map; each map has one of its own.

    Attributes:
        number: From 0; counts the maps of this run.
        saved: The saved map that it began with; None where it began empty.
        keep_out: Polygons (K, 2) of corners x, y in `map` [m] that people forbid the robot to
            enter.
        search: The search for a goal that is under way, by the method of the settings.
        safety: Reactions to what the robot has touched or lost.
        progress: Guards the progress of the present task.
        places: Where the robot began and where its dock is.
        gyro_settling: Whether the robot still stands to learn the gyroscope's bias.
        look_around: Its first turn on the spot.
        second_try: Lets a task go on that would fail because of what was touched.
        step_motion: What is left of the present step.
        short_motion: What is left of a turn or a distance that somebody named.
    """

    def __init__(self, number: int, saved: MapBundle | None, config: Config) -> None:
        """Begin map `number` (from 0) of this run; `saved` is one to continue, or None."""
        self.number = number
        self.saved = saved
        self.keep_out: tuple[NDArray[np.float32], ...] = () if saved is None else saved.keep_out
        self.exploration = Exploration(config)
        self._view = config.frontier
        self.search: Search = (
            PaperSearch(config.navigator)
            if config.objectnav.method == "paper"
            else BeliefSearch(config, self.exploration.frontiers)
        )
        self.waypoint_drive = WaypointDrive(config)
        self.safety = SafetyBehaviours(config)
        self.progress = ProgressGuard()
        self.places = HomePlaces(config.docking)
        self.gyro_settling = GyroSettling(config.objectnav.gyro_settling)
        self.look_around = LookAround(config.objectnav.look_around_rate)
        self.second_try = SecondTry()
        self.step_motion = StepMotion(config.navigator.follower)
        self.short_motion = ShortMotion(config.navigator)
        self._perception: Perception | None = None

    @property
    def has_frames(self) -> bool:
        """Whether a frame has been worked into it in this run."""
        return self._perception is not None

    @property
    def perception(self) -> Perception:
        """The maps themselves, once there is a frame."""
        assert self._perception is not None
        return self._perception

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        for moving in (self.search, self.exploration, self.waypoint_drive, self.short_motion):
            moving.interrupt()

    def close_ahead(self, blind: Sequence[SE3]) -> None:
        """Mark unseen cells right ahead of places as occupied: the camera saw nothing from there.

        The frontiers there are given up, and the one aimed at where it led there before. Depth that
        shows floor there opens it again.

        `blind` is `T_map_base` of each place, from which the robot has just turned away.
        """
        mapper, frontiers = self.perception.depth_mapper, self.exploration.frontiers
        for T_map_base in blind:
            mapper.infer_obstacle(T_map_base, unseen_ahead(mapper.grid(), T_map_base, self._view))
            frontiers.give_up_ahead(T_map_base)
        if blind and (frontier_xy := self.progress.blinding_frontier()) is not None:
            frontiers.give_up(frontier_xy)

    def leave_alone(self, now: float) -> None:
        """Leave out, at `now` [s], the frontiers and places that lately brought no progress."""
        self.exploration.frontiers.barred_xy = self.progress.barred(now, exploring=True)
        self.search.leave_alone(self.progress.barred(now, exploring=False))

    def candidate_xy(self, decision: Decision) -> NDArray[np.float64] | None:
        """The place (2,) in `map` [m] that the search approaches; None without one."""
        if decision.navigation is None or decision.exploring:
            return None
        return self.search.place_of(decision.navigation)

    def begin(self, perception: Perception) -> None:
        """Set the maps that the first frame begins.

        What a saved map shows counts as seen, but for an exploration.
        """
        self._perception = perception
        if self.saved is not None:
            grid, T_cam_base = perception.grid(), invert(self.saved.T_base_cam)
            for T_map_cam in self.saved.final_poses():
                self.exploration.remember(grid, T_map_cam @ T_cam_base)

    def grid(self) -> OccupancyGrid:
        """The obstacle map with the zones that are forbidden."""
        return replace(self.perception.grid(), zones=self.keep_out)

    def snapshot(self) -> MapSnapshot | None:
        """Everything worth saving, as it is now; None before the first frame."""
        if self._perception is None:
            return None
        return replace(self._perception.snapshot(), keep_out=self.keep_out)
