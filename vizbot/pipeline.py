"""One tick of the robot: see, map, decide, move (the paper's figure 3)."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.map_bundle import MapBundle, require_encoder
from mapping.retrieval import similarities
from nav.follower import accelerate
from nav.look_around import LookAround
from vizbot.blindness import Blindness
from vizbot.config import Config
from vizbot.core.geometry import invert
from vizbot.core.interfaces import Base
from vizbot.core.observation import Candidate, GoalReport, Observer, Outcome, Step
from vizbot.core.types import SE3, STOP, OccupancyGrid, PoseEstimate, RGBDFrame, Twist
from vizbot.observers import Observers
from vizbot.perception import ObstacleMapper, Perception, PoseEstimator
from vizbot.reactions import Reactions
from vizbot.rig import Devices
from vizbot.search import Decision, Goal, Search
from vizbot.senses import Senses
from vizbot.settling import Settling
from vizbot.stride import Stride

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip_encoder import ClipEncoder


class Task(Enum):
    """What a tick is for when no goal is asked for."""

    MAP = "map what the camera shows, drive nothing"
    EXPLORE = "drive until nothing is left to see"


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
        if kept is not None:
            require_encoder(kept, encoder)
        self._kept = kept
        self._devices = devices
        self._encoder = encoder
        self._config = config
        self._observers = Observers(observers)
        self._slam = slam
        self._depth_mapper = depth_mapper
        self._search = Search(config, in_kept_map=kept is not None)
        self._reactions = Reactions(config)
        self._blindness = Blindness()
        self._senses = Senses(
            devices, config.realsense.reconnect_timeout, config.roomba.reconnect_timeout
        )
        self._perception: Perception | None = None
        self._look_around = LookAround(config.objectnav.look_around_rate)
        self._settling = Settling(config.objectnav.settling)
        self._stride = Stride(config.navigator.follower)
        self._twist = STOP
        self._driven_at = 0.0
        self._asked: Goal | Task = Task.MAP
        self._scores = np.zeros(0, np.float32)
        self.steps = 0

    def bundle(self) -> MapBundle | None:
        """Everything worth keeping of the maps; None before the first frame."""
        return None if self._perception is None else self._perception.bundle()

    def goal(self, text: str) -> Goal:
        """The goal for these words, with the encoder's or the configured threshold."""
        threshold = self._config.objectnav.threshold
        return Goal(
            text,
            self._encoder.embed_texts([text])[0],
            self._encoder.threshold if threshold is None else threshold,
        )

    def tick(self, task: Goal | Task) -> Step | None:
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
            decision = None
            if task is Task.MAP:
                decision = Decision(STOP, "mapping")
            else:
                now = self._devices.clock.now()
                self._blindness.look(frame, T_map_base, perception.grid, now)
                if base is not None and state is not None:
                    mapper, blind = perception.depth_mapper, self._blindness.seconds
                    decision = self._reactions.to(state, estimate, T_map_base, mapper, now, blind)
            if base is not None and decision is None:
                period = frame.stamp - self._driven_at
                if (onward := self._stride.goes_on(T_map_base, period)) is not None:
                    self._drive(base, onward, frame.stamp)
                    continue
            return self._act(task, frame, estimate, T_map_base, decision)
        return None

    def _act(
        self,
        task: Goal | Task,
        frame: RGBDFrame,
        estimate: PoseEstimate,
        T_map_base: SE3,
        reaction: Decision | None,
    ) -> Step:
        """Embed what is seen, decide and drive."""
        assert self._perception is not None
        perception, base = self._perception, self._devices.base
        perception.embed(frame, estimate)
        grid, points = perception.grid(), perception.points()
        scores = self._similarities(task)
        if reaction is None:
            self._search.look(grid, T_map_base)
            decision = self._decide(task, frame, grid, T_map_base, points, scores)
        else:
            decision = reaction
            self._search.interrupt()
        self._stride.begin(decision, T_map_base)
        command = None if task is Task.MAP else self._drive(base, decision.twist, frame.stamp)
        goal = task if isinstance(task, Goal) else None
        navigation, asked = decision.navigation, 0.0 if goal is None else goal.threshold
        step = Step(
            index=self.steps,
            frame=frame,
            frame_number=perception.frame,
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
        perception = Perception(
            first,
            self._devices.T_base_cam,
            self._encoder,
            self._devices.clock,
            self._config.perception,
            # A recording waits for nobody: every frame is embedded, however long it takes.
            0.0 if self._devices.recorded else self._config.perception.embedding_latency,
            self._slam,
            self._depth_mapper,
            self._kept,
        )
        if self._kept is not None:  # what has been looked at need not be explored
            grid, T_cam_base = perception.grid(), invert(self._kept.T_base_cam)
            for T_map_cam in self._kept.final_poses():
                self._search.look(grid, T_map_cam @ T_cam_base)
        return perception

    def _drive(self, base: Base | None, twist: Twist, stamp: float) -> Twist:
        """Drive as much of a change of twist as the time since the last frame allows.

        Without a base it is only computed.
        """
        period = min(max(stamp - self._driven_at, 0.0), self._config.roomba.command_timeout)
        twist = accelerate(twist, self._twist, period, self._config.navigator.follower)
        self._twist, self._driven_at = twist, stamp
        if base is not None:
            base.drive(self._twist)
        return self._twist

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
        """The best places, that of the element `answer` first if there is one."""
        if self._perception is None:
            return ()
        points = self._perception.points()
        elements = self._perception.clip_map.elements
        scores = similarities(elements.embeddings, goal.embedding)
        sightings = self._perception.sightings(points, scores)
        chosen = sightings.answers(self._config.objectnav.agreement)
        if answer is not None:
            chosen = sightings.behind(answer, chosen)
        return tuple(
            Candidate(points[i], float(scores[i]), int(elements.frames[i]), elements.boxes[i])
            for i in chosen
        )

    def _similarities(self, task: Goal | Task) -> NDArray[np.float32]:
        """Of all elements (N,) to the goal, zero without one; each element is asked once."""
        assert self._perception is not None
        if task is not self._asked:
            self._asked, self._scores = task, np.zeros(0, np.float32)
        fresh = self._perception.clip_map.embeddings[len(self._scores) :]
        if isinstance(task, Goal):
            scores = similarities(fresh, task.embedding)
        else:
            scores = np.zeros(len(fresh), np.float32)
        self._scores = np.concatenate([self._scores, scores])
        return self._scores

    def _decide(
        self,
        task: Goal | Task,
        frame: RGBDFrame,
        grid: OccupancyGrid,
        T_map_base: SE3,
        points: NDArray[np.float64],
        scores: NDArray[np.float32],
    ) -> Decision:
        assert self._perception is not None
        if self._settling.goes_on(frame):
            return Decision(STOP, "standing still, to learn the gyroscope's bias")
        looks = self._config.objectnav.look_around and self._kept is None
        if looks and (turn := self._look_around.twist(T_map_base)):
            return Decision(turn, "looking around")
        if not isinstance(task, Goal):
            return self._search.explore(grid, T_map_base)
        sightings = self._perception.sightings(points, scores)
        return self._search.go(
            task, sightings, grid, T_map_base, self._perception.frame, self.steps
        )
