"""What became of the laps of `vizbot bench slam`, and its table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from vizbot.bench.harness.board import BenchResult
from vizbot.bench.harness.tables import table
from vizbot.bench.slam.relocalisation import StartResult, starts_table

_IN_METRES = ("ate_rmse", "ate_rmse_final", "end_error", "end_error_worst")


@dataclass(frozen=True, slots=True)
class LapResult:
    """What the pose estimator made of one recording.

    Attributes:
        home: Seed.
        fault: What was wrong with it.
        frames: Of the recording.
        path_length: Truly driven [m].
        ate: RMSE of the camera's positions as known at the time, after alignment [m].
        ate_final: The same after the last frame [m].
        end_error: Of the last position, with the first pose given [m].
        end_turn: Of the last heading, likewise [degrees].
        tracked: Fraction of the frames posed from images.
        lost: Fraction of the frames whose pose it did not know.
        keyframes: In the end.
        closures: Loops that are closed in the end ...
        wrong_closures: ... and those of them that are wrong.
        nees: Mean squared error of frames measured in a keyframe, in units of their covariance; 6
            where that is true.
        measured_in: So many keyframes. The frames of one share its noise, so that no more than this
            many of the errors are independent.
        ms_mean: Time a frame [ms].
        ms_median: Likewise.
        ms_p95: Likewise.
    """

    home: int
    fault: str
    frames: int
    path_length: float
    ate: float
    ate_final: float
    end_error: float
    end_turn: float
    tracked: float
    lost: float
    keyframes: int
    closures: int
    wrong_closures: int
    nees: float
    measured_in: int
    ms_mean: float
    ms_median: float
    ms_p95: float


def consistent_nees(count: int) -> tuple[float, float]:
    """In which the mean of so many independent errors lies in 95 %, if covariances are true."""
    low, high = chi2.interval(0.95, 6 * count) / np.float64(count)
    return float(low), float(high)


def outcome(
    faults: Sequence[str],
    results: Sequence[LapResult],
    starts: Sequence[StartResult],
    quick: bool,
) -> BenchResult:
    """A row for each fault, in this order, and the random starts."""
    rows: list[dict[str, object]] = []
    for fault in faults:
        of_fault = [result for result in results if result.fault == fault]
        if not of_fault:
            continue
        low, high = consistent_nees(sum(r.measured_in for r in of_fault))
        rows.append(
            {
                "row": fault,
                "homes": len(of_fault),
                "ate_rmse": float(np.median([r.ate for r in of_fault])),
                "ate_rmse_final": float(np.median([r.ate_final for r in of_fault])),
                "end_error": float(np.median([r.end_error for r in of_fault])),
                "end_error_worst": max(r.end_error for r in of_fault),
                "end_degrees_worst": max(r.end_turn for r in of_fault),
                "tracked": float(np.mean([r.tracked for r in of_fault])),
                "lost": float(np.mean([r.lost for r in of_fault])),
                "closures": sum(r.closures for r in of_fault),
                "wrong_closures": sum(r.wrong_closures for r in of_fault),
                "nees": float(np.mean([r.nees for r in of_fault])),
                "nees_low": low,
                "nees_high": high,
                "ms_mean": float(np.median([r.ms_mean for r in of_fault])),
                "ms_median": float(np.median([r.ms_median for r in of_fault])),
                "ms_p95": float(np.median([r.ms_p95 for r in of_fault])),
            }
        )
    header = ("fault", "homes", "ATE online [m]", "final", "error at the end [m]", "worst",
              "worst [degrees]", "tracked", "lost", "closures", "wrong", "NEES",
              "ms a frame")  # fmt: skip
    shown = [
        [
            row["row"],
            row["homes"],
            *(f"{row[key]:.3f}" for key in _IN_METRES),
            f"{row['end_degrees_worst']:.2f}",
            f"{row['tracked']:.1%}",
            f"{row['lost']:.1%}",
            row["closures"],
            row["wrong_closures"],
            f"{row['nees']:.1f} ({row['nees_low']:.1f} to {row['nees_high']:.1f})",
            f"{row['ms_mean']:.0f}",
        ]
        for row in rows
    ]
    text = table(header, shown)
    notes = [
        "Medians over the homes, and the worst of them; all sensors have their noise.",
        "NEES is the mean squared error of frames in their keyframe, in units of its covariance; in"
        " brackets the bounds of 95 % in which it lies if the covariances are true.",
    ]
    if quick:
        notes.insert(0, "A smoke test, one lap of each home: no claim.")
    summary = {key: value for key, value in rows[0].items() if key != "row"}
    summary["against_orbslam3"] = None
    summary["starts"] = len(starts)
    summary["starts_right"] = sum(start.right for start in starts)
    return BenchResult("slam", rows, summary, "\n\n".join([text, starts_table(starts), *notes]))
