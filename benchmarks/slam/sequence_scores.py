"""Errors and times of pose estimators on a recorded sequence, and their table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import REFERENCE_KERNEL
from benchmarks.harness.tables import markdown_table
from benchmarks.slam.frame_to_frame import MAX_DEPTH
from mapping.trajectory_error import absolute_trajectory_error, associate, relative_error

NAME = "slam"
OURS, FEATURES, ORB_SLAM3 = "vizbot", "ORB features and PnP", "ORB-SLAM3 RGB-D"
OPENCV, OPEN3D = "OpenCV RGB-D", "Open3D hybrid"
_LEAST_DEPTH = 0.01
"""Least share of pixels with depth in an RGB-D recording."""


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


def frame_rate(stamps: NDArray[np.float64]) -> float:
    """Frames a second, by the median of their intervals; 30 of a single frame."""
    return 1.0 / float(np.median(np.diff(stamps))) if len(stamps) > 1 else 30.0


def posed(stamps: NDArray[np.float64], Ts_map_cam: NDArray[np.float64]) -> Poses:
    """Stamps and poses of the frames that have a pose."""
    known = np.isfinite(Ts_map_cam).all(axis=(1, 2))
    return stamps[known], Ts_map_cam[known]


def _error(poses: Poses, reference: Poses | None) -> float | None:
    """Absolute trajectory error [m]; None where there is too little to compare."""
    if reference is None or len(associate(poses[0], reference[0])[0]) < 3:
        return None
    return absolute_trajectory_error(*poses, *reference)


def _row(name: str, tracked: Tracked, reference: Poses | None) -> dict[str, object]:
    online = posed(tracked.stamps, tracked.Ts_online)
    final = posed(tracked.stamps, tracked.Ts_final)
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


def sequence_result(
    recording: str,
    results: dict[str, Tracked],
    reference: Poses | None,
    kernel_ms: float,
    depth: float,
) -> BenchResult:
    """Rows, summary and tables of these methods.

    Args:
        recording: The recording in a few words, for the first note.
        results: Poses of each method by its name, ours first.
        reference: The true trajectory; None without one.
        kernel_ms: Time of the reference kernel beside them [ms].
        depth: Share of the pixels with depth that is of use.
    """
    rows = [_row(name, tracked, reference) for name, tracked in results.items()]
    summary = {key: value for key, value in rows[0].items() if key != "row"}
    ours, orb = results[OURS], results.get(ORB_SLAM3)
    summary |= {
        "against_orbslam3": None if orb is None else _error(
            posed(ours.stamps, ours.Ts_final), posed(orb.stamps, orb.Ts_final)
        ),
        "frames": len(ours.stamps),
        "runs": len(ours.times_ms),
        "reference_kernel_ms": kernel_ms,
        "rate": frame_rate(ours.stamps),
        "path_length": None if reference is None else float(
            np.linalg.norm(np.diff(reference[1][:, :3, 3], axis=0), axis=1).sum()
        ),
        "ms_mean_least": float(ours.times_ms.mean(axis=1).min()),
        "ms_mean_most": float(ours.times_ms.mean(axis=1).max()),
    }  # fmt: skip
    notes = [f"{recording}: {len(ours.stamps)} frames."]
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
    text = sequence_table(rows, summary)
    return BenchResult(NAME, rows, summary, "\n\n".join([text, *notes]))


def sequence_table(rows: Sequence[Mapping[str, object]], summary: Mapping[str, Any]) -> str:
    """The table of these rows, and what its columns mean."""
    header = ("method", "ATE online [m]", "final", "RPE [m/m]", "[degrees/m]", "tracked",
              "scored", "ms mean", "median", "95th percentile")  # fmt: skip
    text = markdown_table(
        header, [[_shown(key, value) for key, value in row.items()] for row in rows]
    )
    length = summary["path_length"]
    way = "" if length is None else f" of {length:.0f} m,"
    notes = [
        f"{summary['frames']} frames{way} {summary['rate']:.3g} a second in the recording.",
        "Errors are RMSE after rigid alignment without scale, over the frames that have a pose and"
        " ground truth, which are the scored ones; tracked are those posed from image matches.",
        f"Times of vizbot are the medians of {summary['runs']} runs (means"
        f" {summary['ms_mean_least']:.1f} to {summary['ms_mean_most']:.1f} ms), those of the others"
        f" are of one; beside them the {REFERENCE_KERNEL} took"
        f" {summary['reference_kernel_ms']:.1f} ms.",
    ]
    return "\n\n".join([text, *notes])


def _shown(key: str, value: object) -> object:
    if not isinstance(value, float):
        return value
    if key == "tracked":
        return f"{value:.1%}"
    return f"{value:.1f}" if key.startswith("ms") else f"{value:.3f}"
