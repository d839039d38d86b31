"""`docs/results/faults.md`: the page of the faults, written from the kept drives and missions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.faults.bench import (
    DRIVES,
    DRIVES_BY_DEFAULT,
    MISSIONS,
    MISSIONS_BY_DEFAULT,
    TIMINGS,
    series_by_default,
    series_of,
)
from benchmarks.faults.missions import FaultMissionResult
from benchmarks.faults.scores import FaultScore, FaultSeries
from benchmarks.faults.tables import fault_result
from benchmarks.faults.totals import DefaultResults, WallClockTiming
from benchmarks.harness.store import Store, StoredResult

_TITLE = "# Faults"


def faults_page(folder: Path, page: Path) -> str:
    """The page of the kept results; empty without drives."""
    drives = _drives(folder / DRIVES, series_of(quick=False))
    if not drives:
        return ""
    drives_by_default = _drives(folder / DRIVES_BY_DEFAULT, series_by_default(quick=False))
    missions = missions_in(folder / MISSIONS)
    missions_by_default = missions_in(folder / MISSIONS_BY_DEFAULT)
    timings = Store(folder / TIMINGS, WallClockTiming).all()[-1:]
    result = fault_result(
        [line.result for line in drives],
        [line.result for line in missions],
        next((line.result for line in timings), None),
        by_default=DefaultResults(
            [line.result for line in drives_by_default],
            [line.result for line in missions_by_default],
        ),
    )
    parts: dict[str, Sequence[StoredResult[Any]]] = {
        "single faults": [line for line in drives if len(line.result.series.faults) == 1],
        "pairs": [line for line in drives if len(line.result.series.faults) > 1],
        "drives by the product's settings": drives_by_default,
        "missions": missions,
        "missions by the product's settings": missions_by_default,
        "times on the wall clock": timings,
    }
    made = [f"{name} at {_made(lines)}" for name, lines in parts.items() if lines]
    made_with = f"Homes, devices and faults are simulated. Run: {'; '.join(made)}."
    return "\n\n".join([_TITLE, result.text, made_with, ""])


def missions_in(path: Path) -> list[StoredResult[FaultMissionResult]]:
    """The newest result of each mission that is kept in a file."""
    return Store(path, FaultMissionResult).newest(lambda result: result.mission)


def drives_in(path: Path) -> list[StoredResult[FaultScore]]:
    """The newest score of each series that is kept in a file."""
    return Store(path, FaultScore).newest(lambda score: score.series)


def _drives(path: Path, wanted: list[FaultSeries]) -> list[StoredResult[FaultScore]]:
    """The newest kept scores of these series, in their order."""
    order = {series: place for place, series in enumerate(wanted)}
    lines = [line for line in drives_in(path) if line.result.series in order]
    return sorted(lines, key=lambda line: order[line.result.series])


def _made(lines: Sequence[StoredResult[Any]]) -> str:
    """Commits and machines of some lines, with their number where there are several."""
    counts = Counter(f"{line.commit} on {line.hardware}" for line in lines)
    return " and ".join(
        made if len(counts) == 1 else f"{made} ({count})" for made, count in counts.items()
    )
