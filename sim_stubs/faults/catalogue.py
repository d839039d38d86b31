"""The catalogue of faults in real houses, and their schedule in a run.

The faulty devices are in `faulty_base`, `faulty_body`, `faulty_camera` and `faulty_program`; none
of them reports its faults to the robot.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from vizbot.core.errors import ConfigError

STOPS_AT_CONTACT = 0.1
"""Limit for faults that the base senses, and for the loss of Safe mode [s]."""
_AGAIN = 20.0
"""Longest duration of a fault with a rate [s]."""
_MOST = 100.0
"""Highest rate of a fault [1/min]."""
_SLOW = 10.0
"""Factor of the time of embedding."""
_BACKED_OFF = "stop, back off by 0.3 m at most, then rest and say so"
_LATEST = 86400.0
"""Latest start and longest duration that may be asked for [s]."""
_HOUR = 3600.0
"""Period of drawn times [s]; no run is longer."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault of a device or program.

    Attributes:
        name: The name that `--faults` takes.
        device: The device that has the fault: `base`, `camera`, `encoder` or `program`.
        what: What happens.
        must: What the robot must do.
        seconds: Default duration [s]; infinite for the rest of the run.
        stops_within: Longest time from the first observable effect until the wheels must be at
            rest [s]; None where they need not stop.
        reaches_wheels: Whether a command can reach the wheels during the fault; if not, the time
            of `stops_within` counts from when one can again.
        goal: Whether the robot should reach its goal all the same.
        report_pattern: Regular expression of a message to the user about the fault; empty where
            none is needed.
        must_report: Whether there must be such a message; a corrupted byte may have no effect
            that is worth one.
    """

    name: str
    device: str
    what: str
    must: str
    seconds: float
    stops_within: float | None = None
    reaches_wheels: bool = True
    goal: bool = True
    report_pattern: str = ""
    must_report: bool = True


CATALOGUE: dict[str, Fault] = {
    fault.name: fault
    for fault in (
        Fault("corrupt-bytes", "base", "1 % of the bytes on the line, either way, are spoilt",
              "drop the frame, repeat the command", 5.0,
              report_pattern="the base (took|left)", must_report=False),
        Fault("lost-bytes", "base", "1 % of the bytes on the line, either way, are lost",
              "drop the frame, repeat the command", 5.0,
              report_pattern="the base (took|left)", must_report=False),
        Fault("duplicated-bytes", "base", "1 % of the bytes on the line, either way, come twice",
              "drop the frame, repeat the command", 5.0,
              report_pattern="the base (took|left)", must_report=False),
        Fault("stream-silent", "base", "the base sends nothing, and obeys",
              "stop it, wake it, go on", 2.0, 0.3,
              report_pattern="no answer from the base"),
        Fault("port-vanishes", "base", "its USB cable is out; the wheels turn on as commanded last",
              "stop it first thing when the cable is back, go on", 2.0, 0.315,
              reaches_wheels=False,
              report_pattern="the base is gone"),
        Fault("lifted-unheard", "base", "its USB cable is out, and somebody lifts it and puts it"
              " down meanwhile", "rest; go on once somebody says so, or the settings do", 4.0,
              0.315, reaches_wheels=False,
              report_pattern="the base is gone|somebody may have moved"),
        Fault("base-asleep", "base", "it falls asleep until somebody presses Clean",
              "say so, go on once it is awake", 4.0, 0.3,
              report_pattern="no answer from the base.*press Clean"),
        Fault("mode-passive", "base", "it leaves Safe mode for no reason, wheels turning",
              "ask for Safe mode again, stop, go on", 0.0, STOPS_AT_CONTACT,
              report_pattern="the base left (Safe|Full) mode"),
        Fault("mode-off-by-one", "base", "its firmware reports the mode one too high, from the"
              " start", "find it out, drive as usual", math.inf,
              report_pattern="reports its mode one too high"),
        Fault("battery-low", "base", "its battery is at 5 %", "end the search, say so", math.inf,
              goal=False,
              report_pattern="the battery is at"),
        Fault("bump", "base", "it runs into a glass pane that no depth shows",
              "stop, back off, drive around it", math.inf, STOPS_AT_CONTACT,
              report_pattern="bump"),
        Fault("cliff", "base", "an edge that no depth shows",
              "stop, back off, drive around it", math.inf, STOPS_AT_CONTACT,
              report_pattern="edge"),
        Fault("wheel-drop", "base", "somebody lifts it and puts it down where it was",
              "stop; go on once it stands, if the person allows it", 2.0, STOPS_AT_CONTACT,
              report_pattern="put down|a wheel hangs|lifted"),
        Fault("wheel-slip", "base", "the wheels count 40 % more than they roll", "go on", 3.0),
        Fault("stuck-wheel", "base", "the left wheel is stuck, its motor draws too much",
              "stop, back off, go on", 2.0, STOPS_AT_CONTACT,
              report_pattern="wheel"),
        Fault("virtual-wall", "base", "the beam of a virtual wall is across its way",
              "stop, back off, go on", 2.0, STOPS_AT_CONTACT,
              report_pattern="wall"),
        Fault("charger-plugged", "base", "somebody plugs a charger in, and pulls it out again",
              "stop; go on once it is out, if the person allows it", 2.0, STOPS_AT_CONTACT,
              report_pattern="charger"),
        Fault("encoder-jump", "base", "the encoders jump by 10000 counts", "drop that frame, go on",
              0.0,
              report_pattern="encoder counts that jumped"),
        Fault("camera-frozen", "camera", "no frame comes", "stop, go on when one comes", 2.0, 0.5,
              report_pattern="the camera sends no frames"),
        Fault("camera-vanishes", "camera", "its USB cable is out", "stop, go on when it is back",
              5.0, 0.5,
              report_pattern="the camera is unplugged"),
        Fault("black-depth", "camera", "depth shows nothing", "stop going ahead, go on when it"
              " shows something", 3.0, 0.5,
              report_pattern="blind|depth shows nothing"),
        Fault("depth-holes", "camera", "60 % of depth are holes", "go on", 10.0),
        Fault("overexposed", "camera", "colour is all white", "go on by wheels and gyroscope", 3.0),
        Fault("unpaired-frames", "camera", "half the colour images come without their depth",
              "go on with the other half", 5.0,
              report_pattern="colour and depth are"),
        Fault("half-rate", "camera", "every other frame is missing", "go on", 10.0),
        Fault("stamps-jump", "camera", "its clock is 100 s ahead", "go on by its own time", 5.0,
              report_pattern="its clock jumped"),
        Fault("imu-gap", "camera", "no inertial samples", "go on by images and wheels", 3.0),
        Fault("kidnapped", "base", "somebody carries it back to where it has been",
              "stop; find out where it is and go on, if the person allows it", 3.0,
              STOPS_AT_CONTACT,
              report_pattern="put down|a wheel hangs|lifted"),
        Fault("encoder-out-of-memory", "encoder", "no image can be embedded", "go on without", 5.0,
              report_pattern="out of memory"),
        Fault("encoder-slow", "encoder", "embedding takes ten times longer", "go on", 10.0),
        Fault("disk-full", "program", "the video cannot be written any more",
              "go on without video, keep the map", math.inf,
              report_pattern="No space left"),
        Fault("hangs-docking", "program", "the program hangs while the base looks for its dock",
              "its reflexes take the base back and stop it", 0.0, 0.315, goal=False,
              report_pattern="no command for"),
        Fault("process-killed", "program", "the program is killed", "its reflexes stop the wheels",
              0.0, 0.315, goal=False,
              report_pattern="no command for"),
        Fault("bumper-stays", "base", "its bumper is jammed, pressed in", _BACKED_OFF, math.inf,
              STOPS_AT_CONTACT, goal=False, report_pattern="bump.* has not helped"),
        Fault("wall-stays", "base", "it receives a virtual wall wherever it is", _BACKED_OFF,
              math.inf, STOPS_AT_CONTACT, goal=False, report_pattern="wall has not helped"),
        Fault("overcurrent-stays", "base", "the motor of a wheel that turns draws too much, for"
              " good", _BACKED_OFF, math.inf, STOPS_AT_CONTACT, goal=False,
              report_pattern="wheel has not helped"),
        Fault("dock-stays", "base", "it reports that it is on its dock, wherever it is",
              "back off as from a dock, by 0.6 m at most, then rest and say so", math.inf,
              goal=False, report_pattern="dock has not helped"),
    )
}  # fmt: skip

CABLE_OUT = ("port-vanishes", "lifted-unheard")
"""Faults during which no command reaches the base."""
_IN_THE_BENCHMARK = ("hangs-docking",)
"""Faults that a run cannot have by itself."""


@dataclass(frozen=True, slots=True)
class PlannedFault:
    """A fault in a run.

    Attributes:
        fault: The fault.
        start: Time since the start of the run [s]; None for times drawn at `rate`.
        seconds: Duration [s].
        rate: Occurrences a minute.
        rolling: Whether it waits until the robot rolls ahead, or another waiting fault begins.
    """

    fault: Fault
    start: float | None
    seconds: float
    rate: float = 0.0
    rolling: bool = False


def parse_faults(text: str) -> list[PlannedFault]:
    """Parse the value of `--faults`.

    Args:
        text: Faults by name, separated by commas: `bump@12` at 12 s, `bump@12+3` for 3 s,
            `lost-bytes~2` twice a minute, a name alone from the start.

    Raises:
        ConfigError: there is no such fault, or a time cannot be read.
    """
    planned = []
    for item in map(str.strip, text.split(",")):
        name = re.split("[@~+]", item)[0]
        fault = CATALOGUE.get(name)
        if fault is None:
            alike = difflib.get_close_matches(name.lower().replace("_", "-"), CATALOGUE)
            raise ConfigError(
                f"no fault {name!r} in --faults; use {' or '.join(alike) or ', '.join(CATALOGUE)}"
            )
        if name in _IN_THE_BENCHMARK:
            raise ConfigError(f"--faults {name} happens in vizbot bench faults alone; use another")
        try:
            planned.append(_planned(fault, item[len(name) :]))
        except ValueError as error:
            raise ConfigError(
                f"--faults {item!r}: give {name}, {name}@SECONDS or {name}@SECONDS+LENGTH,"
                f" {_LATEST:.0f} s at most each, or {name}~TIMES_A_MINUTE, {_MOST:.0f} at most"
            ) from error
    return planned


class FaultSchedule:
    """The schedule of the faults of a run."""

    def __init__(
        self,
        planned: Sequence[PlannedFault],
        now: Callable[[], float],
        seed: int,
    ) -> None:
        """Begin a run; `now` returns its time [s], `seed` draws times of faults with a rate."""
        self._now = now
        self._rolls: Callable[[], bool] = lambda: True
        rng = np.random.default_rng((seed, 6))
        self._disturbed = False
        self._waiting = [occurrence for one in planned for occurrence in _occurrences(one, rng)]
        self._begun: dict[str, float] = {}
        self._until: dict[str, float] = {}

    @property
    def names(self) -> frozenset[str]:
        """Names of all planned faults."""
        return frozenset(self._begun) | {occurrence.name for occurrence in self._waiting}

    def wait_for_rolling(self, rolls: Callable[[], bool]) -> None:
        """Let faults that wait for the robot to roll ahead call `rolls`."""
        self._rolls = rolls

    def slowness(self) -> float:
        """Factor of the time that embedding takes now."""
        return _SLOW if self.active("encoder-slow") else 1.0

    def active(self, name: str) -> bool:
        """Whether a fault is active now."""
        self._begin_what_is_due()
        return self._now() < self._until.get(name, -math.inf)

    def second_half(self, name: str) -> bool:
        """Whether a fault is active now, and has been for half of its time."""
        if not self.active(name):
            return False
        return self._now() >= (self._begun[name] + self._until[name]) / 2

    def began(self, name: str) -> float | None:
        """Time at which a fault last began [s]; None before."""
        self._begin_what_is_due()
        return self._begun.get(name)

    def _begin_what_is_due(self) -> None:
        now = self._now()
        for occurrence in [each for each in self._waiting if each.start <= now + 1e-9]:
            if occurrence.rolling and not (self._disturbed or self._rolls()):
                continue
            self._disturbed |= occurrence.rolling
            self._waiting.remove(occurrence)
            self._begun[occurrence.name] = now
            self._until[occurrence.name] = now + occurrence.seconds


def _planned(fault: Fault, times: str) -> PlannedFault:
    if not times:
        return PlannedFault(fault, 0.0, fault.seconds)
    if times.startswith("~"):
        lasts = min(fault.seconds, _AGAIN)
        return PlannedFault(fault, None, lasts, _between(times[1:], 1e-6, _MOST))
    if not times.startswith("@"):
        raise ValueError(times)
    start, plus, seconds = times[1:].partition("+")
    lasts = _between(seconds, 0.0, _LATEST) if plus else fault.seconds
    return PlannedFault(fault, _between(start, 0.0, _LATEST), lasts)


def _between(text: str, least: float, most: float) -> float:
    value = float(text)
    if not (math.isfinite(value) and least <= value <= most):
        raise ValueError(text)
    return value


@dataclass(frozen=True, slots=True)
class _Occurrence:
    name: str
    start: float
    seconds: float
    rolling: bool


def _occurrences(planned: PlannedFault, rng: np.random.Generator) -> list[_Occurrence]:
    """Occurrences of a fault in the next hour."""
    if planned.start is not None:
        starts = [planned.start]
    else:
        count = rng.poisson(planned.rate * _HOUR / 60)
        starts = sorted(rng.uniform(0.0, _HOUR, count))
    return [
        _Occurrence(planned.fault.name, float(start), planned.seconds, planned.rolling)
        for start in starts
    ]
