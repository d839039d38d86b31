"""The way home: back to where the run began, or to the dock, where the base finds the contacts."""

from __future__ import annotations

import numpy as np

from vizbot.config import DockingConfig
from vizbot.core.interfaces import Base
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, BaseState, PoseEstimate, Tracking
from vizbot.objectnav.tasks import Decision, Goal, Task, Waypoint


class Docking:
    """Knows where the run began and where the dock stands, and when the base drives by itself."""

    def __init__(self, config: DockingConfig) -> None:
        """Neither is known yet."""
        self._config = config
        self._start: Waypoint | None = None
        self._before_dock: Waypoint | None = None
        self._seeks_since: float | None = None
        self._parked = False

    def forget_places(self) -> None:
        """Another map begins; what the base does now goes on."""
        self._start = self._before_dock = None

    def notice(self, state: BaseState | None, estimate: PoseEstimate, T_map_base: SE3) -> None:
        """Remember the first place that is known, and where the dock is: who is on it faces it."""
        if estimate.tracking is Tracking.LOST:
            return
        if self._start is None:
            self._start = _ahead(T_map_base, 0.0)
        if state is not None and state.docked:
            self._before_dock = _ahead(T_map_base, -self._config.before)

    def place(self, task: Goal | Waypoint | Task) -> Waypoint | None:
        """Where a task leads that need not be found; None for another or where it is not known."""
        match task:
            case Waypoint():
                return task
            case Task.COME_BACK:
                return self._start
            case Task.DOCK:
                return self._before_dock or self._start
        return None

    def seek_dock(self, base: Base, now: float) -> Decision:
        """Let the base look for its dock from here."""
        base.dock()
        self._seeks_since = now
        return Decision(STOP, "docking")

    def docks(
        self, base: Base, state: BaseState, now: float, stop: Decision | None
    ) -> Decision | None:
        """What to do while the base is on its dock or looks for it; None before that.

        Args:
            base: Told to charge, or taken back where it does not find its dock.
            state: What it feels.
            now: Time [s].
            stop: What a person or somebody's hands demand, which comes first.
        """
        if stop is not None and self._seeks_since is not None:
            self.leave(base, Task.DOCK)
            return stop
        if state.docked and not state.mode.obeys:  # in Safe mode it would not charge
            self._seeks_since, self._parked = None, True
            return Decision(STOP, "on the dock", ended=(Outcome.ARRIVED, "it is on its dock"))
        if state.docked and self._seeks_since is None:
            return self.seek_dock(base, now)
        if self._parked:  # somebody has pushed it off
            self.leave(base, Task.DOCK)
        if self._seeks_since is None:
            return None
        if now - self._seeks_since <= self._config.patience:
            return Decision(STOP, "docking")
        self.leave(base, Task.DOCK)
        missed = f"the base has not found its dock within {self._config.patience:.0f} s"
        return Decision(STOP, "no dock", ended=(Outcome.GAVE_UP, f"{missed}; is it plugged in?"))

    def make_ready(self, base: Base, state: BaseState, task: Goal | Waypoint | Task) -> None:
        """Have a base obey that is to drive, and one that waits on its dock charge."""
        if task is not Task.DOCK:
            self.leave(base, task)
        if task is Task.MAP and state.docked and state.mode.obeys:  # it would drain its battery
            base.dock()
            self._parked = True

    def leave(self, base: Base, task: Goal | Waypoint | Task) -> None:
        """Have a base that looks for its dock obey again, one that charges only to drive."""
        if self._seeks_since is not None or (self._parked and task is not Task.MAP):
            self._seeks_since, self._parked = None, False
            base.resume()


def _ahead(T_map_base: SE3, distance: float) -> Waypoint:
    x, y = (T_map_base @ np.array([distance, 0.0, 0.0, 1.0]))[:2]
    return Waypoint(float(x), float(y))
