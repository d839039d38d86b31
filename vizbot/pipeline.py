"""One tick of the robot: see, map, decide, move (the paper's figure 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.belief import PlaceBelief
from mapping.clip.patches import ALL_PIXELS, NEAR_MEDIAN
from mapping.clip.scores import Background, Query
from mapping.map_bundle import MapBundle, require_encoder
from mapping.map_snapshot import MapSnapshot
from mapping.occupancy.depth_mapper import require_resolution
from vizbot.behaviours.blind_motion import BlindMotion
from vizbot.behaviours.docking import Docking
from vizbot.behaviours.errand import Errand
from vizbot.behaviours.short_move import ShortMove
from vizbot.config import Config
from vizbot.core.devices import Devices
from vizbot.core.errors import ConfigError
from vizbot.core.observer import Candidate, GoalReport, Observer, Observers, Outcome, Step
from vizbot.core.place_scores import Measure
from vizbot.core.types import SE3, STOP, BaseState, OccupancyGrid, PoseEstimate, RGBDFrame, Twist
from vizbot.current_map import CurrentMap
from vizbot.objectnav import reasons
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.candidates import believed_places, most_similar_places, scores_of
from vizbot.objectnav.odometer import Odometer
from vizbot.objectnav.paper_search import PaperSearch
from vizbot.objectnav.tasks import Decision, Goal, Task, goal_of
from vizbot.perception.depth_loss import DepthLossMonitor
from vizbot.perception.first_frames import FirstFrames
from vizbot.perception.interfaces import PerceptionParts
from vizbot.perception.perception import Perception
from vizbot.perception.sensor_reader import SensorReader, SensorReading
from vizbot.perception.sightings import Sightings

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder


@dataclass(frozen=True, slots=True, eq=False)
class _TrackedFrame:
    """A frame whose place is known, as far as it can be.

    Attributes:
        frame: What the camera saw.
        state: What the base reported then; None without a base.
        estimate: Where the camera was.
        T_map_base: Where the robot was.
    """

    frame: RGBDFrame
    state: BaseState | None
    estimate: PoseEstimate
    T_map_base: SE3


def require_usable(saved_map: MapBundle | None, encoder: ClipEncoder, config: Config) -> None:
    """Raise a `MapError` for a map of another encoder or with cells of another size."""
    if saved_map is not None:
        require_encoder(saved_map, encoder)
        require_resolution(saved_map.grid, config.perception.depth_mapper)


class Pipeline:
    """Runs the ticks of one run and reports its steps to the observers.

    Attributes:
        config: Settings of all parts.
        steps: How many were done so far.
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

        Args:
            devices: Camera, base and clock.
            encoder: Of images and goals.
            config: Settings of all parts.
            observers: They receive every step and every goal's report.
            parts: Parts of perception that replace the built-in ones, as a benchmark's true ones.
            saved_map: The map to continue; None begins an empty one.

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
        self._depth_loss = DepthLossMonitor(config.frontier)
        self._docking = Docking(config.docking)
        self._blind_motion = BlindMotion(config.recovery.undocking, config.roomba.command_timeout)
        self._odometer = Odometer()
        self._newest: RGBDFrame | None = None
        self.steps = 0
        self.map = CurrentMap(0, saved_map, config)
        # Once a run, not once a map, and where the frames are embedded: it takes a while.
        parts = parts or PerceptionParts()
        background = parts.background or cache(partial(Background.embedded_by, encoder))
        spreads = ALL_PIXELS if config.objectnav.method == "paper" else NEAR_MEDIAN
        self._parts = replace(parts, background=background, patch_spreads=spreads)

    def require_usable(self, saved_map: MapBundle | None) -> None:
        """Raise a `MapError` for a map of another encoder or with cells of another size."""
        require_usable(saved_map, self._encoder, self.config)

    def begin_map(self, saved_map: MapBundle | None) -> None:
        """Leave the present map, and continue a saved one or, with None, begin an empty one.

        A saved map is worked in before the present one is left: whatever is wrong with it leaves
        the robot where it was.

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
        """The goal for these words, with the encoder's or the configured threshold."""
        return goal_of(self._encoder, text, self.config.objectnav.threshold)

    def question(self, goal: Goal) -> Query:
        """What the beliefs of places are asked for a goal."""
        return Query(goal.embedding, self._encoder.log_odds, goal.rivals)

    def tick(self, task: Errand) -> Step | None:
        """Do one step, for a goal or another task.

        Returns:
            What was done. `ended` says whether the task is over; then the base was stopped first.
            None at the end of a recording.

        Raises:
            DeviceError: a device is gone or silent.
        """
        while (reading := self._sensors.next()) is not None:
            tracked = self._track(reading)
            if tracked.state is not None:
                now, by_hand = self._devices.clock.now(), task is Task.MAP
                self._blind_motion.observe(tracked.state, now, by_hand=by_hand)
            decision = self._decide_for_safety(task, tracked)
            if decision is not None or not self._continue_step(tracked):
                return self._step(task, tracked, decision)
        self._first_frames.note(None)
        return None

    def _track(self, reading: SensorReading) -> _TrackedFrame:
        """Work a frame into the poses and the obstacle map."""
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
        return _TrackedFrame(frame, state, estimate, T_map_base)

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

    def _decide_for_safety(self, task: Errand, tracked: _TrackedFrame) -> Decision | None:
        """What comes before any search; None where the task may go on."""
        base, state = self._devices.base, tracked.state
        if state is not None and state.maybe_moved:
            self._docking.forget()
            return self.map.safety.stop_for_good(state, self._devices.clock.now())
        if base is not None and state is not None:
            self._docking.prepare(base, state, task)
        if task is Task.MAP:
            return Decision(STOP, "mapping")
        if base is None or state is None:
            return None
        perception, now = self.map.perception, self._devices.clock.now()
        T_map_base, to_dock = tracked.T_map_base, task is Task.DOCK
        self._depth_loss.observe(tracked.frame, T_map_base, perception.grid, now)
        if to_dock:
            stop = self.map.safety.stop_for_good(state, now)
            decision = self._docking.decide(base, state, now, stop)
            if decision is not None:
                return decision
        if task is Task.FIND_PLACE and (state.docked or state.plugged_in):
            charging = "the robot charges; ask for something, and it looks for its place first"
            return Decision(STOP, "on the charger", ended=(Outcome.GAVE_UP, charging))
        decision = self.map.safety.decide(
            state,
            tracked.estimate,
            T_map_base,
            perception.depth_mapper,
            now,
            self._depth_loss.seconds,
            to_dock=to_dock,
        )
        self.map.close_ahead(self.map.safety.turned_away_from())
        return decision

    def _continue_step(self, tracked: _TrackedFrame) -> bool:
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

    def _step(self, task: Errand, tracked: _TrackedFrame, decision: Decision | None) -> Step:
        """Embed what is seen, decide unless that is done, drive, and report the step."""
        perception, base = self.map.perception, self._devices.base
        frame, T_map_base = tracked.frame, tracked.T_map_base
        waiting = task is Task.MAP and base is not None
        perception.embed(frame, tracked.estimate, standing=waiting)
        points, grid = perception.points(), self.map.grid()
        goal = task if isinstance(task, Goal) else None
        self._odometer.observe(goal, T_map_base, self._devices.clock.now())
        seen = None if goal is None else self._seen_for(goal)
        if decision is None:
            self.map.exploration.look(grid, T_map_base)
            self.map.leave_alone(self._devices.clock.now())
            decision = self._decide(task, tracked, grid, seen)
            if not isinstance(self.map.search, PaperSearch):
                decision = self.map.second_try.instead_of(
                    decision, task, perception.depth_mapper, self.map.exploration.frontiers
                )
        else:
            self.map.interrupt()
        decision = self._guarded(task, decision, T_map_base, grid)
        decision = self._blind_motion.permit(decision, self._devices.clock.now())
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
            scores=None if seen is None else scores_of(seen),
            measure=self._measure,
            threshold=self._threshold(goal, decision),
            points=points,
            frames=perception.clip_map.elements.frames,
            boxes=perception.clip_map.elements.boxes,
            keyframe_poses=perception.slam.keyframe_poses(),
            closures=perception.slam.closures,
            frontiers=self.map.exploration.frontiers.frontiers_xy,
            ended=decision.ended,
            command=command,
            seen_share=self.map.exploration.frontiers.seen_share,
            candidate_xy=None if goal is None else self._candidate_xy(decision),
            decided_score=decision.score,
            question=decision.question,
        )
        self.steps += 1
        self._observers.on_step(step)
        return step

    def _decide(
        self,
        task: Errand,
        tracked: _TrackedFrame,
        grid: OccupancyGrid,
        seen: PlaceBelief | Sightings | None,
    ) -> Decision:
        """What to do for the task, for a goal by what was `seen`; nothing more urgent is due."""
        T_map_base, search = tracked.T_map_base, self.map.search
        if self.map.gyro_settling.goes_on(tracked.frame):
            return Decision(STOP, "standing still, to learn the gyroscope's bias")
        if task is Task.FIND_PLACE:  # a robot that is lost does not come this far
            known = "the robot knows where it is on the map"
            return Decision(STOP, "found its place", ended=(Outcome.LOCATED, known))
        if isinstance(task, ShortMove):
            return self.map.short_motion.decide(task, T_map_base, grid)
        if (place := self.map.places.waypoint(task)) is not None:
            decision = self.map.waypoint_drive.decide(place, grid, T_map_base)
            base = self._devices.base
            arrived = decision.ended is not None and decision.ended[0] is Outcome.ARRIVED
            if task is Task.DOCK and arrived and base is not None:
                return self._docking.seek_dock(base, self._devices.clock.now())
            return decision
        looks = self.config.objectnav.look_around and self.map.saved is None
        if (
            looks
            and not isinstance(search, PaperSearch)
            and (turn := self.map.look_around.twist(T_map_base))
        ):
            return Decision(turn, "looking around", why=reasons.AROUND)
        if not isinstance(task, Goal):
            return self.map.exploration.decide(grid, T_map_base)
        if isinstance(search, PaperSearch):
            assert isinstance(seen, Sightings)
            return search.go(task, seen, grid, T_map_base)
        assert isinstance(seen, PlaceBelief)
        return search.go(task, seen, grid, T_map_base)

    def _guarded(
        self, task: Errand, decision: Decision, T_map_base: SE3, grid: OccupancyGrid
    ) -> Decision:
        """The decision, or another one where nothing comes of such decisions."""
        guard, navigation = self.map.progress, decision.navigation
        if task is Task.MAP or self._devices.base is None:
            guard.rest()
            return decision
        aim_xy = self._candidate_xy(decision)
        if navigation is not None and aim_xy is None:
            distant = navigation.goal is None  # what is gone to is where the map ends
            aim_xy = navigation.path[-1] if distant else navigation.goal_xy
        seen, now = self.map.exploration.seen(grid), self._devices.clock.now()
        return guard.instead_of(decision, task, aim_xy, T_map_base, seen, now)

    def _candidate_xy(self, decision: Decision) -> NDArray[np.float64] | None:
        """The place that the search by belief goes up to; None without one."""
        search, navigation = self.map.search, decision.navigation
        if navigation is None or decision.exploring or isinstance(search, PaperSearch):
            return None
        return search.place_of(navigation)

    def _seen_for(self, goal: Goal) -> PlaceBelief | Sightings:
        """What the map shows of a goal, as the method of search takes it."""
        perception, search = self.map.perception, self.map.search
        if isinstance(search, BeliefSearch):
            return self._believed(search, goal)
        embeddings = perception.clip_map.embeddings
        return perception.sightings(self.map.scores.similarities_to(goal, embeddings))

    @property
    def _measure(self) -> Measure:
        """What the scores of places are."""
        by_paper = isinstance(self.map.search, PaperSearch)
        return Measure.SIMILARITY if by_paper else Measure.PROBABILITY

    def _threshold(self, goal: Goal | None, decision: Decision) -> float:
        """The score that places were held against in this step; 0 without a goal.

        Where something more urgent was due, it is that of the newest step of the search.
        """
        if goal is None:
            return 0.0
        decided = decision.threshold
        return self.map.search.threshold(goal) if decided is None else decided

    def _drive(self, task: Errand, decision: Decision, tracked: _TrackedFrame) -> Twist | None:
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
        """Report how the search for `goal` ended, with the best places on the map.

        The reason ends with how the encoder understood the words, where that needs saying.
        """
        threshold = self.map.search.threshold(goal)
        return self._reported(goal, outcome, reason, threshold)

    def _reported(self, goal: Goal, outcome: Outcome, reason: str, threshold: float) -> GoalReport:
        """Tell the observers how a goal ended, its best place held against a threshold."""
        reason = reason if goal.note is None else f"{reason}; {goal.note}"
        arrived = outcome is Outcome.ARRIVED
        report = GoalReport(
            goal.text,
            outcome,
            reason,
            self._candidates(goal, arrived=arrived),
            self._measure,
            self._odometer.effort(goal),
            threshold,
        )
        self._observers.on_goal(report)
        return report

    def refute(self, place_xy: NDArray[np.float64] | None = None) -> None:
        """Take it that a place is not what the robot searches for, or searched for last.

        The place is believed less by every search for the same words on this map.

        Args:
            place_xy: (2,) in `map` [m]; None for where the robot has arrived.

        Raises:
            ConfigError: the method `paper` believes nothing.
        """
        self._believing_search().refute(place_xy)

    def affirm(self, place_xy: NDArray[np.float64]) -> None:
        """Take it that what the robot searches for is at (2,) a place in `map` [m].

        Raises:
            ConfigError: the method `paper` believes nothing.
        """
        self._believing_search().affirm(place_xy)

    def candidate(self, place_xy: NDArray[np.float64]) -> Candidate | None:
        """The place of the present search that is nearest to (2,) a point in `map` [m].

        Returns:
            None where nothing is searched for, or nothing was seen.

        Raises:
            ConfigError: the method `paper` believes nothing.
        """
        search = self._believing_search()
        if (goal := search.goal) is None:
            return None
        belief, question = self._believed(search, goal), self.question(goal)
        places = believed_places(self.map.perception, belief, question, place_xy)
        return next(iter(places), None)

    def _believing_search(self) -> BeliefSearch:
        if isinstance(self.map.search, PaperSearch):
            raise ConfigError(
                "the method 'paper' cannot learn what a place is; search with --method belief"
            )
        return self.map.search

    def look_up(self, goal: Goal) -> GoalReport:
        """Ask the map as it is now (paper, section III-B) and report the answer."""
        candidates, config = self._candidates(goal), self.config.objectnav
        least = goal.threshold if config.method == "paper" else config.answer_probability
        enough = f"{self._measure} {self._measure.text(least)}"
        if candidates and candidates[0].score > least:
            return self._reported(goal, Outcome.LOCATED, f"above the {enough}", least)
        reason = f"the best place on the map is not above the {enough}"
        return self._reported(goal, Outcome.NOT_FOUND, reason, least)

    def _candidates(self, goal: Goal, *, arrived: bool = False) -> tuple[Candidate, ...]:
        """The best places for a goal; that where the robot has arrived comes first."""
        if not self.map.has_frames:
            return ()
        perception, search = self.map.perception, self.map.search
        if isinstance(search, PaperSearch):
            return most_similar_places(perception, goal, search.answer if arrived else None)
        answer_xy = search.answer_xy if arrived else None
        belief, question = self._believed(search, goal), self.question(goal)
        return believed_places(perception, belief, question, answer_xy)

    def _believed(self, search: BeliefSearch, goal: Goal) -> PlaceBelief:
        """What the robot believes of the places of its map."""
        belief = search.belief_of(goal, self.question(goal))
        return search.as_judged(goal, self.map.perception.believe(belief))
