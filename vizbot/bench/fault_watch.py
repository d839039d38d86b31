"""Sees from outside when a fault shows first, when the wheels stop for it, and what comes then."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sim_stubs.clock import SimulatedClock
from sim_stubs.faults import CATALOGUE, FaultSchedule
from sim_stubs.faulty_base import FaultyRoomba

_AHEAD = 0.05
"""A robot that is told to roll faster drives on [m/s]."""


_ROUNDED = 0.01
"""Wheels that turn on the spot are told speeds of which no byte is an opcode: the robot creeps so
fast at most [m/s]."""


@dataclass(frozen=True, slots=True)
class FaultStop:
    """How the wheels stopped for a fault.

    Attributes:
        fault: Its name.
        rolling: Whether they turned when it first showed.
        after: Until they were told to rest [s], to the end of that period; None if they never were.
            Where nothing can reach the wheels it counts from when something can again.
        run_on: How far the robot rolled since the fault began to show [m].
        within: The limit [s].
    """

    fault: str
    rolling: bool
    after: float | None
    run_on: float
    within: float

    @property
    def in_time(self) -> bool:
        """Whether the limit was kept."""
        return self.after is not None and self.after <= self.within + 1e-9


class FaultWatch:
    """A `LockstepDevice` that comes after the base.

    For what the base feels, a fault shows in the first sensor frame that tells it and arrives
    whole; for a camera, in the first frame that is missing or black; for a cable that is out, when
    it is back; else when it begins.

    Attributes:
        shown: When each fault showed first [s].
        drove_on: Whether the robot drove ahead after all faults had shown, those that pass had
            passed, and the wheels had rested where they must.
    """

    def __init__(
        self,
        base: FaultyRoomba,
        schedule: FaultSchedule,
        clock: SimulatedClock,
        camera_period: float,
    ) -> None:
        """Watch a base; the camera on it gives a frame every `camera_period` [s]."""
        self._base = base
        self._body = base.body
        self._schedule = schedule
        self._clock = clock
        self._camera_period = camera_period
        self._names = schedule.names
        self._asked = [(0.0, 0.0), (0.0, 0.0)]
        self._rolling: dict[str, bool] = {}
        self._stopped: dict[str, float] = {}
        self._run_on: dict[str, float] = {}
        self.shown: dict[str, float] = {}
        self.drove_on = False

    @property
    def happened(self) -> bool:
        """Whether every fault has shown."""
        return self.shown.keys() == self._names

    def publish(self) -> None:
        """The base has just spoken."""
        for name in self._names - self.shown.keys():
            began = self._schedule.began(name)
            if began is None:
                continue
            if name not in self._rolling:
                self._rolling[name] = any(_has_to_stop(name, asked) for asked in self._asked)
                self._run_on[name] = 0.0
            if self._shows(name, began, self._clock.now()):
                self._show(name)

    def program_ends(self) -> None:
        """The program has just given its last command."""
        self._show("process-killed")

    def advance(self, seconds: float) -> None:
        """The base has just obeyed."""
        left, right = self._body.asked
        self._asked = [self._asked[-1], (left, right)]
        if self._schedule.active("black-depth") and _has_to_stop("black-depth", (left, right)):
            self._stopped.pop("black-depth", None)  # it had not stopped for good
        for name in self._run_on.keys() - self._stopped.keys():
            if name in self.shown and not _has_to_stop(name, (left, right)):
                self._stopped[name] = self._clock.now() + seconds
            elif name in self.shown or not CATALOGUE[name].reaches_wheels:
                self._run_on[name] += abs(left + right) / 2 * seconds
        over = self.happened and all(self._is_over(name) for name in self._names)
        self.drove_on |= over and (left + right) / 2 > _AHEAD

    def stops(self) -> tuple[FaultStop, ...]:
        """For every fault that has shown and demands it."""
        return tuple(
            FaultStop(
                name,
                self._rolling[name],
                round(self._stopped[name] - at, 3) if name in self._stopped else None,
                round(self._run_on[name], 3),
                self._limit(name, limit),
            )
            for name, at in sorted(self.shown.items())
            if (limit := CATALOGUE[name].stops_within) is not None
        )

    def _show(self, name: str) -> None:
        self.shown[name] = self._clock.now()
        # A base that stops by itself has done so in the period before its frame tells.
        self._rolling[name] = any(_has_to_stop(name, asked) for asked in self._asked)
        self._run_on.setdefault(name, 0.0)

    def _is_over(self, name: str) -> bool:
        if math.isfinite(CATALOGUE[name].seconds):
            return not self._schedule.active(name)
        return CATALOGUE[name].stops_within is None or name in self._stopped

    def _limit(self, name: str, limit: float) -> float:
        """Where the cable comes out before a fault is answered, that waits until it is back."""
        at = self.shown[name]
        out = self._schedule.began("port-vanishes")
        back = self.shown.get("port-vanishes", math.inf)
        if out is not None and name != "port-vanishes" and out <= at + limit and at <= back:
            limit = back + (CATALOGUE["port-vanishes"].stops_within or 0.0) - at
        return round(limit, 3)

    def _shows(self, name: str, began: float, now: float) -> bool:
        contacts, heard = self._body.contacts, self._base.heard
        match name:
            case "bump":
                return heard and (contacts.bump_left or contacts.bump_right)
            case "cliff":
                return heard and any(contacts.cliffs)
            case "wheel-drop" | "kidnapped":
                return heard and any(contacts.wheel_drops)
            case "stuck-wheel":
                return heard and self._body.stalls
            case "mode-passive":
                return heard  # it happens right before the base speaks
            case "camera-frozen" | "camera-vanishes" | "black-depth":
                due = math.ceil(began / self._camera_period - 1e-6) * self._camera_period
                return now >= due - 1e-9
            case "port-vanishes":
                return not self._schedule.active(name)
            case "process-killed":
                return False
        return True


def _has_to_stop(name: str, asked: tuple[float, float]) -> bool:
    """Whether wheels told these speeds, left and right [m/s], must be told to rest for a fault.

    Without depth the robot may turn on the spot, away from a wall that the map knows, or back off
    straight.
    """
    left, right = asked
    ahead = (left + right) / 2
    if name == "black-depth" and (abs(ahead) <= _ROUNDED or left == right < 0.0):
        return False
    return asked != (0.0, 0.0)
