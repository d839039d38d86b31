"""Monitor of a fault: when it shows first, when the wheels stop for it, and what follows."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.roomba.commands import Command, Opcode
from sim_stubs.faults.catalogue import CABLE_OUT, CATALOGUE, FaultSchedule
from sim_stubs.faults.faulty_base import FaultyRoomba
from vizbot.core.simulated_clock import SimulatedClock

_AHEAD = 0.05
"""Speed above which a robot drives on [m/s]."""
_SETTLED = 1.0
"""Time after the end of all faults from which a robot that rolls ahead has driven on [s]."""
_ROUNDED = 0.01
"""Highest speed at which a robot creeps that turns on the spot [m/s]: its commanded speeds avoid
bytes that are opcodes."""
FARTHEST_ASTRAY = 0.5 * (0.3 + 0.015)
"""Farthest that a wheel may turn beyond its commands [m]: at full speed, until the reflex that
waits 0.3 s for a command has stopped it, and one period."""
_FELT = (
    "bump", "cliff", "virtual-wall", "stuck-wheel",
    "bumper-stays", "wall-stays", "overcurrent-stays",
)  # fmt: skip
"""Faults that the robot may back off and turn away from while they last, and may meet again."""


@dataclass(frozen=True, slots=True)
class FaultStop:
    """How the wheels stopped for a fault.

    Attributes:
        fault: Name of the fault.
        rolling: Whether the wheels turned when it first showed.
        after: Time until the wheels were commanded to rest [s], to the end of that period, and
            stayed at rest while the fault lasted. The longest time where it happened again; None
            if they never rested. Where no command can reach the wheels, the time counts from when
            one can again, and is None if the first command then was no stop.
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
        """Whether the wheels stopped within the limit."""
        return self.after is not None and self.after <= self.within + 1e-9


@dataclass(slots=True)
class _Course:
    """The motion of the wheels during a fault.

    Attributes:
        rolling: Whether the wheels turned when the fault first showed.
        since: Time since which the fault demands rest [s]; None before.
        rests: Whether the wheels rest.
        answered: The longest time until they rested [s]; None before.
        run_on: How far the robot rolled meanwhile [m].
    """

    rolling: bool
    since: float | None = None
    rests: bool = False
    answered: float | None = None
    run_on: float = 0.0


