"""Sees from outside when a fault shows first, and when the wheels have stopped for it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sim_stubs.clock import SimulatedClock
from sim_stubs.faults import CATALOGUE, FaultSchedule
from sim_stubs.faulty_body import FaultyBody

_CREEPS = 0.002
"""A wheel that is to reverse creeps on until it rests, for its encoder feels no direction [m/s]."""
_DRIVES = 0.05
"""A robot one of whose wheels is told to turn faster drives [m/s]."""


@dataclass(frozen=True, slots=True)
class FaultStop:
    """How the wheels stopped for a fault.

    Attributes:
        fault: Its name.
        rolling: Whether they turned when it first showed.
        after: Until they were told to rest [s], to the end of that period; None if they never were.
        run_on: How far the robot rolled until then [m].
        within: The limit [s]; None where nothing can reach the wheels.
    """

    fault: str
    rolling: bool
    after: float | None
    run_on: float
    within: float | None

    @property
    def in_time(self) -> bool:
        """Whether the limit was kept, if there is one."""
        return self.within is None or (self.after is not None and self.after <= self.within + 1e-9)


class FaultWatch:
    """A `LockstepDevice` that comes after the base.

    For what the base feels, a fault shows in the first sensor frame that tells it; for a camera, in
    the first frame that is missing or black; else when it begins.

    Attributes:
        shown: When each fault showed first [s].
        moved_again: Whether the robot drove once nothing was wrong any more.
    """

    def __init__(
        self, body: FaultyBody, schedule: FaultSchedule, clock: SimulatedClock, camera_period: float
    ) -> None:
        """Watch a body; its camera gives a frame every `camera_period` [s]."""
        self._body = body
        self._schedule = schedule
        self._clock = clock
        self._camera_period = camera_period
        self._names = schedule.names
        self._asked_before = (0.0, 0.0)
        self._rolling: dict[str, bool] = {}
        self._stopped: dict[str, float] = {}
        self._run_on: dict[str, float] = {}
        self.shown: dict[str, float] = {}
        self.moved_again = False

    def publish(self) -> None:
        """The base has just spoken."""
        now = self._clock.now()
        for name in self._names - self.shown.keys():
            began = self._schedule.began(name)
            if began is not None and self._shows(name, began, now):
                self._show(name)

    def program_ends(self) -> None:
        """The program has just given its last command."""
        self._show("process-killed")

    def advance(self, seconds: float) -> None:
        """The base has just obeyed."""
        left, right = self._asked_before = self._body.asked
        for name in self.shown.keys() - self._stopped.keys():
            if self._rests(name):
                self._stopped[name] = self._clock.now() + seconds
            else:
                self._run_on[name] += abs(left + right) / 2 * seconds
        nothing_wrong = all(
            name in self.shown and not self._schedule.active(name)
            for name in self._names
            if math.isfinite(CATALOGUE[name].seconds)
        )
        self.moved_again |= nothing_wrong and max(abs(left), abs(right)) > _DRIVES

    def stops(self) -> tuple[FaultStop, ...]:
        """For every fault that has shown and demands it, or makes it impossible."""
        return tuple(
            FaultStop(
                name,
                self._rolling[name],
                round(self._stopped[name] - at, 3) if name in self._stopped else None,
                round(self._run_on[name], 3),
                self._limit(name),
            )
            for name, at in sorted(self.shown.items())
            if CATALOGUE[name].stops_within is not None or not CATALOGUE[name].reaches_wheels
        )

    def _show(self, name: str) -> None:
        self.shown[name] = self._clock.now()
        self._rolling[name] = self._asked_before != (0.0, 0.0)
        self._run_on[name] = 0.0

    def _limit(self, name: str) -> float | None:
        """What is seen late because of another fault, or cannot be told to the wheels, has more.

        A base that is silent tells of no bump: then the limit of the silence holds.
        """
        at = self.shown[name]
        meanwhile = [
            CATALOGUE[other]
            for other, shown in self.shown.items()
            if shown <= at + 0.5 and self._lasted(other) >= at
        ]
        if not all(fault.reaches_wheels for fault in meanwhile):
            return None
        limits = [fault.stops_within for fault in meanwhile if fault.stops_within is not None]
        return max(limits, default=None)

    def _lasted(self, name: str) -> float:
        return self.shown[name] + max(CATALOGUE[name].seconds, 0.5)

    def _shows(self, name: str, began: float, now: float) -> bool:
        contacts = self._body.contacts
        match name:
            case "bump":
                return contacts.bump_left or contacts.bump_right
            case "cliff":
                return any(contacts.cliffs)
            case "wheel-drop" | "kidnapped":
                return any(contacts.wheel_drops)
            case "stuck-wheel":
                return self._body.stalls
            case "camera-frozen" | "camera-vanishes" | "black-depth":
                due = math.ceil(began / self._camera_period - 1e-6) * self._camera_period
                return now >= due - 1e-9
            case "process-killed":
                return False
        return True

    def _rests(self, name: str) -> bool:
        """Whether the robot does what it must: what is ahead forbids only to go ahead."""
        left, right = self._body.asked
        if name in ("bump", "stuck-wheel", "black-depth"):
            return (left + right) / 2 <= _CREEPS
        return (left, right) == (0.0, 0.0)
