"""`docs/results/faults.md`: the page of the faults, written from the kept drives and missions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vizbot.bench.faults.bench import (
    DRIVES,
    DRIVES_BY_DEFAULT,
    MISSIONS,
    MISSIONS_BY_DEFAULT,
    TIMINGS,
    series_by_default,
    series_of,
)
from vizbot.bench.faults.missions import FaultMissionResult
from vizbot.bench.faults.scores import FaultScore, FaultSeries
from vizbot.bench.faults.tables import fault_result
from vizbot.bench.faults.totals import DefaultResults, WallClockTiming
from vizbot.bench.harness.store import Store, StoredResult

_TITLE = "# What goes wrong in real houses, and what the robot makes of it"


def faults_page(folder: Path, page: Path) -> str:
    """The page of the kept results; empty without drives.

    Args:
        folder: The folder of the kept results.
        page: The file that the text is for.
    """
    drives = _drives(folder / DRIVES, series_of(quick=False))
    if not drives:
        return ""
    drives_by_default = _drives(folder / DRIVES_BY_DEFAULT, series_by_default(quick=False))
    missions = Store(folder / MISSIONS, FaultMissionResult).fullest()
    by_default = Store(folder / MISSIONS_BY_DEFAULT, FaultMissionResult).fullest()
    timings = Store(folder / TIMINGS, WallClockTiming).all()[-1:]
    lines: list[StoredResult[Any]] = [
        *drives, *drives_by_default, *missions, *by_default, *timings,
    ]  # fmt: skip
    made = dict.fromkeys(f"{line.commit} on {line.hardware}" for line in lines)
    result = fault_result(
        [line.result for line in drives],
        [line.result for line in missions],
        next((line.result for line in timings), None),
        by_default=DefaultResults(
            [line.result for line in drives_by_default], [line.result for line in by_default]
        ),
    )
    made_with = f"Simulated homes, devices and faults; run at {', '.join(sorted(made))}."
    return "\n\n".join([_TITLE, made_with, result.text, ""])


def _drives(path: Path, wanted: list[FaultSeries]) -> list[StoredResult[FaultScore]]:
    """The kept scores of these series, in their order."""
    order = {series: place for place, series in enumerate(wanted)}
    lines = Store(path, FaultScore).fullest(lambda score: score.series in order)
    return sorted(lines, key=lambda line: order[line.result.series])
