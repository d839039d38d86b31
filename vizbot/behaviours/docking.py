"""The way home, to where the run began or onto the dock, and the way off the dock."""

from __future__ import annotations

import numpy as np

from nav.config import RecoveryConfig
from vizbot.config import DockingConfig
from vizbot.core.interfaces import Base
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, BaseState, PoseEstimate, Tracking, Twist
from vizbot.objectnav.tasks import Decision, Errand, Task, Waypoint

SURE = 5
"""Number of frames in a row that must report the dock before it is believed."""


class HomePlaces:
    """Remembers where the robot was first on this map and where its dock stands."""

    def __init__(self, config: DockingConfig) -> None:
        self._config = config
        self._start: Waypoint | None = None
        self._before_dock: Waypoint | None = None

    def observe(self, state: BaseState | None, estimate: PoseEstimate, T_map_base: SE3) -> None:
        """Remember the first known place, and the dock's: a robot on its dock faces it."""
        if estimate.tracking is Tracking.LOST:
            return
        if self._start is None:
            self._start = _ahead(T_map_base, 0.0)
        if state is not None and state.docked:
            self._before_dock = _ahead(T_map_base, -self._config.search_distance)

    def waypoint(self, task: Errand) -> Waypoint | None:
        """The place where a task ends; None where it has none or the place is not known."""
        match task:
            case Waypoint():
                return task
            case Task.COME_BACK:
                return self._start
            case Task.DOCK:
                return self._before_dock or self._start
        return None


class Docking:
    """Lets the base drive onto its dock by itself, and takes it back."""

    def __init__(self, config: DockingConfig) -> None:
        self._config = config
        self._seeking_since: float | None = None
        self._parked = False

    def prepare(self, base: Base, state: BaseState, task: Errand) -> None:
        """Make a base obey that is to drive, and one that waits on its dock charge."""
        if task is not Task.DOCK:
            self._take_back(base, task)
        if task is Task.MAP and state.docked and state.mode.obeys:  # it would drain its battery
            base.dock()
            self._parked = True

    def forget(self) -> None:
        """Forget that the base looks for its dock or waits on it."""
        self._seeking_since, self._parked = None, False

    def seek_dock(self, base: Base, now: float) -> Decision:
        """Make the base look for its dock from here."""
        base.dock()
        self._seeking_since = now
        return Decision(STOP, "docking", idle=True)

    def decide(
        self, base: Base, state: BaseState, now: float, stop: Decision | None
    ) -> Decision | None:
        """What to do while the base is on its dock or looks for it; None before that.

        A `stop` that a pressed button or a lifted robot demands comes first.
        """
        if stop is not None and self._seeking_since is not None:
            self._take_back(base, Task.DOCK)
            return stop
        if state.docked and not state.mode.obeys:  # in Safe mode it would not charge
            self._seeking_since, self._parked = None, True
            return Decision(STOP, "on the dock", ended=(Outcome.ARRIVED, "it is on its dock"))
        if state.docked and self._seeking_since is None:
            return self.seek_dock(base, now)
        if self._parked:  # it was pushed off
            self._take_back(base, Task.DOCK)
        if self._seeking_since is None:
            return None
        if now - self._seeking_since <= self._config.contact_timeout:
            return Decision(STOP, "docking", idle=True)
        self._take_back(base, Task.DOCK)
        missed = f"the base has not found its dock within {self._config.contact_timeout:.0f} s"
        return Decision(STOP, "no dock", ended=(Outcome.GAVE_UP, f"{missed}; is it plugged in?"))

    def _take_back(self, base: Base, task: Errand) -> None:
        """Make a base obey again that looks for its dock, or one that charges if it is to drive."""
        if self._seeking_since is not None or (self._parked and task is not Task.MAP):
            self._seeking_since, self._parked = None, False
            base.resume()


class Undocking:
    """Backs away from the dock, which stands in front of the robot, until it can turn.

    The wheels measure the way: the pose may stand still or jump while the camera looks at the dock.
    """

    def __init__(self, config: RecoveryConfig) -> None:
        self._config = config
        self._docked_frames = 0
        self._T_odom_dock: SE3 | None = None

    def decide(self, state: BaseState) -> Decision | None:
        """What to do on the dock and close to it; None away from it."""
        self._docked_frames = self._docked_frames + 1 if state.docked else 0
        if self._T_odom_dock is None:
            if not state.docked:
                return None
            if self._docked_frames < SURE:
                return Decision(STOP, "standing still, perhaps on the dock")
            self._T_odom_dock = state.T_odom_base
        way = np.linalg.norm((state.T_odom_base - self._T_odom_dock)[:2, 3])
        if way >= self._config.undocking and not state.docked:
            self._T_odom_dock = None
            return None
        back = Twist(-self._config.back_off_speed, 0.0)
        return Decision(back, "leaving the dock", leaves_dock=True)


def _ahead(T_map_base: SE3, distance: float) -> Waypoint:
    x, y = (T_map_base @ np.array([distance, 0.0, 0.0, 1.0]))[:2]
    return Waypoint(float(x), float(y))
