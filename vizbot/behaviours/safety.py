"""What comes before any task: help from a person, an empty battery, contacts, lost tracking."""

from __future__ import annotations

from vizbot.behaviours.base_mode import BaseModeMonitor, ask_whether_moved
from vizbot.behaviours.contact_recovery import ContactRecovery
from vizbot.behaviours.lifting import Lifting
from vizbot.behaviours.undocking import Undocking
from vizbot.behaviours.vision_recovery import VisionRecovery
from vizbot.config import Config
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, BaseState, Button, PoseEstimate
from vizbot.objectnav.tasks import Decision
from vizbot.perception.interfaces import ObstacleMapper


class SafetyBehaviours:
    """Asks one behaviour after another; the first that demands something decides."""

    def __init__(self, config: Config) -> None:
        recovery, resume_safe = config.recovery, config.roomba.resume_safe
        self._robot_radius = config.navigator.costmap.robot_radius
        self._battery_floor = recovery.min_battery
        self._lifting = Lifting(recovery.lift_timeout, resume_safe=resume_safe)
        self._base_mode = BaseModeMonitor(recovery.safe_mode_timeout)
        self._contacts = ContactRecovery(recovery, self._robot_radius, resume_safe=resume_safe)
        self._undocking = Undocking(recovery)
        self._vision = VisionRecovery(recovery.depth_timeout, config.objectnav.recognising_rate)

    def decide(
        self,
        state: BaseState,
        estimate: PoseEstimate,
        T_map_base: SE3,
        mapper: ObstacleMapper,
        now: float,
        depth_lost_for: float | None = None,
        *,
        to_dock: bool = False,
    ) -> Decision | None:
        """What base and tracking demand; None when they demand nothing.

        Args:
            state: What the base reports.
            estimate: Where the camera is.
            T_map_base: Where the robot is.
            mapper: Takes what was touched, and the floor under the robot as free.
            now: Time [s].
            depth_lost_for: How long depth has shown nothing [s]; None while it shows something.
            to_dock: Whether the robot is on its way to its dock, however little charge is left.
        """
        if (stop := self.stop_for_good(state, now)) is not None:
            return stop
        if not to_dock and (empty := self._stop_on_low_battery(state)) is not None:
            return empty
        if state.plugged_in and state.mode.obeys:  # in Safe mode the base no longer obeys
            return Decision(STOP, "waiting for the charger's cable to be pulled out", idle=True)
        self._contacts.observe_edge(state, now)
        decision = (
            self._base_mode.decide(state, now, at_edge=self._contacts.at_edge)
            or self._contacts.decide(state, estimate, T_map_base, mapper, now)
            or self._undocking.decide(state)
            or self._vision.decide(depth_lost_for, estimate.tracking, T_map_base)
        )
        if decision is None:
            mapper.mark_free(T_map_base, self._robot_radius)
        return decision

    def turned_away_from(self) -> list[SE3]:
        """Where something right ahead has hidden everything from the camera, each pose once."""
        return self._vision.turned_away_from()

    def stop_for_good(self, state: BaseState, now: float) -> Decision | None:
        """What only a person can help with; None while there is nothing of that kind."""
        if Button.CLEAN in state.buttons:
            pressed = "somebody pressed Clean on the base"
            return Decision(STOP, "stopped by hand", ended=(Outcome.GAVE_UP, pressed))
        if (asks := ask_whether_moved(state)) is not None:
            return asks
        if any(state.wheel_drops) and not self._lifting.lifted:
            self._contacts.forget_edge()
        return self._lifting.decide(state, now)

    def _stop_on_low_battery(self, state: BaseState) -> Decision | None:
        if state.battery is None or state.battery >= self._battery_floor:
            return None
        empty = f"the battery is at {100 * state.battery:.0f} %; put the robot on its dock"
        return Decision(STOP, "stopped, battery low", ended=(Outcome.GAVE_UP, empty))
