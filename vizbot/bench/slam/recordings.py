"""`vizbot bench slam SEQ`: our pose estimator and its peers on a recorded sequence."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from drivers.tum_sequence import RecordedSequence
from mapping.slam.config import SlamConfig
from mapping.trajectory_error import (
    MAX_GAP,
    absolute_trajectory_error,
    associate,
    relative_error,
)
from mapping.tum import read_trajectory, write_trajectory
from vizbot.bench.harness.bench_plan import BenchResult
from vizbot.bench.harness.reference_kernel import DESCRIPTION, reference_ms
from vizbot.bench.harness.tables import markdown_table
from vizbot.bench.slam.drawing import Path2D, draw_paths
from vizbot.bench.slam.peers import (
    MAX_DEPTH,
    Estimator,
    OrbSlam3,
    VizbotEstimator,
    open3d_odometry,
    opencv_odometry,
)
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole
from vizbot.core.types import Intrinsics, RGBDFrame

NAME = "slam"
OURS, OPENCV, OPEN3D, ORB_SLAM3 = "vizbot", "OpenCV RGB-D", "Open3D hybrid", "ORB-SLAM3 RGB-D"
RUNS = 5
"""Number of runs whose median time is reported; a quick benchmark makes one run."""
_LEAST_DEPTH = 0.01
"""Least share of pixels with depth in an RGB-D recording."""


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


@dataclass(frozen=True, slots=True, eq=False)
class Tracked:
    """Poses of one method on a sequence.

    Attributes:
        stamps: Stamps of the frames (F,) [s].
        Ts_online: Online poses (F, 4, 4) of the camera; NaN without one.
        Ts_final: Poses (F, 4, 4) after the last frame; NaN without one.
        matched: Whether the pose comes from matched images (F,), not from prediction.
        times_ms: Times of tracking in each run (R, F), without reading the images [ms].
    """

    stamps: NDArray[np.float64]
    Ts_online: NDArray[np.float64]
    Ts_final: NDArray[np.float64]
    matched: NDArray[np.bool_]
    times_ms: NDArray[np.float64]


Poses = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Stamps (N,) [s] and poses (N, 4, 4)."""


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
        peers: dict[str, Estimator] = {OPENCV: opencv_odometry(first.intrinsics)}
        open3d = open3d_odometry(first.intrinsics)
        if open3d is not None:
            peers[OPEN3D] = open3d
        if bench.vocabulary is not None:
            orb = OrbSlam3(first.intrinsics, bench.vocabulary)
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
    return _sequence_result(bench, results, reference, kernel, depth)


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
    """Stamps (F,) of all frames [s], and the share of their pixels with depth that is of use."""
    seen = [(f.stamp, np.mean((f.depth > 0) & (f.depth <= MAX_DEPTH))) for f in frames]
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


def _posed(stamps: NDArray[np.float64], Ts_map_cam: NDArray[np.float64]) -> Poses:
    """Stamps and poses of the frames that have a pose."""
    known = np.isfinite(Ts_map_cam).all(axis=(1, 2))
    return stamps[known], Ts_map_cam[known]


def _error(poses: Poses, reference: Poses | None) -> float | None:
    """Absolute trajectory error [m]; None where there is too little to compare."""
    if reference is None or len(associate(poses[0], reference[0])[0]) < 3:
        return None
    return absolute_trajectory_error(*poses, *reference)


def _row(name: str, tracked: Tracked, reference: Poses | None) -> dict[str, object]:
    online = _posed(tracked.stamps, tracked.Ts_online)
    final = _posed(tracked.stamps, tracked.Ts_final)
    drift = None if reference is None else relative_error(*online, *reference)
    return {
        "row": name,
        "ate_rmse": _error(online, reference),
        "ate_rmse_final": _error(final, reference),
        "rpe_m_per_m": None if drift is None else drift[0],
        "rpe_degrees_per_m": None if drift is None else float(np.degrees(drift[1])),
        "tracked": float(tracked.matched.mean()),
        "scored": None if reference is None else len(associate(online[0], reference[0])[0]),
        "ms_mean": float(np.median(tracked.times_ms.mean(axis=1))),
        "ms_median": float(np.median(np.median(tracked.times_ms, axis=1))),
        "ms_p95": float(np.median(np.percentile(tracked.times_ms, 95, axis=1))),
    }


