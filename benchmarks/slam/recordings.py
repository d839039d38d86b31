"""`vizbot bench slam SEQ`: our pose estimator and its peers on a recorded sequence."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import commit, hardware, reference_ms
from benchmarks.slam.drawing import Path2D, draw_paths
from benchmarks.slam.frame_to_frame import (
    MAX_DEPTH,
    feature_odometry,
    open3d_odometry,
    opencv_odometry,
)
from benchmarks.slam.peers import Estimator, OrbSlam3, VizbotEstimator
from benchmarks.slam.sequence_scores import (
    FEATURES,
    NAME,
    OPEN3D,
    OPENCV,
    ORB_SLAM3,
    OURS,
    Poses,
    Tracked,
    frame_rate,
    posed,
    sequence_result,
)
from drivers.tum_sequence import RecordedSequence
from mapping.slam.config import SlamConfig
from mapping.trajectory_error import MAX_GAP, associate
from mapping.tum import read_trajectory, write_trajectory
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole
from vizbot.core.types import Intrinsics, RGBDFrame
from vizbot.perception.first_frames import FirstFrames

__all__ = ["NAME", "RESULTS", "RUNS", "SlamBench", "run_slam", "track_sequence"]

RESULTS = "results.json"
"""File of the rows, beside the trajectories."""
RUNS = 5
"""Number of runs whose median time is reported; a quick benchmark makes one run."""


@dataclass(frozen=True, slots=True)
class SlamBench:
    """The sequence, the methods, and the folder of their trajectories.

    Attributes:
        sequence: Folder in TUM layout; errors are relative to the `groundtruth.txt` in it.
        recording: Intrinsics and depth scale, where the folder has no `camera.json`.
        stride: Step between the frames that are used.
        vocabulary: Vocabulary of ORB-SLAM3; None leaves it out.
        config: Settings of our estimator.
        out: Folder of the trajectories and the picture.
        runs: Number of runs of our estimator.
    """

    sequence: Path
    recording: tuple[Intrinsics, float] | None
    stride: int
    vocabulary: Path | None
    config: SlamConfig
    out: Path
    runs: int = RUNS

    def frames(self) -> Iterator[RGBDFrame]:
        """The used frames, in order."""
        with RecordedSequence(self.sequence, *(self.recording or (None, None))) as camera:
            frames = iter(camera.read, None)
            yield from itertools.islice(frames, 0, None, self.stride)


def run_slam(bench: SlamBench) -> BenchResult:
    """Run all methods, write their trajectories and the picture, and print the tables.

    Raises:
        ConfigError: the sequence, its ground truth or the vocabulary cannot be used.
    """
    truth = bench.sequence / "groundtruth.txt"
    reference = read_trajectory(truth) if truth.exists() else None
    first = next(bench.frames(), None)
    if first is None:
        raise ConfigError(f"sequence {bench.sequence} holds no frame")
    stamps, depth = _surveyed(bench.frames())
    if reference is not None:
        _require_common_stamps(truth, reference[0], stamps)
    bench.out.mkdir(parents=True, exist_ok=True)
    log, kernel = Console(stderr=True), reference_ms()
    results: dict[str, Tracked] = {}
    with ExitStack() as opened:
        peers: dict[str, Estimator] = {
            FEATURES: feature_odometry(first.intrinsics),
            OPENCV: opencv_odometry(first.intrinsics),
        }
        open3d = open3d_odometry(first.intrinsics)
        if open3d is not None:
            peers[OPEN3D] = open3d
        if bench.vocabulary is not None:
            orb = OrbSlam3(first.intrinsics, frame_rate(stamps), bench.vocabulary)
            peers[ORB_SLAM3] = opened.enter_context(orb)
        ours = []
        for number in range(bench.runs):
            ours.append(track_sequence(bench.frames(), VizbotEstimator(first, bench.config)))
            log.print(f"{OURS}, run {number + 1} of {bench.runs}: {_pace(ours[-1])}")
        results[OURS] = replace(ours[0], times_ms=np.concatenate([run.times_ms for run in ours]))
        for name, peer in peers.items():
            results[name] = track_sequence(bench.frames(), peer)
            log.print(f"{name}: {_pace(results[name])}")
    _write(bench, results, reference)
    name = f"{bench.sequence.resolve().name}, with stride {bench.stride}"
    result = sequence_result(name, results, reference, kernel, depth)
    kept = {
        "sequence": bench.sequence.resolve().name, "commit": commit(), "hardware": hardware(),
        "rows": result.rows, "summary": result.summary,
    }  # fmt: skip
    write_whole(bench.out / RESULTS, (json.dumps(kept, indent=1) + "\n").encode())
    return result


def track_sequence(frames: Iterator[RGBDFrame], estimator: Estimator) -> Tracked:
    """Track all frames with an estimator, one by one."""
    stamps, Ts_online, matched, times = [], [], [], []
    nowhere = np.full((4, 4), np.nan)
    for frame in frames:
        began = time.perf_counter()
        T_map_cam, by_images = estimator.track(frame)
        times.append(1000.0 * (time.perf_counter() - began))
        stamps.append(frame.stamp)
        Ts_online.append(nowhere if T_map_cam is None else T_map_cam)
        matched.append(by_images)
    return Tracked(
        np.array(stamps),
        np.array(Ts_online),
        estimator.finish(),
        np.array(matched),
        np.array([times]),
    )


def _surveyed(frames: Iterator[RGBDFrame]) -> tuple[NDArray[np.float64], float]:
    """Stamps (F,) of all frames [s], and the share of their pixels with depth that is of use.

    What no camera delivers is said, as when a map is built of them.
    """
    judge, seen = FirstFrames(None), []
    for frame in frames:
        judge.note(frame)
        seen.append((frame.stamp, np.mean((frame.depth > 0) & (frame.depth <= MAX_DEPTH))))
    judge.note(None)
    stamps, shares = np.array(seen).T
    return stamps, float(shares.mean())


def _require_common_stamps(
    truth: Path, true_stamps: NDArray[np.float64], stamps: NDArray[np.float64]
) -> None:
    common = len(associate(stamps, true_stamps)[0])
    if common >= 3:
        return
    spans = [
        f"{each[0]:.3f} to {each[-1]:.3f} s" if len(each) else "no time"
        for each in (true_stamps, stamps)
    ]
    raise ConfigError(
        f"{truth} tells of {common} of the {len(stamps)} frames, at least 3 are needed: its stamps"
        f" are of {spans[0]}, those of the frames of {spans[1]}, and must agree to {MAX_GAP} s;"
        " write both by one clock, or take the file away to do without errors"
    )


def _write(bench: SlamBench, results: dict[str, Tracked], reference: Poses | None) -> None:
    paths = [] if reference is None else [Path2D("ground truth", *reference)]
    for name, tracked in results.items():
        stem = name.lower().replace(" ", "-")
        for when, Ts_map_cam in (("online", tracked.Ts_online), ("final", tracked.Ts_final)):
            poses = posed(tracked.stamps, Ts_map_cam)
            write_trajectory(bench.out / f"{stem}-{when}.tum", *poses)
        paths.append(Path2D(name, *posed(tracked.stamps, tracked.Ts_online)))
    write_whole(bench.out / "trajectories.png", draw_paths(paths))
    Console(stderr=True).print(f"written: {bench.out}")


def _pace(tracked: Tracked) -> str:
    return f"{tracked.matched.mean():.1%} tracked, {tracked.times_ms.mean():.1f} ms a frame"
