"""Parts that drives and missions share: the times of the faults, and the loop of a run."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from benchmarks.faults.minimal_robot import ENDED_BY, LogObserver
from benchmarks.faults.monitor import FaultMonitor
from sim_stubs.faults.catalogue import CATALOGUE, PlannedFault
from vizbot.core.errors import VizbotError
from vizbot.core.interfaces import Base, Clock, Devices
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP
from vizbot.objectnav.tasks import Goal, Task
from vizbot.pipeline import Pipeline

_APART = 2.0
"""Longest time between the beginnings of two faults [s]."""
_WATCHED = 3.0
"""Time for which a robot that waits for an answer is watched: it must stay where it is [s]."""


class HungError(BaseException):
    """A run takes too long on this machine. Only the benchmark may catch this error."""


def plan_faults(
    names: Sequence[str],
    begins: tuple[float, float],
    longest: float,
    rng: np.random.Generator,
) -> list[PlannedFault]:
    """Draw times for faults.

    Args:
        names: One or two faults; faults of the firmware begin at the start.
        begins: Earliest and latest time at which the first fault is due [s]; it waits until the
            robot rolls ahead.
        longest: Longest duration of a fault that passes [s].
        rng: Source of the times.
    """
    first = rng.uniform(*begins)
    starts = (first, first + rng.uniform(0.0, _APART))
    planned = []
    for name, start in zip(names, starts, strict=False):
        fault = CATALOGUE[name]
        lasts = fault.seconds if math.isinf(fault.seconds) else min(fault.seconds, longest)
        from_start = name == "mode-off-by-one"
        planned.append(
            PlannedFault(fault, 0.0 if from_start else start, lasts, rolling=not from_start)
        )
    return planned


def run_to_end(
    pipeline: Pipeline,
    devices: Devices,
    task: Goal | Task,
    observer: LogObserver | None,
    monitor: FaultMonitor | None,
    until: Callable[[], bool],
) -> tuple[Outcome, str, str]:
    """Tick until the task ends, the program is killed, or `until` returns True.

    Returns:
        The outcome, its reason, and the error of a crash or a hang, which is empty without one.
    """
    base = devices.base
    assert base is not None
    try:
        while not until():
            step = pipeline.tick(task)
            if observer is not None and monitor is not None and observer.ended_by is not None:
                if observer.ended_by == "hangs-docking":
                    _dock(base, devices.clock)
                monitor.program_ends(observer.ended_by)
                devices.clock.sleep(2.0)  # the wheels must stay at rest
                return Outcome.GAVE_UP, ENDED_BY[observer.ended_by], ""
            if step is not None and step.ended is not None:
                base.drive(STOP)
                devices.clock.sleep(0.5)
                return *step.ended, ""
            if step is not None and step.question is not None:  # nobody is there to be asked
                base.drive(STOP)
                devices.clock.sleep(_WATCHED)
                return Outcome.GAVE_UP, step.question.unanswered, ""
        base.drive(STOP)
        devices.clock.sleep(0.5)
    except VizbotError as error:
        return Outcome.GAVE_UP, str(error), ""
    except (Exception, HungError) as error:
        return Outcome.GAVE_UP, "", f"{type(error).__name__}: {' '.join(str(error).split())}"
    return Outcome.GAVE_UP, "", ""


def _dock(base: Base, clock: Clock) -> None:
    """Let the base look for its dock for a second, as a program does that is well."""
    base.dock()
    end = clock.now() + 1.0
    while clock.now() < end:
        base.drive(STOP)
        clock.sleep(0.1)
    base.drive(STOP)


@contextmanager
def limit_wall_time(seconds: float) -> Iterator[None]:
    """Raise HungError after `seconds` of wall time, and again every second."""

    def end(*_: object) -> None:
        raise HungError(f"not over after {seconds:g} s")

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