class FaultMonitor:
    """A `LockstepDevice` that comes after the base.

    A fault that the base senses shows in the first whole sensor frame that reports it. A fault of
    the camera shows in the first frame that is missing or black. An unplugged cable shows when a
    program holds the port again. Every other fault shows when it begins.

    A stop counts only if the wheels stay at rest while the fault lasts. The robot may back off and
    turn away from an obstacle, but not go farther ahead; running into it again is another stop.

    Attributes:
        shown: When each fault showed first [s].
        drove_on: Whether the robot rolled ahead and touched nothing, 1 s after all faults had
            shown, passing faults had passed, and the wheels had come to rest where they must.
        astray: Farthest that a wheel turned in one go beyond the commands of the program [m].
    """

    def __init__(
        self,
        base: FaultyRoomba,
        schedule: FaultSchedule,
        clock: SimulatedClock,
        camera_period: float,
    ) -> None:
        """Monitor a base with a camera that gives a frame every `camera_period` [s]."""
        self._base = base
        self._body = base.body
        self._schedule = schedule
        self._clock = clock
        self._camera_period = camera_period
        self._names = schedule.names
        self._asked = [(0.0, 0.0), (0.0, 0.0)]
        self._commanded: tuple[float, float] | None = None
        self._astray = 0.0
        self._courses: dict[str, _Course] = {}
        self._touching: set[str] = set()
        self._first_once_back: Command | None = None
        self._over_since: float | None = None
        self.shown: dict[str, float] = {}
        self.drove_on = False
        self.astray = 0.0

    @property
    def happened(self) -> bool:
        """Whether every fault has shown."""
        return self.shown.keys() == self._names

    def publish(self) -> None:
        """Look at the sensor frame that the base has just sent."""
        now = self._clock.now()
        for name in sorted(self._names):
            began = self._schedule.began(name)
            if began is None:
                continue
            if name not in self._courses:
                self._courses[name] = _Course(self._turned(name))
            feels = name in _FELT and self._feels(name)
            if name not in self.shown:
                if self._shows(name, began, now):
                    self._show(name)
            elif feels and self._base.heard and name not in self._touching:
                course = self._courses[name]
                course.since, course.rests = now if course.rests else course.since, False
            if not feels:
                self._touching.discard(name)
            elif self._base.heard:
                self._touching.add(name)

    def program_ends(self, fault: str) -> None:
        """Note that the program has just sent its last command, because of this fault."""
        self._show(fault)

    def advance(self, seconds: float) -> None:
        """Look at the motion of the base in the last period."""
        asked = self._body.asked
        self._asked = [self._asked[-1], asked]
        self._compare_with_commands(asked, seconds)
        for name, course in self._courses.items():
            if name not in self.shown:
                if not CATALOGUE[name].reaches_wheels:
                    course.run_on += _rolled(asked, seconds)
                continue
            commanded = asked if self._commanded is None else self._commanded
            if course.rests and self._lasts(name):
                # A corrupted byte moves the wheels as well; that is no answer of the program.
                course.rests = not all(_breaks_rest(name, each) for each in (asked, commanded))
            if course.rests:
                continue
            if (_breaks_rest if course.answered is not None else _has_to_stop)(name, asked):
                course.run_on += _rolled(asked, seconds)
            else:
                assert course.since is not None
                after = self._clock.now() + seconds - course.since
                course.rests, course.answered = True, max(after, course.answered or 0.0)
        self._check_drives_on(asked)

    def stops(self) -> tuple[FaultStop, ...]:
        """The stops for all faults that have shown and demand one."""
        return tuple(
            FaultStop(
                name,
                self._courses[name].rolling,
                self._stopped_after(name),
                round(self._courses[name].run_on, 3),
                self._limit(name, limit),
            )
            for name in sorted(self.shown)
            if (limit := CATALOGUE[name].stops_within) is not None
        )

    def _show(self, name: str) -> None:
        self.shown[name] = self._clock.now()
        course = self._courses.setdefault(name, _Course(False))
        # A base that stops by itself has stopped in the period before its frame reports it.
        course.rolling, course.since = self._turned(name), self._clock.now()

    def _turned(self, name: str) -> bool:
        return any(_has_to_stop(name, asked) for asked in self._asked)

    def _lasts(self, name: str) -> bool:
        return name in self._touching if name in _FELT else self._schedule.active(name)

    def _compare_with_commands(self, asked: tuple[float, float], seconds: float) -> None:
        """Compare the commands of the program with the motion of the base."""
        schedule = self._schedule
        was_out = any(schedule.began(name) is not None for name in CABLE_OUT)
        back = was_out and not any(schedule.active(name) for name in CABLE_OUT)
        for command in self._base.sent:
            if back and self._first_once_back is None:
                self._first_once_back = command
            if command.opcode is Opcode.DRIVE_DIRECT:
                right, left = command.arguments
                self._commanded = left / 1000, right / 1000
        if not self._base.connected or self._commanded is None:
            self._astray = 0.0  # no command can reach the wheels
            return
        beyond = max(_beyond(*each) for each in zip(asked, self._commanded, strict=True))
        self._astray = self._astray + beyond * seconds if beyond > 0.0 else 0.0
        self.astray = max(self.astray, self._astray)

    def _check_drives_on(self, asked: tuple[float, float]) -> None:
        now, felt = self._clock.now(), self._body.contacts
        if not (self.happened and all(self._is_over(name) for name in self._names)):
            self._over_since = None
            return
        if self._over_since is None:
            self._over_since = now
        touches = felt.bump_left or felt.bump_right or any(felt.cliffs) or any(felt.wheel_drops)
        settled = now - self._over_since >= _SETTLED - 1e-9
        self.drove_on |= settled and not touches and sum(asked) / 2 > _AHEAD

    def _is_over(self, name: str) -> bool:
        fault = CATALOGUE[name]
        if fault.stops_within is not None and not self._courses[name].rests:
            return False
        return math.isinf(fault.seconds) or not self._schedule.active(name)

    def _stopped_after(self, name: str) -> float | None:
        course, first = self._courses[name], self._first_once_back
        if name in CABLE_OUT and first != Command(Opcode.DRIVE_DIRECT, (0, 0)):
            return None
        return round(course.answered, 3) if course.rests and course.answered is not None else None

    def _limit(self, name: str, limit: float) -> float:
        """The limit of a fault, longer where the cable is unplugged before the wheels rest."""
        shown = self.shown[name]
        for cable in CABLE_OUT:
            out, back = self._schedule.began(cable), self.shown.get(cable, math.inf)
            if out is not None and name != cable and out <= shown + limit and shown <= back:
                limit = back + (CATALOGUE[cable].stops_within or 0.0) - shown
        return round(limit, 3)

    def _feels(self, name: str) -> bool:
        contacts = self._body.contacts
        match name:
            case "bump":
                return contacts.bump_left or contacts.bump_right
            case "cliff":
                return any(contacts.cliffs)
            case "stuck-wheel":
                return self._body.stalls
        return self._schedule.active(name)

    def _shows(self, name: str, began: float, now: float) -> bool:
        match name:
            case name if name in _FELT:
                return self._base.heard and self._feels(name)
            case "wheel-drop" | "kidnapped":
                return self._base.heard and any(self._body.contacts.wheel_drops)
            case "mode-passive" | "charger-plugged":
                return self._base.heard  # it happens right before the base publishes
            case "camera-frozen" | "camera-vanishes" | "black-depth":
                due = math.ceil(began / self._camera_period - 1e-6) * self._camera_period
                return now >= due - 1e-9
            case "port-vanishes" | "lifted-unheard":
                return self._base.connected and not self._schedule.active(name)
            case "process-killed" | "hangs-docking":
                return False
        return True


def _has_to_stop(name: str, asked: tuple[float, float]) -> bool:
    """Whether wheels with these speeds, left and right [m/s], have to be stopped for a fault.

    Without depth the robot may turn on the spot, away from a wall that the map knows, or back off
    straight.
    """
    left, right = asked
    ahead = (left + right) / 2
    if name == "black-depth" and (abs(ahead) <= _ROUNDED or left == right < 0.0):
        return False
    return asked != (0.0, 0.0)


def _breaks_rest(name: str, asked: tuple[float, float]) -> bool:
    """Whether wheels with these speeds, left and right [m/s], do not rest for a fault."""
    if name in _FELT:
        return sum(asked) / 2 > _ROUNDED
    return _has_to_stop(name, asked)


def _rolled(asked: tuple[float, float], seconds: float) -> float:
    return abs(sum(asked)) / 2 * seconds


def _beyond(asked: float, commanded: float) -> float:
    """How much faster than commanded, or backwards, a wheel turns [m/s]."""
    return abs(asked - min(max(asked, min(commanded, 0.0)), max(commanded, 0.0)))
