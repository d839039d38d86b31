"""What comes before any task: help from a person, an empty battery, contacts, lost tracking."""

from __future__ import annotations

from vizbot.behaviours.docking import Undocking
from vizbot.behaviours.recovery import ContactRecovery, VisionRecovery
from vizbot.config import Config, GyroSettlingConfig
from vizbot.core.observer import OpenQuestion, Outcome
from vizbot.core.types import SE3, STOP, BaseState, Button, PoseEstimate, RGBDFrame
from vizbot.objectnav.tasks import Decision
from vizbot.perception.interfaces import ObstacleMapper

MAYBE_MOVED = OpenQuestion(
    "somebody may have moved me: go on?",
    "somebody may have moved the robot while its base was not heard; look at it and start again,"
    " or set resume_safe in [roomba]",
)


def ask_whether_moved(state: BaseState) -> Decision | None:
    """What to do with a base that somebody may have moved unheard; None with any other.

    Its pose is not trusted: once somebody says to go on, the robot first relocalises.
    """
    if not state.maybe_moved:
        return None
    return Decision(STOP, MAYBE_MOVED.text, question=MAYBE_MOVED, idle=True)


class BaseModeMonitor:
    """Waits a while for a base, whose mode keeps it from driving, to obey again."""

    def __init__(self, patience: float) -> None:
        """Wait for up to `patience` [s]."""
        self._patience = patience
        self._passive_since: float | None = None

    def decide(self, state: BaseState, now: float, *, at_edge: bool) -> Decision | None:
        """What to do while the base does not obey; None while it does.

        With `at_edge` an edge explains it: there a base in Safe mode stops by itself.
        """
        if state.mode.obeys:
            self._passive_since = None
            return None
        if self._passive_since is None:
            self._passive_since = now
        if at_edge:
            return None
        if now - self._passive_since < self._patience:
            return Decision(STOP, "waiting for the base to obey")
        reason = f"the base is in {state.mode.name} mode and does not drive; launch again"
        return Decision(STOP, "the base does not drive", ended=(Outcome.GAVE_UP, reason))


class Lifting:
    """Ends the task of a lifted robot, or stops it until it is put down."""

    def __init__(self, patience: float, *, resume_safe: bool) -> None:
        """Begin on the floor; with `resume_safe` wait up to `patience` [s] to be put down."""
        self._patience = patience
        self._resume_safe = resume_safe
        self._since: float | None = None

    @property
    def lifted(self) -> bool:
        """Whether it was lifted and has not obeyed since."""
        return self._since is not None

    def decide(self, state: BaseState, now: float) -> Decision | None:
        """What to do while a wheel hangs and until the base obeys again; None on the floor."""
        hangs = any(state.wheel_drops)
        if hangs and self._since is None:
            self._since = now
        if not hangs and state.mode.obeys:
            self._since = None
        if self._since is None or not (hangs or self._resume_safe):
            return None
        if self._resume_safe and now - self._since < self._patience:
            return Decision(STOP, "waiting to be put down", idle=True)
        reason = "a wheel hangs; put the robot on the floor"
        if not hangs:
            reason = "the base does not obey since it was lifted; press Clean and launch again"
        return Decision(STOP, "stopped, lifted", ended=(Outcome.GAVE_UP, reason))


class GyroSettling:
    """Keeps the robot at rest at first, so that the bias of its camera's gyroscope is learned."""

    def __init__(self, config: GyroSettlingConfig) -> None:
        self._config = config
        self._frames = 0
        self._since = 0.0

    def goes_on(self, frame: RGBDFrame) -> bool:
        """Whether the robot should stand still after `frame`; call once a frame."""
        if self._frames == 0:
            self._since = frame.stamp
        self._frames += 1
        if len(frame.imu.gyro_stamps) == 0:
            return False
        early = frame.stamp < self._since + self._config.seconds
        return early or self._frames <= self._config.frames


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

        Depth has shown nothing for `depth_lost_for` [s], None while it shows something. `mapper`
        takes what was touched, and the floor under the robot as free. On its way `to_dock` the
        robot goes on, however little charge is left.
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
        """A stop that only a person can lift, or asked for; None without one."""
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
