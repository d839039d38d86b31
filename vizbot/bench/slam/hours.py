"""`vizbot bench slam --hours N`: does an update cost the same after hours in one home?

The laps of a home are replayed to and fro for that time, so that frames repeat.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field

import numpy as np
from rich.console import Console

from mapping.slam.slam import Slam
from vizbot.bench.harness.bench_plan import BenchResult
from vizbot.bench.harness.fingerprint import Fingerprint
from vizbot.bench.harness.tables import markdown_table
from vizbot.bench.slam.homes import recording_folder
from vizbot.bench.slam.laps import LapConfig, record_laps
from vizbot.bench.slam.replays import ReplayFrame, to_and_fro
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


def run_slam_hours(home: int, hours: float, config: Config) -> BenchResult:
    """Record a home if need be, replay it, and print a row for each hour.

    Args:
        home: Seed of the home.
        hours: Duration in the recording's own time [h]; the last row may be a part of an hour.
        config: Settings of the robot.
    """
    laps = LapConfig()
    folder = recording_folder(Fingerprint.taken(config.clip), laps, config) / f"home-{home}"
    record_laps(home, folder, config, laps)
    log, done = Console(stderr=True), list[Hour]()
    for hour in track_hours(to_and_fro(folder), hours, config):
        done.append(hour)
        log.print(f"hour {len(done)}: {hour.ms_mean:.1f} ms a frame, {hour.keyframes} keyframes")
    return hours_result(home, laps, done)


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
    """Frames of one hour.

    Attributes:
        last: The frame before them.
    """

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


def hours_result(home: int, laps: LapConfig, done: list[Hour]) -> BenchResult:
    """A table with a row for each hour, and the cost of the last hour relative to the first."""
    first, last = done[0], done[-1]
    way = sum(hour.way for hour in done[1:])
    growth = (last.memory - first.memory) / way if way else None
    ratio = last.ms_mean / first.ms_mean
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
        for number, hour in enumerate(done, start=1)
    ]
    grown = "" if growth is None else f"; since then memory grew by {growth:.0f} bytes a metre"
    notes = [
        f"Home {home}, {laps.laps} laps at {laps.rate:g} frames a second, driven to and fro:"
        " the frames repeat. Times are of the processor, all its cores added up.",
        f"The last hour costs {ratio:.2f} times the first{grown}.",
    ]
    return BenchResult(
        NAME,
        [{"row": number} | asdict(hour) for number, hour in enumerate(done, start=1)],
        {
            "home": home,
            "frames": sum(hour.frames for hour in done),
            "last_over_first": ratio,
            "bytes_a_metre": growth,
        },
        "\n\n".join([markdown_table(header, rows), *notes]),
    )
