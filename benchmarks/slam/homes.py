"""`vizbot bench slam` without a recording: laps of simulated homes, as recorded and with faults.

A closure is wrong when the cameras that it links are truly too far apart to see the same place.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.episodes.homes import FIRST_HOME
from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import Fingerprint, key_of_settings, key_of_sources
from benchmarks.harness.store import Store
from benchmarks.harness.workers import in_parallel
from benchmarks.slam.lap_scores import LapResult, laps_result
from benchmarks.slam.laps import LapConfig, record_laps
from benchmarks.slam.relocalisation import StartResult, random_starts
from benchmarks.slam.replays import ReplayFrame, replay
from benchmarks.slam.sensor_faults import (
    Fault,
    Span,
    dark,
    gyro_biased,
    gyro_off,
    kidnapped,
    slipping,
    twins,
    wheels_stuck,
    white_wall,
)
from mapping.keyframes.anchors import poses_in_map
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.relocalisation.local_map import LocalMap
from mapping.slam.slam import Slam
from mapping.trajectory_error import absolute_trajectory_error, normalised_errors
from vizbot.config import Config
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3, OccupancyGrid, PoseEstimate, Tracking
from vizbot.rehearsal.config import RehearsalConfig

NAME = "slam homes"
HOMES = 10
RECORDINGS = Path("runs/laps")
"""Folder of the recorded laps, which are too large to be committed."""
TRACKED_BY = ("mapping", "vizbot/core", "benchmarks/slam")
"""Sources that can change how a recording is tracked and scored."""
_EARLY, _BRIEF = Span(30.0, 60.0), Span(30.0, 40.0)
AS_RECORDED, TWINS = "as recorded", "first lap, then in an identical home"
FAULTS: dict[str, Fault | None] = {
    AS_RECORDED: None,
    "dark for 30 s": dark(_EARLY),
    "white wall for 30 s": white_wall(_EARLY),
    "wheels slip 20 % for 10 s": slipping(_BRIEF, 0.2),
    "wheels count nothing for 10 s": wheels_stuck(_BRIEF),
    "no gyroscope": gyro_off(Span(0.0, np.inf)),
    "gyroscope off by 0.05 rad/s for 10 s": gyro_biased(_BRIEF, 0.05),
    "carried for 10 s": kidnapped(_BRIEF),
    TWINS: None,
}
_CORRIDOR = 4.0
"""Length of the corridor between two homes that look the same, about that between two rooms [m]."""
_APART = 2.0
"""True distance above which two cameras see no common place [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class _TrackedReplay:
    """A replay with its pose estimates.

    Attributes:
        slam: The pose estimator after the last frame.
        grid: The obstacle map after the last frame.
        estimates: Pose estimates, one for each frame.
        truth: Ts_world_cam (F, 4, 4).
        times_ms: Processor times of tracking (F,) [ms], which other programs do not lengthen much.
        fault_end: Index of the last faulty frame; None without one.
    """

    slam: Slam
    grid: OccupancyGrid
    estimates: list[PoseEstimate]
    truth: NDArray[np.float64]
    times_ms: NDArray[np.float64]
    fault_end: int | None = None

    @property
    def T_world_map(self) -> SE3:
        """The transform that makes the first estimate true."""
        return np.asarray(self.truth[0] @ invert(self.estimates[0].T_map_cam))

    def online_error(self, index: int) -> tuple[float, float]:
        """Error of position [m] and heading [degrees] of a frame when it was tracked."""
        estimated = self.T_world_map @ self.estimates[index].T_map_cam
        T_off = invert(self.truth[index]) @ estimated
        return (
            round(float(np.linalg.norm(T_off[:3, 3])), 4),
            round(float(np.degrees(rotation_angle(T_off))), 3),
        )


@dataclass(frozen=True, slots=True)
class _Job:
    home: int
    folder: Path
    faults: tuple[str, ...]
    starts: bool
    config: Config
    laps: LapConfig


_Results = tuple[list[LapResult], list[StartResult]]


def run_slam_homes(
    seeds: Sequence[int] | None, quick: bool, config: Config, folder: Path
) -> BenchResult:
    """Record the laps that are missing, replay them with every fault, and print the tables.

    Without `seeds` the first benchmark homes are driven; if `quick`, one lap of two of them.
    """
    homes = list(seeds or range(FIRST_HOME, FIRST_HOME + (2 if quick else HOMES)))
    laps = LapConfig(laps=1 if quick else LapConfig().laps)
    fingerprint = Fingerprint.taken(config.clip)
    recordings = recording_folder(fingerprint, laps, config)
    replayed_by = key_of_sources(*TRACKED_BY)
    key = f"{recordings.name}-{replayed_by}-{key_of_settings(config)}"
    driven = Store(folder / "homes.jsonl", LapResult)
    started = Store(folder / "starts.jsonl", StartResult)
    done = {(result.home, result.fault) for result in driven.results_with_key(key)}
    known = {result.home for result in started.results_with_key(key)}
    jobs = []
    for home in homes:
        missing = tuple(fault for fault in FAULTS if (home, fault) not in done)
        recording = recordings / f"home-{home}"
        if missing or home not in known:
            jobs.append(_Job(home, recording, missing, home not in known, config, laps))
    for _, (lap_results, start_results) in in_parallel(_work, jobs, NAME, _job_line):
        driven.add(key, fingerprint.commit, fingerprint.hardware, *lap_results)
        started.add(key, fingerprint.commit, fingerprint.hardware, *start_results)
    return laps_result(
        tuple(FAULTS),
        [result for result in driven.results_with_key(key) if result.home in homes],
        [result for result in started.results_with_key(key) if result.home in homes],
        quick,
    )


def recording_folder(fingerprint: Fingerprint, laps: LapConfig, config: Config) -> Path:
    """The folder of the recordings of these homes with these settings, one folder a home."""
    by = key_of_sources(
        "drivers", "benchmarks/slam/laps.py", "benchmarks/episodes/calibration_error.py"
    )
    sim = RehearsalConfig.read(config)
    settings = key_of_settings(config.mount, config.roomba, sim.sim_camera, sim.world, laps)
    return RECORDINGS / f"{fingerprint.homes}-{by}-{settings}"


def _work(job: _Job) -> _Results:
    record_laps(job.home, job.folder, job.config, job.laps)
    laps, starts = [], list[StartResult]()
    for fault in FAULTS:
        maps = job.starts and fault == AS_RECORDED
        if fault not in job.faults and not maps:
            continue
        tracked = _track(_replayed(job, fault), job.config)
        if fault in job.faults:
            laps.append(_scored(job.home, fault, tracked))
        if maps:
            starts = random_starts(
                job.home, tracked.slam, tracked.grid, tracked.T_world_map, job.config
            )
    return laps, starts


def _replayed(job: _Job, fault: str) -> Iterable[ReplayFrame]:
    if fault == TWINS:
        frames = len((job.folder / "odometry.txt").read_text().splitlines())
        lap = frames // job.laps.laps
        first, again = (itertools.islice(replay(job.folder), lap) for _ in range(2))
        return twins(first, again, _CORRIDOR, job.config, job.home)
    change = FAULTS[fault]
    return replay(job.folder) if change is None else change(replay(job.folder))


def _track(frames: Iterable[ReplayFrame], config: Config) -> _TrackedReplay:
    settings, mount = config.perception, config.mount.T_base_cam
    mapper = DepthMapper(settings.depth_mapper)
    around = LocalMap(mapper.grid, settings.depth_mapper, settings.local_map)
    slam: Slam | None = None
    estimates, truth, times = [], [], []
    fault_end: int | None = None
    for index, moment in enumerate(frames):
        frame = moment.frame
        if slam is None:
            slam = Slam(frame.intrinsics, mount, settings.slam, around)
        began = time.process_time()
        estimate = slam.track(frame, moment.T_odom_base)
        times.append(1000.0 * (time.process_time() - began))
        estimates.append(estimate)
        truth.append(moment.T_world_cam)
        if moment.faulty:
            fault_end = index
        if estimate.tracking is not Tracking.LOST:
            mapper.integrate(
                estimate.keyframe,
                estimate.T_keyframe_cam,
                estimate.T_map_cam,
                frame.depth,
                frame.intrinsics,
            )
        mapper.follow(slam.keyframe_poses())
    assert slam is not None
    grid = mapper.grid()
    return _TrackedReplay(slam, grid, estimates, np.array(truth), np.array(times), fault_end)


def _scored(home: int, fault: str, tracked: _TrackedReplay) -> LapResult:
    slam, estimates, truth = tracked.slam, tracked.estimates, tracked.truth
    stamps = np.array([estimate.stamp for estimate in estimates])
    online = np.array([estimate.T_map_cam for estimate in estimates])
    final = poses_in_map(
        np.array([estimate.T_keyframe_cam for estimate in estimates]),
        np.array([estimate.keyframe for estimate in estimates], np.int32),
        slam.keyframe_poses(),
    )
    states = [estimate.tracking for estimate in estimates]
    taken_at = {e.keyframe: T for e, T in zip(estimates, truth, strict=True) if e.is_keyframe}
    apart = [
        float(np.linalg.norm(taken_at[i][:3, 3] - taken_at[j][:3, 3])) for i, j in slam.closures
    ]
    nees, measured_in = _consistency(estimates, truth, taken_at)
    return LapResult(
        home,
        fault,
        len(estimates),
        round(float(np.linalg.norm(np.diff(truth[:, :3, 3], axis=0), axis=1).sum()), 2),
        round(absolute_trajectory_error(stamps, online, stamps, truth), 4),
        round(absolute_trajectory_error(stamps, final, stamps, truth), 4),
        *tracked.online_error(-1),
        round(sum(state.by_images for state in states) / len(states), 4),
        round(states.count(Tracking.LOST) / len(states), 4),
        len(slam.keyframe_poses()),
        len(apart),
        sum(distance > _APART for distance in apart),
        round(nees, 2),
        measured_in,
        round(float(tracked.times_ms.mean()), 1),
        round(float(np.median(tracked.times_ms)), 1),
        round(float(np.percentile(tracked.times_ms, 95)), 1),
        *((None, None) if tracked.fault_end is None else tracked.online_error(tracked.fault_end)),
    )


def _consistency(
    estimates: Sequence[PoseEstimate], truth: NDArray[np.float64], taken_at: dict[int, SE3]
) -> tuple[float, int]:
    """Mean normalised squared error of frames in their keyframes, and number of keyframes."""
    measured = [
        (e.keyframe, e.T_keyframe_cam, e.covariance, invert(taken_at[e.keyframe]) @ T_world_cam)
        for e, T_world_cam in zip(estimates, truth, strict=True)
        if e.covariance is not None and not e.is_keyframe
    ]
    keyframes, Ts_keyframe_cam, covariances, truly = map(np.array, zip(*measured, strict=True))
    nees = normalised_errors(Ts_keyframe_cam, covariances, truly).mean()
    return float(nees), len(np.unique(keyframes))


def _job_line(job: _Job, results: _Results) -> str:
    laps, starts = results
    ends = ", ".join(f"{result.fault}: {result.end_error:.3f} m" for result in laps)
    right = f"; {sum(start.right for start in starts)} of {len(starts)} starts" if starts else ""
    return f"home {job.home}, off at the end {ends}{right}"
