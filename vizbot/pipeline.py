"""One tick of the robot: see, map, decide, move (the paper's figure 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.map_bundle import MapBundle
from mapping.retrieval import best, similarities
from nav.follower import accelerate
from nav.frontier import FrontierSearch
from nav.look_around import LookAround
from nav.navigator import Navigation
from nav.recovery import Recovery, contact_points
from vizbot.config import Config
from vizbot.confirmation import Confirmation
from vizbot.core.interfaces import Base
from vizbot.core.observation import Candidate, GoalReport, Observer, Outcome, Step
from vizbot.core.types import (
    SE3,
    STOP,
    BaseMode,
    BaseState,
    PoseEstimate,
    RGBDFrame,
    Tracking,
    Twist,
)
from vizbot.objectnav import objectnav
from vizbot.perception import ObstacleMapper, Perception, PoseEstimator
from vizbot.rig import Devices

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip_encoder import ClipEncoder

CANDIDATES = 5
"""How many places a goal's report names."""
CANDIDATE_SPACING = 0.8
"""How far apart they are [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """One thing to look for.

    Attributes:
        text: In the user's words.
        embedding: (D,) float32 unit, by the run's encoder.
        threshold: Theta at the start of every step.
    """

    text: str
    embedding: NDArray[np.float32]
    threshold: float


@dataclass(frozen=True, slots=True, eq=False)
class _Decision:
    """What one step comes to: a twist now, and the end of the goal if it has ended."""

    twist: Twist
    activity: str
    navigation: Navigation | None = None
    exploring: bool = False
    threshold: float | None = None
    ended: tuple[Outcome, str] | None = None


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
    ) -> None:
        """Nothing is read or driven before the first tick.

        `slam` and `depth_mapper` stand in for the pose estimator and the obstacle mapper, where a
        benchmark switches one to its true counterpart.
        """
        self._devices = devices
        self._encoder = encoder
        self._config = config
        self._observers = tuple(observers)
        self._slam = slam
        self._depth_mapper = depth_mapper
        self._previous: Navigation | None = None
        self._sought: Goal | None = None
        self._confirmation = self._fresh_confirmation()
        self._recovery = Recovery(config.recovery)
        self._frontiers = FrontierSearch(config.frontier)
        self._perception: Perception | None = None
        self._look_around = (
            LookAround(config.objectnav.look_around_rate) if config.objectnav.look_around else None
        )
        self._twist = STOP
        self._driven_at = 0.0
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

    def tick(self, goal: Goal | None) -> Step | None:
        """Work on one frame.

        Args:
            goal: What to drive to; None only maps, and leaves the base alone.

        Returns:
            What was done; `ended` says whether the search is over (the base was told to stop
            first). None at the end of a recording.

        Raises:
            DeviceError: a device is gone or silent.
        """
        frame = self._devices.camera.read()
        if frame is None:
            return None
        base = self._devices.base
        state = None if base is None else base.read()
        if self._perception is None:
            self._perception = Perception(
                frame,
                self._devices.T_base_cam,
                self._encoder,
                self._devices.clock,
                self._config.perception,
                # A recording waits for nobody: every frame is embedded, however long it takes.
                0.0 if self._devices.recorded else self._config.perception.embedding_latency,
                self._slam,
                self._depth_mapper,
            )
        perception = self._perception
        estimate = perception.update(frame, None if state is None else state.T_odom_base)
        T_map_base = perception.base_of(estimate)
        points = perception.points()
        scores = np.zeros(len(points), np.float32)
        if goal is not None:
            scores = similarities(perception.clip_map.embeddings, goal.embedding)
        if base is None or state is None or goal is None:
            decision = _Decision(STOP, "mapping")
        else:
            decision = self._decide(state, estimate, T_map_base, points, scores, goal)
            self._drive(base, decision.twist, frame.stamp)
            self._previous = decision.navigation
        step = self._step(frame, estimate, T_map_base, decision, goal, points, scores)
        for observer in self._observers:
            observer.on_step(step)
        return step

    def _drive(self, base: Base, twist: Twist, stamp: float) -> None:
        """Drive as much of a change of twist as the time since the last frame allows."""
        period = min(max(stamp - self._driven_at, 0.0), self._config.roomba.command_timeout)
        self._twist = accelerate(twist, self._twist, period, self._config.navigator.follower)
        self._driven_at = stamp
        base.drive(self._twist)

    def finish(self) -> None:
        """Wait for what is still being worked on; call when no more frames come."""
        if self._perception is not None:
            self._perception.finish()

    def report(self, goal: Goal, outcome: Outcome, reason: str) -> GoalReport:
        """Tell the observers how the search for `goal` ended, with the best places on the map."""
        answer = self._confirmation.confirmed if outcome is Outcome.ARRIVED else None
        report = GoalReport(goal.text, outcome, reason, self._candidates(goal, answer))
        for observer in self._observers:
            observer.on_goal(report)
        return report

    def look_up(self, goal: Goal) -> GoalReport:
        """Ask the map as it is now (paper, section III-B) and tell the observers the answer."""
        candidates = self._candidates(goal)
        if candidates and candidates[0].similarity > goal.threshold:
            return self.report(goal, Outcome.LOCATED, f"similarity above {goal.threshold:.3f}")
        reason = f"nothing on the map is above {goal.threshold:.3f}"
        return self.report(goal, Outcome.NOT_FOUND, reason)

    def _candidates(self, goal: Goal, answer: int | None = None) -> tuple[Candidate, ...]:
        """The best places, that of the element `answer` first if there is one."""
        if self._perception is None:
            return ()
        points = self._perception.points()
        scores = similarities(self._perception.clip_map.embeddings, goal.embedding)
        chosen = best(scores, points, CANDIDATES, CANDIDATE_SPACING).tolist()
        if answer is not None:
            apart = np.linalg.norm(points[chosen] - points[answer], axis=1) >= CANDIDATE_SPACING
            others = [i for i, far in zip(chosen, apart, strict=True) if far]
            chosen = [answer, *others][:CANDIDATES]
        return tuple(Candidate(points[i], float(scores[i])) for i in chosen)

    def _decide(
        self,
        state: BaseState,
        estimate: PoseEstimate,
        T_map_base: SE3,
        points: NDArray[np.float64],
        scores: NDArray[np.float32],
        goal: Goal,
    ) -> _Decision:
        assert self._perception is not None
        mapper, now = self._perception.depth_mapper, self._devices.clock.now()
        radius = self._config.navigator.costmap.robot_radius
        if any(state.cliffs) or any(state.wheel_drops):
            return _Decision(STOP, "stopped at an edge", ended=(Outcome.GAVE_UP, "edge or drop"))
        if state.mode not in (BaseMode.SAFE, BaseMode.FULL):
            passive = f"the base is in {state.mode.name} mode and does not drive; launch again"
            return _Decision(STOP, "the base does not drive", ended=(Outcome.GAVE_UP, passive))
        if estimate.tracking is Tracking.LOST:
            return _Decision(STOP, "lost, standing still")
        recovery = self._recovery.twist(now)
        if recovery is None and state.bumped:
            touched = contact_points(state.bump_left, state.bump_right, radius)
            mapper.mark_obstacle(T_map_base, touched)
            self._recovery.begin(now)
            recovery = STOP
        if recovery is not None:
            return _Decision(recovery, "backing off after a bump")
        mapper.mark_free(T_map_base, radius)
        if self._look_around and (turn := self._look_around.twist(T_map_base)):
            return _Decision(turn, "looking around")
        if goal is not self._sought:
            self._sought = goal
            self._confirmation = self._fresh_confirmation()
        confirmation, previous = self._confirmation, self._previous
        if confirmation.looking:
            elements = self._perception.clip_map.elements
            confirmed = confirmation.verdict(elements, scores, points, T_map_base[:2, 3])
            if confirmed is None:
                return _Decision(STOP, "making sure", previous)
            if confirmed:
                here = f"similarity {scores[confirmation.confirmed]:.3f}, seen from near by"
                return _Decision(STOP, "arrived", previous, ended=(Outcome.ARRIVED, here))
        grid = mapper.grid()
        action = objectnav(
            points,
            confirmation.believable(scores, points),
            goal.threshold,
            grid,
            T_map_base,
            self._config.objectnav,
            self._config.navigator,
            previous,
        )
        if action is None:
            corner = self._frontiers.act(grid, T_map_base, self._config.navigator, previous)
            if corner is None:
                reason = "everything that can be reached was seen, and nothing is similar enough"
                return _Decision(STOP, "nothing left to see", ended=(Outcome.NOT_FOUND, reason))
            return _Decision(corner.twist, "looking into corners", corner, exploring=True)
        navigation = action.navigation
        if navigation.arrived and not action.exploring:
            confirmation.begin(self.steps + 1, action.threshold, navigation.goal_xy)
            return _Decision(STOP, "making sure", navigation, False, action.threshold)
        activity = "exploring" if action.exploring else "going to what was found"
        return _Decision(navigation.twist, activity, navigation, action.exploring, action.threshold)

    def _fresh_confirmation(self) -> Confirmation:
        return Confirmation(
            self._config.navigator.reach, self._config.objectnav.confirmation_radius
        )

    def _step(
        self,
        frame: RGBDFrame,
        estimate: PoseEstimate,
        T_map_base: SE3,
        decision: _Decision,
        goal: Goal | None,
        points: NDArray[np.float64],
        scores: NDArray[np.float32],
    ) -> Step:
        assert self._perception is not None
        navigation, threshold = decision.navigation, decision.threshold
        if threshold is None:
            threshold = 0.0 if goal is None else goal.threshold
        step = Step(
            index=self.steps,
            frame=frame,
            estimate=estimate,
            T_map_base=T_map_base,
            grid=self._perception.grid(),
            goal="" if goal is None else goal.text,
            activity=decision.activity,
            path=None if navigation is None else navigation.path,
            target=None if navigation is None or decision.exploring else navigation.goal_xy,
            distance_to_go=None if navigation is None else navigation.distance,
            threshold=threshold,
            points=points,
            similarities=scores,
            ended=decision.ended,
        )
        self.steps += 1
        return step
