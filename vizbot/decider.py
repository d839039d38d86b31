"""What the robot does in one step: what is most urgent comes first."""

from __future__ import annotations

from dataclasses import dataclass

from vizbot.behaviours.blind_motion import BlindMotion
from vizbot.behaviours.docking import Docking
from vizbot.config import Config
from vizbot.core.interfaces import Devices
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, BaseState, OccupancyGrid, PoseEstimate, RGBDFrame
from vizbot.current_map import CurrentMap
from vizbot.objectnav import reasons
from vizbot.objectnav.tasks import Decision, Errand, Goal, ShortMove, Task
from vizbot.perception.depth_loss import DepthLossMonitor


@dataclass(frozen=True, slots=True, eq=False)
class TrackedFrame:
    """A frame with its estimated pose.

    Attributes:
        state: What the base reported then; None without a base.
    """

    frame: RGBDFrame
    state: BaseState | None
    estimate: PoseEstimate
    T_map_base: SE3


class Decider:
    """Decides for one run, whichever map the robot is in."""

    def __init__(self, devices: Devices, config: Config) -> None:
        self._base, self._clock = devices.base, devices.clock
        self._looks_around = config.objectnav.look_around
        self._depth_loss = DepthLossMonitor(config.frontier)
        self._docking = Docking(config.docking)
        self._blind_motion = BlindMotion(config.recovery.undocking, config.roomba.command_timeout)

    def before_task(
        self, task: Errand, tracked: TrackedFrame, current: CurrentMap
    ) -> Decision | None:
        """What comes before any task; None where the task may go on. Call it with every frame."""
        base, state, now = self._base, tracked.state, self._clock.now()
        if state is not None:
            self._blind_motion.observe(state, now, by_hand=task is Task.MAP)
            if state.maybe_moved:
                self._docking.forget()
                return current.safety.stop_for_good(state, now)
            if base is not None:
                self._docking.prepare(base, state, task)
        if task is Task.MAP:
            return Decision(STOP, "mapping")
        if base is None or state is None:
            return None
        perception, to_dock = current.perception, task is Task.DOCK
        self._depth_loss.observe(tracked.frame, tracked.T_map_base, perception.grid, now)
        if to_dock:
            stop = current.safety.stop_for_good(state, now)
            decision = self._docking.decide(base, state, now, stop)
            if decision is not None:
                return decision
        if task is Task.FIND_PLACE and (state.docked or state.plugged_in):
            charging = "the robot charges; ask for something, and it looks for its place first"
            return Decision(STOP, "on the charger", ended=(Outcome.GAVE_UP, charging))
        decision = current.safety.decide(
            state,
            tracked.estimate,
            tracked.T_map_base,
            perception.depth_mapper,
            now,
            self._depth_loss.seconds,
            to_dock=to_dock,
        )
        current.close_ahead(current.safety.turned_away_from())
        return decision

    def decide(
        self,
        task: Errand,
        tracked: TrackedFrame,
        current: CurrentMap,
        grid: OccupancyGrid,
        urgent: Decision | None,
    ) -> Decision:
        """What to do in this step.

        The search of the map has observed the goal; `urgent`, of `before_task`, comes before the
        task.
        """
        if urgent is not None:
            current.interrupt()
            decision = urgent
        else:
            current.exploration.look(grid, tracked.T_map_base)
            current.leave_alone(self._clock.now())
            decision = self._for_task(task, tracked, current, grid)
            if current.search.assisted:
                mapper, frontiers = current.perception.depth_mapper, current.exploration.frontiers
                decision = current.second_try.instead_of(decision, task, mapper, frontiers)
        decision = self._guarded(task, decision, tracked.T_map_base, current, grid)
        return self._blind_motion.permit(decision, self._clock.now())

    def _for_task(
        self, task: Errand, tracked: TrackedFrame, current: CurrentMap, grid: OccupancyGrid
    ) -> Decision:
        """What to do for the task; nothing more urgent is due."""
        T_map_base, search = tracked.T_map_base, current.search
        if current.gyro_settling.goes_on(tracked.frame):
            return Decision(STOP, "standing still, to learn the gyroscope's bias")
        if task is Task.FIND_PLACE:  # a robot that is lost does not come this far
            known = "the robot knows where it is on the map"
            return Decision(STOP, "found its place", ended=(Outcome.LOCATED, known))
        if isinstance(task, ShortMove):
            return current.short_motion.decide(task, T_map_base, grid)
        if (place := current.places.waypoint(task)) is not None:
            decision = current.waypoint_drive.decide(place, grid, T_map_base)
            arrived = decision.ended is not None and decision.ended[0] is Outcome.ARRIVED
            if task is Task.DOCK and arrived and self._base is not None:
                return self._docking.seek_dock(self._base, self._clock.now())
            return decision
        looks = self._looks_around and current.saved is None and search.assisted
        if looks and (turn := current.look_around.twist(T_map_base)):
            return Decision(turn, "looking around", why=reasons.AROUND)
        if isinstance(task, Goal):
            return search.decide(task, grid, T_map_base)
        return current.exploration.decide(grid, T_map_base)

    def _guarded(
        self,
        task: Errand,
        decision: Decision,
        T_map_base: SE3,
        current: CurrentMap,
        grid: OccupancyGrid,
    ) -> Decision:
        """The decision, or another one where decisions like it bring no progress."""
        guard, navigation = current.progress, decision.navigation
        if task is Task.MAP or self._base is None:
            guard.rest()
            return decision
        aim_xy = current.candidate_xy(decision)
        if navigation is not None and aim_xy is None:
            distant = navigation.goal is None  # the robot drives to where the map ends
            aim_xy = navigation.path[-1] if distant else navigation.goal_xy
        seen = current.exploration.seen(grid, exploring=task is Task.EXPLORE)
        return guard.instead_of(decision, task, aim_xy, T_map_base, seen, self._clock.now())
