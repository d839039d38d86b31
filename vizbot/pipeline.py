"""One tick of the robot: see, map, decide, move (the paper's figure 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.map_bundle import MapBundle, require_encoder
from mapping.occupancy.depth_mapper import require_resolution
from nav.look_around import LookAround
from vizbot.behaviours.docking import Docking
from vizbot.behaviours.gyro_settling import GyroSettling
from vizbot.behaviours.safety import SafetyBehaviours
from vizbot.behaviours.step_motion import StepMotion, TwistLimiter
from vizbot.config import Config
from vizbot.core.devices import Devices
from vizbot.core.geometry import invert
from vizbot.core.interfaces import Base
from vizbot.core.observer import Candidate, GoalReport, Observer, Observers, Outcome, Step
from vizbot.core.types import SE3, STOP, BaseState, OccupancyGrid, PoseEstimate, RGBDFrame
from vizbot.objectnav.candidates import RunningScores, best_places
from vizbot.objectnav.search import Search
from vizbot.objectnav.tasks import Decision, Goal, Task, Waypoint
from vizbot.perception.depth_loss import DepthLossMonitor
from vizbot.perception.interfaces import ObstacleMapper, PoseEstimator
from vizbot.perception.perception import Perception
from vizbot.perception.sensor_reader import SensorReader

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder


class Pipeline:
    """Runs the ticks of one run and tells the observers."""

    def __init__(
        self,
        devices: Devices,
        encoder: ClipEncoder,
        config: Config,
        observers: Sequence[Observer],
        slam: PoseEstimator | None = None,
        depth_mapper: ObstacleMapper | None = None,
        kept: MapBundle | None = None,
    ) -> None:
        """Nothing is read or driven before the first tick.

        Args:
            devices: Camera, base and clock.
            encoder: Of images and goals.
            config: Settings of all parts.
            observers: Told of every step and goal.
            slam: The true counterpart that a benchmark may switch to.
            depth_mapper: Likewise.
            kept: A map of before to begin in.

        Raises:
            MapError: it was made with another encoder.
        """
        self._devices = devices
        self._encoder = encoder
        self.config = config
        self._observers = Observers(observers)
        self._slam = slam
        self._depth_mapper = depth_mapper
        self._blindness = DepthLossMonitor()
        self._senses = SensorReader(
            devices, config.realsense.reconnect_timeout, config.roomba.reconnect_timeout
        )
        self._homing = Docking(config.docking)
        self._throttle = TwistLimiter(config.navigator.follower, config.roomba.command_timeout)
        self.steps = 0
        self._maps = 0
        self.begin_map(kept)

    def require_usable(self, kept: MapBundle | None) -> None:
        """Raise a `MapError` for a map of another encoder or with other cells."""
        if kept is not None:
            require_encoder(kept, self._encoder)
            require_resolution(kept.grid, self.config.perception.depth_mapper)

    def begin_map(self, kept: MapBundle | None) -> None:
        """Leave the map there is, and begin in one of before or, with None, an empty one.

        Raises:
            MapError: it cannot be used; nothing has changed.
        """
        self.require_usable(kept)
        config = self.config
        self._kept = kept
        self.keep_out: tuple[NDArray[np.float32], ...] = () if kept is None else kept.keep_out
        self._perception: Perception | None = None
        self._search = Search(config, in_kept_map=kept is not None)
        self._reactions = SafetyBehaviours(config)
        self._homing.forget_places()
        self._settling = GyroSettling(config.objectnav.settling)
        self._look_around = LookAround(config.objectnav.look_around_rate)
        self._stride = StepMotion(config.navigator.follower)
        self._scores = RunningScores()
        self._maps += 1

    def bundle(self) -> MapBundle | None:
        """Everything worth keeping of the maps; None before the first frame."""
        if self._perception is None:
            return None
        return replace(self._perception.bundle(), keep_out=self.keep_out)

    def goal(self, text: str) -> Goal:
        """The goal for these words, with the encoder's or the configured threshold."""
        threshold = self.config.objectnav.threshold
        return Goal(
            text,
            self._encoder.embed_texts([text])[0],
            self._encoder.threshold if threshold is None else threshold,
        )

    def tick(self, task: Goal | Waypoint | Task) -> Step | None:
        """Do one step, for a goal or another task.

        Returns:
            What was done; `ended` says whether the task is over (the base was told to stop first).
            None at the end of a recording.

        Raises:
            DeviceError: a device is gone or silent.
        """
        base = self._devices.base
        while (sensed := self._senses.next()) is not None:
            frame, state = sensed.frame, sensed.state
            if self._perception is None:
                self._perception = self._begin(frame)
            perception = self._perception
            if state is None:
                estimate = perception.update(frame, None)
            else:
                lifted = all(state.wheel_drops)
                estimate = perception.update(frame, state.T_odom_base, lifted=lifted)
            T_map_base = perception.base_of(estimate)
            self._homing.notice(state, estimate, T_map_base)
            decision = Decision(STOP, "mapping") if task is Task.MAP else None
            if base is not None and state is not None:
                self._homing.make_ready(base, state, task)
                decision = decision or self._react(base, task, frame, state, estimate)
            if base is not None and decision is None:
                period = self._throttle.since(frame.stamp)
                if (onward := self._stride.goes_on(T_map_base, period)) is not None:
                    self._throttle.drive(base, onward, frame.stamp)
                    continue
            return self._act(task, frame, estimate, T_map_base, decision)
        return None

    def _react(
        self,
        base: Base,
        task: Goal | Waypoint | Task,
        frame: RGBDFrame,
        state: BaseState,
        estimate: PoseEstimate,
    ) -> Decision | None:
        """What comes before anything that is looked for; None where nothing does."""
        assert self._perception is not None
        perception, now = self._perception, self._devices.clock.now()
        T_map_base, to_dock = perception.base_of(estimate), task is Task.DOCK
        self._blindness.look(frame, T_map_base, perception.grid, now)
        if to_dock:
            stop = self._reactions.stop_for_good(state, now)
            docks = self._homing.docks(base, state, now, stop)
            if docks is not None:
                return docks
        mapper, blind = perception.depth_mapper, self._blindness.seconds
        return self._reactions.to(state, estimate, T_map_base, mapper, now, blind, to_dock=to_dock)

    def _act(
        self,
        task: Goal | Waypoint | Task,
        frame: RGBDFrame,
        estimate: PoseEstimate,
        T_map_base: SE3,
        reaction: Decision | None,
    ) -> Step:
        """Embed what is seen, decide and drive."""
        assert self._perception is not None
        perception, base = self._perception, self._devices.base
        perception.embed(frame, estimate, standing=task is Task.MAP and base is not None)
        points = perception.points()
        grid = replace(perception.grid(), zones=self.keep_out)
        scores = self._scores.of(task, perception.clip_map.embeddings)
        if reaction is None:
            self._search.look(grid, T_map_base)
            decision = self._decide(task, frame, grid, T_map_base, points, scores)
        else:
            decision = reaction
            self._search.interrupt()
        self._stride.begin(decision, T_map_base)
        command = None
        if task is Task.MAP:
            self._throttle.let_go()
        else:
            command = self._throttle.drive(base, decision.twist, frame.stamp)
        goal = task if isinstance(task, Goal) else None
        navigation, asked = decision.navigation, 0.0 if goal is None else goal.threshold
        step = Step(
            index=self.steps,
            frame=frame,
            frame_number=perception.frame,
            map_number=self._maps - 1,
            estimate=estimate,
            T_map_base=T_map_base,
            grid=grid,
            goal="" if goal is None else goal.text,
            activity=decision.activity,
            path=None if navigation is None else navigation.path,
            target=None if navigation is None or decision.exploring else navigation.goal_xy,
            distance_to_go=None if navigation is None else navigation.distance,
            threshold=asked if decision.threshold is None else decision.threshold,
            points=points,
            similarities=scores,
            frames=perception.clip_map.elements.frames,
            boxes=perception.clip_map.elements.boxes,
            keyframe_poses=perception.slam.keyframe_poses(),
            closures=perception.slam.closures,
            frontiers=self._search.frontiers_xy,
            ended=decision.ended,
            command=command,
        )
        self.steps += 1
        self._observers.on_step(step)
        return step

    def _begin(self, first: RGBDFrame) -> Perception:
        devices, config = self._devices, self.config.perception
        # A recording waits for nobody: every frame is embedded, however long it takes.
        latency = 0.0 if devices.recorded else config.embedding_latency
        perception = Perception(
            first, devices.T_base_cam, self._encoder, devices.clock, config, latency,
            self._slam, self._depth_mapper, self._kept,
        )  # fmt: skip
        if self._kept is not None:  # what has been looked at need not be explored
            grid, T_cam_base = perception.grid(), invert(self._kept.T_base_cam)
            for T_map_cam in self._kept.final_poses():
                self._search.look(grid, T_map_cam @ T_cam_base)
        return perception

    def finish(self) -> None:
        """Wait for what is still being worked on; call when no more frames come."""
        if self._perception is not None:
            self._perception.finish()

    def report(self, goal: Goal, outcome: Outcome, reason: str) -> GoalReport:
        """Tell the observers how the search for `goal` ended, with the best places on the map."""
        answer = self._search.answer if outcome is Outcome.ARRIVED else None
        report = GoalReport(goal.text, outcome, reason, self._candidates(goal, answer))
        self._observers.on_goal(report)
        return report

    def look_up(self, goal: Goal) -> GoalReport:
        """Ask the map as it is now (paper, section III-B) and tell the observers the answer."""
        candidates = self._candidates(goal)
        if candidates and candidates[0].similarity > goal.threshold:
            return self.report(goal, Outcome.LOCATED, f"similarity above {goal.threshold:.3f}")
        reason = f"the best place on the map is not above {goal.threshold:.3f}"
        return self.report(goal, Outcome.NOT_FOUND, reason)

    def _candidates(self, goal: Goal, answer: int | None = None) -> tuple[Candidate, ...]:
        if self._perception is None:
            return ()
        return best_places(self._perception, goal, self.config.objectnav.agreement, answer)

    def _decide(
        self,
        task: Goal | Waypoint | Task,
        frame: RGBDFrame,
        grid: OccupancyGrid,
        T_map_base: SE3,
        points: NDArray[np.float64],
        scores: NDArray[np.float32],
    ) -> Decision:
        assert self._perception is not None
        if self._settling.goes_on(frame):
            return Decision(STOP, "standing still, to learn the gyroscope's bias")
        if (place := self._homing.place(task)) is not None:
            decision, base = self._search.drive_to(place, grid, T_map_base), self._devices.base
            there = decision.ended is not None and decision.ended[0] is Outcome.ARRIVED
            if task is Task.DOCK and there and base is not None:
                return self._homing.seek_dock(base, self._devices.clock.now())
            return decision
        looks = self.config.objectnav.look_around and self._kept is None
        if looks and (turn := self._look_around.twist(T_map_base)):
            return Decision(turn, "looking around")
        if not isinstance(task, Goal):
            return self._search.explore(grid, T_map_base)
        sightings = self._perception.sightings(points, scores)
        return self._search.go(
            task, sightings, grid, T_map_base, self._perception.frame, self.steps
        )
