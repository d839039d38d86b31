"""Scores of many drives with the same faults."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from benchmarks.faults.drives import FaultDrive, FaultDriveResult, run_drive
from benchmarks.faults.monitor import FARTHEST_ASTRAY

_STAYS = "has not helped: 0.[0-9] m in [0-9] s"
MAY_END = (
    "battery-low", "process-killed", "hangs-docking",
    "bumper-stays", "wall-stays", "overcurrent-stays", "dock-stays",
)  # fmt: skip
"""Faults after which the robot must give up and not drive on."""
_MAYBE_MOVED = "somebody may have moved the robot"
ENDS_BY_DEFAULT = {
    "stream-silent": _MAYBE_MOVED,
    "lifted-unheard": _MAYBE_MOVED,
    "base-asleep": _MAYBE_MOVED,
    "hangs-docking": "the program hangs",
    "cliff": "the base stopped at an edge",
    "wheel-drop": "a wheel hangs|does not obey since it was lifted",
    "kidnapped": "a wheel hangs|does not obey since it was lifted",
    "charger-plugged": "the base is in [A-Z]+ mode and does not drive",
    "mode-passive": "the base is in [A-Z]+ mode and does not drive",
    "bumper-stays": _STAYS,
    "wall-stays": _STAYS,
    "overcurrent-stays": _STAYS,
    "dock-stays": _STAYS,
}
"""Faults that may end a search by the product's settings, and the reason that it must then give."""
RESTS_BY_DEFAULT = ("lifted-unheard",)
"""Those of them after which the robot must not drive on unasked, wherever it would arrive."""


@dataclass(frozen=True, slots=True)
class FaultSeries:
    """Drives with the same faults."""

    faults: tuple[str, ...]
    seeds: tuple[int, ...]
    by_default: bool = False


@dataclass(frozen=True, slots=True)
class FaultScore:
    """The score of a series.

    Attributes:
        series: The series.
        happened: Drives in which all of its faults showed.
        in_time: Stops of turning wheels within their limit.
        stops: Stops of turning wheels that had a limit.
        limit: The limit of a single fault [s]; None without one.
        stopped_median: Median time from the first observable effect to the wheels at rest [s];
            None where nothing had to stop.
        stopped_max: Longest such time [s].
        run_on_max: Farthest that the robot rolled in that time [m].
        noticed_median: Median time from the first observable effect to the first line about the
            fault for the user [s]; None where there was none.
        noticed_max: Longest such time [s].
        noticed: Number of drives with such a line.
        line: The most frequent line.
        drove_on: Drives in which the faults happened and the robot then drove ahead again; where
            the fault ends the search, those in which it gave up, said so, and stayed.
        crashes: Errors that ended the program, one line each.
        maps_lost: Drives whose map could not be saved.
        astray_max: Farthest that a wheel turned in one go beyond its commands [m]; None in results
            from before this was measured.
        strayed: Drives in which that was too far.
        ended: Drives with the product's settings whose fault happened, and in which the robot gave
            up for the reason of `ENDS_BY_DEFAULT` and stayed.
    """

    series: FaultSeries
    happened: int
    in_time: int
    stops: int
    limit: float | None
    stopped_median: float | None
    stopped_max: float | None
    run_on_max: float
    noticed_median: float | None
    noticed_max: float | None
    noticed: int
    line: str
    drove_on: int
    crashes: tuple[str, ...]
    maps_lost: int
    astray_max: float | None = None
    strayed: int = 0
    ended: int = 0


def run_series(series: FaultSeries) -> FaultScore:
    """Run the drives of a series one after another."""
    return score_series(
        series,
        [run_drive(FaultDrive(series.faults, seed, series.by_default)) for seed in series.seeds],
    )


def score_series(series: FaultSeries, results: Sequence[FaultDriveResult]) -> FaultScore:
    """Score the results of a series."""
    stops = [stop for r in results for stop in r.stops if stop.rolling]
    after = [stop.after for stop in stops if stop.after is not None]
    noticed = [r.noticed_after for r in results if r.noticed_after is not None]
    lines = Counter(_without_port(r.noticed) for r in results if r.noticed)
    return FaultScore(
        series,
        sum(r.happened for r in results),
        sum(stop.in_time for stop in stops),
        len(stops),
        stops[0].within if stops and len(series.faults) == 1 else None,
        round(median(after), 3) if after else None,
        max(after, default=None),
        max((stop.run_on for stop in stops), default=0.0),
        round(median(noticed), 3) if noticed else None,
        max(noticed, default=None),
        len(noticed),
        lines.most_common(1)[0][0] if lines else "",
        sum(r.happened and _goes_on(r) for r in results),
        tuple(f"{r.drive}: {r.crash}" for r in results if r.crash),
        sum(r.map_kept is False for r in results),
        max((r.astray for r in results), default=None),
        sum(r.astray > FARTHEST_ASTRAY for r in results),
        sum(
            r.happened and not r.drove_on and ended_by_default(series.faults, r.reported)
            for r in results
            if series.by_default
        ),
    )


def ended_by_default(faults: Sequence[str], reason: str) -> bool:
    """Whether a search ended for a reason that the product's settings give for one of `faults`."""
    return any(
        re.search(ENDS_BY_DEFAULT[name], reason) for name in faults if name in ENDS_BY_DEFAULT
    )


def _goes_on(result: FaultDriveResult) -> bool:
    if any(name in MAY_END for name in result.drive.faults):
        return bool(result.reported) and not result.drove_on
    return result.drove_on


def _without_port(line: str) -> str:
    """A line without the name of the serial port, which differs from drive to drive."""
    name, colon, rest = line.partition(": ")
    return rest if colon and name.startswith("/dev/") else line
