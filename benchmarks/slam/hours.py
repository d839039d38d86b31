"""`vizbot bench slam --hours N`: does an update cost the same after hours in one home?

The laps of a home are replayed to and fro for that time, so that frames repeat.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from rich.console import Console

from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import Fingerprint, key_of_settings, key_of_sources
from benchmarks.harness.store import Store
from benchmarks.harness.tables import markdown_table
from benchmarks.slam.homes import TRACKED_BY, recording_folder
from benchmarks.slam.laps import LapConfig, record_laps
from benchmarks.slam.replays import ReplayFrame, to_and_fro
from mapping.slam.slam import Slam
from vizbot.config import Config
from vizbot.core.geometry import invert
from vizbot.core.types import SE3

NAME = "slam hours"
_HOUR = 3600.0


@dataclass(frozen=True, slots=True)
class Hour:
    """Cost of one hour of driving.

    Attributes:
        frames: Number of tracked frames.
        way: True length of the path [m].
        keyframes: Number of keyframes at the end.
        closures: Number of loop closures at the end.
        error: Mean distance from the truth, with the first pose given [m].
        ms_mean: Mean processor time a frame, which other programs do not lengthen much [ms].
        ms_p95: 95th percentile of that time [ms].
        memory: Peak memory of the program so far [bytes].
    """

    frames: int
    way: float
    keyframes: int
    closures: int
    error: float
    ms_mean: float
    ms_p95: float
    memory: int


@dataclass(frozen=True, slots=True)
class DrivenHours:
    """Hours of driving in one home.

    Attributes:
        home: Seed of the home.
        laps: Number of laps of the recording that was replayed to and fro.
        rate: Frames a second of the recording.
        hours: Cost of each hour; the last one may be a part of an hour.
    """

    home: int
    laps: int
    rate: float
    hours: tuple[Hour, ...]

    @property
    def last_over_first(self) -> float:
        """Time a frame in the last hour over that in the first."""
        return self.hours[-1].ms_mean / self.hours[0].ms_mean

    @property
    def bytes_a_metre(self) -> float | None:
        """Growth of the memory since the first hour [bytes/m]; None with a single hour."""
        way = sum(hour.way for hour in self.hours[1:])
        return (self.hours[-1].memory - self.hours[0].memory) / way if way else None


def run_slam_hours(home: int, hours: float, config: Config, folder: Path) -> BenchResult:
    """Record a home if need be, replay it, print a row for each hour, and keep them.

    It takes `hours` [h] of the recording's own time; the last row may be a part of an hour.
    """
    laps, fingerprint = LapConfig(), Fingerprint.taken(config.clip)
    recordings = recording_folder(fingerprint, laps, config)
    recording = recordings / f"home-{home}"
    record_laps(home, recording, config, laps)
    log, done = Console(stderr=True), list[Hour]()
    for hour in track_hours(to_and_fro(recording), hours, config):
        done.append(hour)
        log.print(f"hour {len(done)}: {hour.ms_mean:.1f} ms a frame, {hour.keyframes} keyframes")
    driven = DrivenHours(home, laps.laps, laps.rate, tuple(done))
    key = f"{recordings.name}-{key_of_sources(*TRACKED_BY)}-{key_of_settings(config)}"
    Store(folder / "hours.jsonl", DrivenHours).add(
        key, fingerprint.commit, fingerprint.hardware, driven
    )
    return hours_result(driven)


def track_hours(frames: Iterator[ReplayFrame], hours: float, config: Config) -> Iterator[Hour]:
    """Track frames for `hours` and yield the cost of each hour, and of the rest."""
    first = next(frames)
    slam = Slam(first.frame.intrinsics, config.mount.T_base_cam, config.perception.slam)
    start = slam.track(first.frame, first.T_odom_base)
    T_world_map = first.T_world_cam @ invert(start.T_map_cam)
    count, log = 1, _Log(first)
    for moment in frames:
        passed = moment.frame.stamp - first.frame.stamp
        if passed >= min(count, hours) * _HOUR:
            yield log.hour(slam)
            if passed >= hours * _HOUR:
                return
            count, log = count + 1, _Log(moment)
        began = time.process_time()
        estimate = slam.track(moment.frame, moment.T_odom_base)
        log.add(moment, T_world_map @ estimate.T_map_cam, time.process_time() - began)


@dataclass
class _Log:
    """Frames of one hour."""

    last: ReplayFrame
    way: float = 0.0
    errors: list[float] = field(default_factory=list)
    times_ms: list[float] = field(default_factory=list)

    def add(self, moment: ReplayFrame, T_world_cam: SE3, seconds: float) -> None:
        truth = moment.T_world_cam[:3, 3]
        self.way += float(np.linalg.norm(truth - self.last.T_world_cam[:3, 3]))
        self.errors.append(float(np.linalg.norm(truth - T_world_cam[:3, 3])))
        self.times_ms.append(1000.0 * seconds)
        self.last = moment

    def hour(self, slam: Slam) -> Hour:
        return Hour(
            len(self.times_ms),
            self.way,
            len(slam.keyframe_poses()),
            len(slam.closures),
            float(np.mean(self.errors)),
            float(np.mean(self.times_ms)),
            float(np.percentile(self.times_ms, 95)),
            1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
        )


def hours_result(driven: DrivenHours) -> BenchResult:
    """A table with a row for each hour, and the cost of the last hour relative to the first."""
    ratio, growth = driven.last_over_first, driven.bytes_a_metre
    header = ("hour", "frames", "way [m]", "keyframes", "closures", "mean error [m]",
              "ms a frame", "95th percentile", "memory [MB]")  # fmt: skip
    rows = [
        [
            number,
            hour.frames,
            f"{hour.way:.0f}",
            hour.keyframes,
            hour.closures,
            f"{hour.error:.3f}",
            f"{hour.ms_mean:.1f}",
            f"{hour.ms_p95:.1f}",
            f"{hour.memory / 1e6:.0f}",
        ]
        for number, hour in enumerate(driven.hours, start=1)
    ]
    grown = "" if growth is None else f"; since then memory grew by {growth:.0f} bytes a metre"
    notes = [
        f"Home {driven.home}, {driven.laps} laps at {driven.rate:g} frames a second, driven to and"
        " fro: the frames repeat. Times are of the processor, all its cores added up.",
        f"The last hour costs {ratio:.2f} times the first{grown}.",
    ]
    return BenchResult(
        NAME,
        [{"row": number} | asdict(hour) for number, hour in enumerate(driven.hours, start=1)],
        {
            "home": driven.home,
            "frames": sum(hour.frames for hour in driven.hours),
            "last_over_first": ratio,
            "bytes_a_metre": growth,
        },
        "\n\n".join([markdown_table(header, rows), *notes]),
    )
