"""What the base feels and tracking loses come before anything that is looked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nav.look_around import LookAround
from nav.recovery import Recovery, contact_points, edge_points
from vizbot.config import Config
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, BaseState, Button, PoseEstimate, Tracking, Twist
from vizbot.objectnav.tasks import Decision
from vizbot.perception.interfaces import ObstacleMapper


class SafetyBehaviours:
    """Backs off from what was touched, edges and the dock; looks around when lost or blind."""

    def __init__(self, config: Config) -> None:
        """Nothing has happened yet."""
        self._config = config
        self._recovery = Recovery(config.recovery)
        self._touched = ""
        self._at_edge_since: float | None = None
        self._lifted_at: float | None = None
        self._passive_since: float | None = None
        self._recognising = LookAround(config.objectnav.recognising_rate)
        self._looking_for_sight = LookAround(config.objectnav.recognising_rate)
        self._docked_at: NDArray[np.float64] | None = None

    def to(
        self,
        state: BaseState,
        estimate: PoseEstimate,
        T_map_base: SE3,
        mapper: ObstacleMapper,
        now: float,
        blind_for: float | None = None,
        *,
        to_dock: bool = False,
    ) -> Decision | None:
        """What base and tracking demand; None when they demand nothing.

        Args:
            state: What the base feels.
            estimate: Where the camera is.
            T_map_base: Where the robot is.
            mapper: Told what was touched, and that there is floor under the robot.
            now: Time [s].
            blind_for: How long depth has shown nothing [s]; None while it shows something.
            to_dock: Whether it is on its way to its dock, however little charge is left.
        """
        radius = self._config.navigator.costmap.robot_radius
        if (stop := self.stop_for_good(state, now)) is not None:
            return stop
        floor = self._config.recovery.battery_floor
        if state.battery is not None and state.battery < floor and not to_dock:
            empty = f"the battery is at {100 * state.battery:.0f} %; put the robot on its dock"
            return Decision(STOP, "stopped, battery low", ended=(Outcome.GAVE_UP, empty))
        edge, obeys = any(state.cliffs), state.mode.obeys
        if state.plugged_in and obeys:  # in Safe mode the base obeys no more
            return Decision(STOP, "waiting for the charger's cable to be pulled out")
        if edge and self._at_edge_since is None:
            self._at_edge_since = now
        if obeys:
            self._passive_since = None
        elif self._passive_since is None:
            self._passive_since = now
        if self._at_edge_since is None and self._passive_since is not None:
            if now - self._passive_since < self._config.recovery.passive_patience:
                return Decision(STOP, "waiting for the base to obey")
            passive = f"the base is in {state.mode.name} mode and does not drive; launch again"
            return Decision(STOP, "the base does not drive", ended=(Outcome.GAVE_UP, passive))
        recovery = self._recovery.twist(now)
        if edge or state.blocked:
            if recovery is None:
                if estimate.tracking is not Tracking.LOST:
                    ahead = state.virtual_wall and not state.bumped
                    touched = contact_points(
                        state.bump_left or ahead, state.bump_right or ahead, radius
                    )
                    felt = np.concatenate([touched, edge_points(state.cliffs, radius)])
                    mapper.mark_obstacle(T_map_base, felt)
                self._recovery.begin(now)
                self._touched = _touched(state)
                recovery = STOP
        elif recovery is None and obeys:
            self._at_edge_since = None
        if self._at_edge_since is not None:
            if now - self._at_edge_since > self._config.recovery.edge_patience:
                stuck = "the robot does not get away from an edge; put it elsewhere"
                return Decision(STOP, "stopped at an edge", ended=(Outcome.GAVE_UP, stuck))
            if not obeys:  # in Safe mode the base has stopped by itself
                if not self._config.roomba.resume_safe:
                    held = "the base stopped at an edge; put it elsewhere, or set resume_safe"
                    return Decision(STOP, "stopped at an edge", ended=(Outcome.GAVE_UP, held))
                self._recovery.begin(now)
                recovery = STOP
        if recovery is not None:
            what = self._touched if self._at_edge_since is None else "an edge"
            return Decision(recovery, f"backing off after {what}")
        if (leaving := self._leave_dock(state, T_map_base)) is not None:
            return leaving
        if blind_for is not None:
            return self._wait_for_sight(blind_for, T_map_base)
        self._looking_for_sight = LookAround(self._config.objectnav.recognising_rate)
        if estimate.tracking is Tracking.LOST:
            turn = self._recognising.twist(T_map_base)
            if turn is not None:
                return Decision(turn, "lost, looking around")
            lost = "the robot was carried to where it has not been; put it where it has been"
            return Decision(STOP, "lost, standing still", ended=(Outcome.GAVE_UP, lost))
        self._recognising = LookAround(self._config.objectnav.recognising_rate)
        mapper.mark_free(T_map_base, radius)
        return None

    def stop_for_good(self, state: BaseState, now: float) -> Decision | None:
        """What only a person can help with; None while there is nothing of that kind."""
        config, permitted = self._config.recovery, self._config.roomba.resume_safe
        if Button.CLEAN in state.buttons:
            pressed = "somebody pressed Clean on the base"
            return Decision(STOP, "stopped by hand", ended=(Outcome.GAVE_UP, pressed))
        hangs = any(state.wheel_drops)
        if hangs and self._lifted_at is None:
            self._lifted_at, self._at_edge_since = now, None
        if self._lifted_at is not None and not hangs and state.mode.obeys:
            self._lifted_at = None
        if hangs or (self._lifted_at is not None and permitted):
            assert self._lifted_at is not None
            if permitted and now - self._lifted_at < config.lift_patience:
                return Decision(STOP, "waiting to be put down")
            lifted = "a wheel hangs; put the robot on the floor"
            if not hangs:
                lifted = "the base does not obey since it was lifted; press Clean and launch again"
            return Decision(STOP, "stopped, lifted", ended=(Outcome.GAVE_UP, lifted))
        return None

    def _wait_for_sight(self, blind_for: float, T_map_base: SE3) -> Decision:
        """Stand still where depth shows nothing, then turn away from what may hide everything."""
        if blind_for < self._config.recovery.blind_patience:
            return Decision(STOP, "blind, standing still")
        if (turn := self._looking_for_sight.twist(T_map_base)) is not None:
            return Decision(turn, "blind, looking around")
        blind = "depth shows nothing; clean the camera, see vizbot doctor"
        return Decision(STOP, "stopped, blind", ended=(Outcome.GAVE_UP, blind))

    def _leave_dock(self, state: BaseState, T_map_base: SE3) -> Decision | None:
        """Back away from the dock, which stands before the robot, until it can turn."""
        config, here = self._config.recovery, T_map_base[:2, 3]
        if state.docked and self._docked_at is None:
            self._docked_at = here.copy()
        if self._docked_at is None or np.linalg.norm(here - self._docked_at) >= config.undocking:
            self._docked_at = None
            return None
        return Decision(Twist(-config.back_off_speed, 0.0), "leaving the dock")


def _touched(state: BaseState) -> str:
    """What the robot is to be kept from; nothing is known to be in front of a stuck wheel."""
    if state.bumped:
        return "a bump"
    return "a virtual wall" if state.virtual_wall else "a stuck wheel"
