"""Results of the laps of `vizbot bench slam`, and their table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.tables import markdown_table
from benchmarks.slam.relocalisation import StartResult, starts_table

_ERRORS = ("ate_rmse", "ate_rmse_final", "fault_error", "fault_error_worst", "fault_degrees_worst",
           "end_error", "end_error_worst", "end_degrees_worst")  # fmt: skip


@dataclass(frozen=True, slots=True)
class LapResult:
    """The pose estimator's result on one recording.

    Attributes:
        home: Seed of the home.
        fault: The fault that was put into the recording.
        frames: Number of frames.
        path_length: True length of the path [m].
        ate: RMSE of the camera's online positions after alignment [m].
        ate_final: RMSE of its positions after the last frame [m].
        end_error: Error of the last position, with the first pose given [m].
        end_turn: Error of the last heading, with the first pose given [degrees].
        tracked: Fraction of the frames posed from images.
        lost: Fraction of the frames without a pose.
        keyframes: Number of keyframes at the end.
        closures: Number of loop closures at the end.
        wrong_closures: Number of wrong ones among them.
        nees: Mean squared error of frames measured in a keyframe, in units of their covariance; 6
            where the covariance is true.
        measured_in: Number of keyframes of those frames. The frames of a keyframe share its noise,
            so that no more than this many errors are independent.
        ms_mean: Mean processor time a frame [ms].
        ms_median: Median of it [ms].
        ms_p95: 95th percentile of it [ms].
        fault_error: Error of the position at the last frame of the fault, with the first pose given
            [m]; None without a fault, or where it was not measured.
        fault_turn: Likewise of the heading [degrees].
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
    fault_error: float | None = None
    fault_turn: float | None = None


def consistent_nees(count: int) -> tuple[float, float]:
    """The 95 % interval of the mean of `count` independent errors, if covariances are true."""
    low, high = chi2.interval(0.95, 6 * count) / np.float64(count)
    return float(low), float(high)


def closures_once(results: Sequence[LapResult]) -> tuple[int, int]:
    """Closures and wrong closures, those of each home's recording once.

    Replays of a recording with different faults find mostly the same closures, so that their sum
    says nothing. Each recording counts with its first result, its wrong closures with the result
    that has most of them.
    """
    closures: dict[int, int] = {}
    wrong: dict[int, int] = {}
    for result in results:
        closures.setdefault(result.home, result.closures)
        wrong[result.home] = max(wrong.get(result.home, 0), result.wrong_closures)
    return sum(closures.values()), sum(wrong.values())


def laps_result(
    faults: Sequence[str],
    results: Sequence[LapResult],
    starts: Sequence[StartResult],
    quick: bool,
) -> BenchResult:
    """A table with a row for each fault, in this order, and one of the random starts."""
    rows: list[dict[str, object]] = []
    by_fault = {fault: [r for r in results if r.fault == fault] for fault in faults}
    for fault, of_fault in by_fault.items():
        if not of_fault:
            continue
        low, high = consistent_nees(sum(r.measured_in for r in of_fault))
        fault_errors = [r.fault_error for r in of_fault if r.fault_error is not None]
        rows.append(
            {
                "row": fault,
                "homes": len(of_fault),
                "ate_rmse": float(np.median([r.ate for r in of_fault])),
                "ate_rmse_final": float(np.median([r.ate_final for r in of_fault])),
                "fault_error": float(np.median(fault_errors)) if fault_errors else None,
                "fault_error_worst": max(fault_errors, default=None),
                "fault_degrees_worst": max(
                    (r.fault_turn for r in of_fault if r.fault_turn is not None), default=None
                ),
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
    header = ("fault", "homes", "ATE online [m]", "final", "at the end of the fault [m]", "worst",
              "worst [degrees]", "at the end of the laps [m]", "worst", "worst [degrees]",
              "tracked", "lost", "closures", "wrong", "NEES", "ms a frame")  # fmt: skip
    shown = [
        [
            row["row"],
            row["homes"],
            *(_error_text(row[key], 2 if "degrees" in key else 3) for key in _ERRORS),
            f"{row['tracked']:.1%}",
            f"{row['lost']:.1%}",
            row["closures"],
            row["wrong_closures"],
            f"{row['nees']:.1f} ({row['nees_low']:.1f} to {row['nees_high']:.1f})",
            f"{row['ms_mean']:.0f}",
        ]
        for row in rows
    ]
    text = markdown_table(header, shown)
    notes = [
        "Medians over the homes, and the worst of them; all sensors have their noise. Times are of"
        " the processor.",
        "A fault ends with its last frame; being carried, with the first one thereafter. A dash"
        " stands where there is no fault, or nothing was measured.",
        "NEES is the mean squared error of frames in their keyframe, in units of its covariance; in"
        " brackets the bounds of 95 % in which it lies if the covariances are true.",
    ]
    in_order = [result for of_fault in by_fault.values() for result in of_fault]
    closures, wrong = closures_once(in_order)
    recordings = len({result.home for result in in_order})
    notes.append(
        f"Closures, those of each of {recordings} recordings once: {closures}; wrong: {wrong}. Rows"
        " replay the same recordings, so that their closures must not be added up."
    )
    if quick:
        notes.insert(0, "A smoke test, one lap of each home: no claim.")
    summary = {key: value for key, value in rows[0].items() if key != "row"}
    summary |= {"recordings": recordings, "closures": closures, "wrong_closures": wrong}
    summary["against_orbslam3"] = None
    summary["starts"] = len(starts)
    summary["starts_right"] = sum(start.right for start in starts)
    summary["starts_wrong"] = sum(start.recognised and not start.right for start in starts)
    tables = [text, starts_table(starts)] if starts else [text]
    return BenchResult("slam", rows, summary, "\n\n".join([*tables, *notes]))


def _error_text(error: object, digits: int) -> str:
    return "-" if error is None else f"{error:.{digits}f}"
