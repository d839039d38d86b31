"""Measures how long the robot's program takes: `python -m benchmarks.loop_latency`.

It times every embedding and every decision of a drive in a simulated home, on one thread as the
benchmarks have it, and keeps the durations for their episodes. Times are those of the thread on its
processor, which are durations on an idle machine. Caches are shared all the same: little else
should run meanwhile.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import typer
from pydantic_core import to_json

from benchmarks.episodes.episode import Episode
from benchmarks.episodes.homes import open_episode
from benchmarks.episodes.latency import MEASURED, DecidedBase, Latencies
from benchmarks.episodes.run import encoder_of
from benchmarks.harness.bench_plan import UNATTENDED
from benchmarks.harness.fingerprint import commit, hardware
from benchmarks.harness.workers import in_parallel
from vizbot.core.files import write_whole
from vizbot.core.interfaces import Clock, Pending
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig

T = TypeVar("T")

EPISODE = Episode(1100, ("bathtub",))
"""The drive, in a home of development."""
STEPS = 200
"""Number of measured steps."""


@dataclass
class LoopTimes:
    """Durations of the program's work.

    Attributes:
        embedding: Of the embedding of one frame [s].
        decision: From frame and base state to the command that they lead to [s].
    """

    embedding: list[float] = field(default_factory=list)
    decision: list[float] = field(default_factory=list)
    _began: float = 0.0

    def begin_decision(self) -> None:
        """The program has frame and state."""
        self._began = time.thread_time()

    def end_decision(self) -> None:
        """The program commands the base."""
        self.decision.append(time.thread_time() - self._began)


class TimedClock:
    """A clock that times the work which is started on it."""

    def __init__(self, clock: Clock, times: LoopTimes) -> None:
        self._clock, self._times = clock, times
        self.simulated = clock.simulated
        self.now, self.sleep, self.repeat = clock.now, clock.sleep, clock.repeat

    def start(self, work: Callable[[], T], latency: float) -> Pending[T]:
        """Do `work` and time it."""

        def timed() -> T:
            began = time.thread_time()
            try:
                return work()
            finally:
                self._times.embedding.append(time.thread_time() - began)

        return self._clock.start(timed, latency)


def timed_drive(steps: int) -> LoopTimes:
    """Drive twice, the first time so that everything is loaded and compiled; time the second."""
    times = LoopTimes()
    for count in (steps // 4, steps):
        times = LoopTimes()
        config = UNATTENDED
        with open_episode(EPISODE, config) as world, Rig(config, "sim", "sim", world) as rig:
            base = rig.devices.base
            assert base is not None
            devices = replace(
                rig.devices,
                clock=TimedClock(rig.devices.clock, times),
                base=DecidedBase(base, times.end_decision, times.begin_decision),
            )
            pipeline = Pipeline(devices, encoder_of(config), config, [])
            goal = pipeline.goal(EPISODE.goals[0])
            while pipeline.steps < count:
                step = pipeline.tick(goal)
                if step is None or step.ended is not None:
                    break
    return times


def measure_latencies(steps: int = STEPS) -> Latencies:
    """Measure on this machine, in a process that is set up as those of the benchmarks."""
    load = round(os.getloadavg()[0], 2)
    [(_, times)] = in_parallel(timed_drive, [steps], "loop latency", _line)
    return Latencies(
        commit(), hardware(), load, _milliseconds(times.embedding), _milliseconds(times.decision)
    )


def _milliseconds(seconds: list[float]) -> tuple[float, ...]:
    """Durations [s] to the millisecond."""
    return tuple(round(each, 3) for each in seconds)


def _line(steps: int, times: LoopTimes) -> str:
    parts = []
    for name, values in (("embedding", times.embedding), ("decision", times.decision)):
        median, p95, most = 1000 * np.quantile(values, (0.5, 0.95, 1.0))
        parts.append(f"{name} {median:.0f} ms (95 %: {p95:.0f}, most {most:.0f})")
    return f"{steps} steps: {', '.join(parts)}"


def keep_latencies(out: Path = MEASURED) -> None:
    """Measure on this machine and keep the durations in a file."""
    write_whole(out, to_json(asdict(measure_latencies())) + b"\n")


if __name__ == "__main__":
    typer.run(keep_latencies)