def _sequence_result(
    bench: SlamBench,
    results: dict[str, Tracked],
    reference: Poses | None,
    kernel_ms: float,
    depth: float,
) -> BenchResult:
    rows = [_row(name, tracked, reference) for name, tracked in results.items()]
    summary = {key: value for key, value in rows[0].items() if key != "row"}
    ours, orb = results[OURS], results.get(ORB_SLAM3)
    summary |= {
        "against_orbslam3": None if orb is None else _error(
            _posed(ours.stamps, ours.Ts_final), _posed(orb.stamps, orb.Ts_final)
        ),
        "frames": len(ours.stamps),
        "runs": bench.runs,
        "reference_kernel_ms": kernel_ms,
    }  # fmt: skip
    header = ("method", "ATE online [m]", "final", "RPE [m/m]", "[degrees/m]", "tracked",
              "scored", "ms mean", "median", "95th percentile")  # fmt: skip
    text = markdown_table(
        header, [[_shown(key, value) for key, value in row.items()] for row in rows]
    )
    means = ours.times_ms.mean(axis=1)
    notes = [
        f"{bench.sequence.name}: {len(ours.stamps)} frames, with stride {bench.stride}.",
        "Errors are RMSE after rigid alignment without scale, over the frames that have a pose and"
        " ground truth, which are the scored ones; tracked are those posed from image matches.",
        f"Times of vizbot are the medians of {bench.runs} runs (means {means.min():.1f} to"
        f" {means.max():.1f} ms), those of the others are of one; beside them the {DESCRIPTION}"
        f" took {kernel_ms:.1f} ms.",
    ]
    if depth < _LEAST_DEPTH:
        notes.insert(
            0,
            f"Only {depth:.1%} of the pixels have depth up to {MAX_DEPTH:g} m, without which little"
            " can be tracked: check the depth images, and the depth scale in camera.json or"
            " --intrinsics.",
        )
    if reference is None:
        notes.append("There is no groundtruth.txt, so no errors are given.")
    if orb is not None:
        apart = _shown("against_orbslam3", summary["against_orbslam3"])
        notes.append(f"vizbot and ORB-SLAM3 are {apart} m apart (RMSE of the final trajectories).")
    return BenchResult(NAME, rows, summary, "\n\n".join([text, *notes]))


def _write(bench: SlamBench, results: dict[str, Tracked], reference: Poses | None) -> None:
    paths = [] if reference is None else [Path2D("ground truth", *reference)]
    for name, tracked in results.items():
        stem = name.lower().replace(" ", "-")
        for when, Ts_map_cam in (("online", tracked.Ts_online), ("final", tracked.Ts_final)):
            poses = _posed(tracked.stamps, Ts_map_cam)
            write_trajectory(bench.out / f"{stem}-{when}.tum", *poses)
        paths.append(Path2D(name, *_posed(tracked.stamps, tracked.Ts_online)))
    write_whole(bench.out / "trajectories.png", draw_paths(paths))
    Console(stderr=True).print(f"written: {bench.out}")


def _pace(tracked: Tracked) -> str:
    return f"{tracked.matched.mean():.1%} tracked, {tracked.times_ms.mean():.1f} ms a frame"


def _shown(key: str, value: object) -> object:
    if not isinstance(value, float):
        return value
    if key == "tracked":
        return f"{value:.1%}"
    return f"{value:.1f}" if key.startswith("ms") else f"{value:.3f}"
