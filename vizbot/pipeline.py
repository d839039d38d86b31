"""One tick of the robot: see, map, decide, move (the paper's figure 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.patches import ALL_PIXELS, NEAR_MEDIAN
from mapping.clip.scores import Background, Query
from mapping.map_bundle import MapBundle, require_encoder
from mapping.map_snapshot import MapSnapshot
from mapping.occupancy.depth_mapper import require_resolution
from vizbot.config import Config
from vizbot.core.interfaces import Devices
from vizbot.core.observer import Candidate, GoalReport, Observer, Observers, Outcome, Step
from vizbot.core.types import RGBDFrame, Twist
from vizbot.current_map import CurrentMap
from vizbot.decider import Decider, TrackedFrame
from vizbot.goal_reports import GoalReports
from vizbot.objectnav.candidates import question_of
from vizbot.objectnav.tasks import Decision, Errand, Goal, Task, goal_of
from vizbot.perception.first_frames import FirstFrames
from vizbot.perception.interfaces import PerceptionParts
from vizbot.perception.perception import Perception
from vizbot.perception.sensor_reader import SensorReader, SensorReading

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder


def require_usable(saved_map: MapBundle | None, encoder: ClipEncoder, config: Config) -> None:
    """Raise a `MapError` for a map of another encoder or with cells of another size."""
    if saved_map is not None:
        require_encoder(saved_map, encoder)
        require_resolution(saved_map.grid, config.perception.depth_mapper)


class Pipeline:
    """Runs the ticks of one run and reports its steps to the observers.

    Attributes:
        config: Settings of all parts.
        steps: Number of steps so far.
        map: The map that the robot is in.
    """

    def __init__(
        self,
        devices: Devices,
        encoder: ClipEncoder,
        config: Config,
        observers: Sequence[Observer],
        parts: PerceptionParts | None = None,
        saved_map: MapBundle | None = None,
    ) -> None:
        """Nothing is read or driven before the first tick.

        `observers` receive every step and every goal's report; `parts` replace those of perception,
        as a benchmark's true ones; `saved_map` is continued, None begins an empty one.

        Raises:
            MapError: the saved map was made with another encoder, or has cells of another size.
        """
        self._devices = devices
        self._encoder = encoder
        self.config = config
        self.require_usable(saved_map)
        self._observers = Observers(observers)
        self._sensors = SensorReader(
            devices, config.realsense.reconnect_timeout, config.roomba.reconnect_timeout
        )
        self._first_frames = FirstFrames(devices.T_base_cam)
        self._decider = Decider(devices, config)
        self._reports = GoalReports(self._observers)
        self._newest: RGBDFrame | None = None
        self.steps = 0
        self.map = CurrentMap(0, saved_map, config)
        # Done once a run, not once a map, by the thread that embeds frames: it takes a while.
        parts = parts or PerceptionParts()
        background = parts.background or cache(partial(Background.embedded_by, encoder))
        is_paper = config.objectnav.method == "paper"
        self._parts = replace(
            parts,
            background=background,
            patch_spreads=ALL_PIXELS if is_paper else NEAR_MEDIAN,
            every_picture=is_paper or parts.every_picture,
        )

    def require_usable(self, saved_map: MapBundle | None) -> None:
        """Raise a `MapError` for a map of another encoder or with cells of another size."""
        require_usable(saved_map, self._encoder, self.config)

    def begin_map(self, saved_map: MapBundle | None) -> None:
        """Leave the present map, and continue a saved one or, with None, begin an empty one.

        A saved map is worked in before the present one is left: if anything is wrong with it, the
        robot stays in the present one.

        Raises:
            MapError: the saved map cannot be used; nothing has changed.
        """
        self.require_usable(saved_map)
        begun = CurrentMap(self.map.number + 1, saved_map, self.config)
        if saved_map is not None and self._newest is not None:
            begun.begin(self._new_perception(self._newest, saved_map))
        self.map = begun

    @property
    def keep_out(self) -> tuple[NDArray[np.float32], ...]:
        """Zones of the present map: polygons (K, 2) of corners x, y in `map` [m]."""
        return self.map.keep_out

    @keep_out.setter
    def keep_out(self, zones: tuple[NDArray[np.float32], ...]) -> None:
        self.map.keep_out = zones

    def snapshot(self) -> MapSnapshot | None:
        """The present map as it is now, for threads beside the loop; None before the first frame.

        It takes the same time however large the map is.
        """
        return self.map.snapshot()

    def bundle(self) -> MapBundle | None:
        """Everything of the present map that is worth saving; None before the first frame.

        It takes the longer the larger the map is: where the robot goes on, take a `snapshot`.
        """
        snapshot = self.snapshot()
        return None if snapshot is None else snapshot.bundle()

    def goal(self, text: str) -> Goal:
        """The goal for these words, with the encoder's or the configured threshold.

        Raises:
            ConfigError: the encoder has no name for them.
        """
        return goal_of(self._encoder, text, self.config.objectnav.threshold)

    def question(self, goal: Goal) -> Query:
        """The question by which places are believed to be a goal."""
        return question_of(goal)

    def tick(self, task: Errand) -> Step | None:
        """Do one step, for a goal or another task.

        Returns:
            What was done. `ended` says whether the task is over; the base was then stopped first.
            None at the end of a recording.

        Raises:
            DeviceError: a device is gone or silent.
        """
        while (reading := self._sensors.next()) is not None:
            tracked = self._track(reading)
            urgent = self._decider.before_task(task, tracked, self.map)
            if urgent is not None or not self._continue_step(tracked):
                return self._step(task, tracked, urgent)
        self._first_frames.note(None)
        return None

    def _track(self, reading: SensorReading) -> TrackedFrame:
        """Add a frame to the poses and the obstacle map."""
        frame, state = reading.frame, reading.state
        self._newest = frame
        self._first_frames.note(frame)
        if not self.map.has_frames:
            self.map.begin(self._new_perception(frame, self.map.saved))
        perception = self.map.perception
        if state is None:
            estimate = perception.update(frame, None)
        else:
            lifted = all(state.wheel_drops) or state.maybe_moved
            estimate = perception.update(frame, state.T_odom_base, lifted=lifted)
        T_map_base = perception.base_of(estimate)
        self.map.places.observe(state, estimate, T_map_base)
        return TrackedFrame(frame, state, estimate, T_map_base)

    def _new_perception(self, first: RGBDFrame, saved_map: MapBundle | None) -> Perception:
        devices, config = self._devices, self.config.perception
        if devices.recorded:
            # A recording does not wait: every frame is embedded, however long it takes.
            config = config.model_copy(update={"embedding_latency": 0.0})
        return Perception(
            first,
            devices.T_base_cam,
            self._encoder,
            devices.clock,
            config,
            self._parts,
            saved_map,
        )

    def _continue_step(self, tracked: TrackedFrame) -> bool:
        """Drive on within the present step; False when the next one is due."""
        base = self._devices.base
        if base is None:
            return False
        twist = self.map.step_motion.next_twist(tracked.T_map_base, tracked.frame.stamp)
        if twist is None:
            return False
        base.drive(twist)
        self.map.progress.elapse(self._devices.clock.now())
        return True

    def _step(self, task: Errand, tracked: TrackedFrame, urgent: Decision | None) -> Step:
        """Embed what is seen, decide unless that is done, drive, and report the step."""
        perception, search = self.map.perception, self.map.search
        frame, T_map_base = tracked.frame, tracked.T_map_base
        waiting = task is Task.MAP and self._devices.base is not None
        perception.embed(frame, tracked.estimate, standing=waiting)
        points, grid = perception.points(), self.map.grid()
        goal = task if isinstance(task, Goal) else None
        self._reports.odometer.observe(goal, T_map_base, self._devices.clock.now())
        scores = None if goal is None else search.observe(goal, perception)
        decision = self._decider.decide(task, tracked, self.map, grid, urgent)
        threshold = 0.0
        if goal is not None:  # where something more urgent was due, that of the step before
            decided = decision.threshold
            threshold = search.threshold(goal) if decided is None else decided
        command = self._drive(task, decision, tracked)
        navigation = decision.navigation
        step = Step(
            index=self.steps,
            frame=frame,
            frame_number=perception.frame,
            map_number=self.map.number,
            estimate=tracked.estimate,
            T_map_base=T_map_base,
            grid=grid,
            goal="" if goal is None else goal.text,
            activity=decision.activity,
            why=decision.why,
            path=None if navigation is None else navigation.path,
            target=None if navigation is None or decision.exploring else navigation.goal_xy,
            distance_to_go=None if navigation is None else navigation.distance,
            scores=scores,
            measure=search.measure,
            threshold=threshold,
            points=points,
            frames=perception.clip_map.elements.frames,
            boxes=perception.clip_map.elements.boxes,
            keyframe_poses=perception.slam.keyframe_poses(),
            closures=perception.slam.closures,
            frontiers=self.map.exploration.frontiers.frontiers_xy,
            ended=decision.ended,
            command=command,
            seen_share=self.map.exploration.frontiers.seen_share,
            candidate_xy=None if goal is None else self.map.candidate_xy(decision),
            decided_score=decision.score,
            question=decision.question,
        )
        self.steps += 1
        self._observers.on_step(step)
        return step

    def _drive(self, task: Errand, decision: Decision, tracked: TrackedFrame) -> Twist | None:
        """Begin the motion of a step; None where others drive."""
        stamp, base = tracked.frame.stamp, self._devices.base
        twist = self.map.step_motion.begin(decision, tracked.T_map_base, stamp)
        if task is Task.MAP:
            return None
        if base is not None:
            base.drive(twist)
        return twist

    def finish(self) -> None:
        """Wait for what is still being worked on; call when no more frames come."""
        if self.map.has_frames:
            self.map.perception.finish()

    def report(self, goal: Goal, outcome: Outcome, reason: str) -> GoalReport:
        """Report how the search for `goal` ended, with the best places on the map."""
        return self._reports.report(goal, outcome, reason, self.map)

    def look_up(self, goal: Goal) -> GoalReport:
        """Ask the map as it is now (paper, section III-B) and report the answer."""
        return self._reports.look_up(goal, self.map)

    def refute(self, place_xy: NDArray[np.float64] | None = None) -> None:
        """Note that a place is not the goal: see `Search.refute`."""
        self.map.search.refute(place_xy)

    def affirm(self, place_xy: NDArray[np.float64]) -> None:
        """Note that the goal is at a place: see `Search.affirm`."""
        self.map.search.affirm(place_xy)

    def candidate(self, place_xy: NDArray[np.float64]) -> Candidate | None:
        """The place of the present search nearest to a point: see `Search.candidate`."""
        return self.map.search.candidate(place_xy)
