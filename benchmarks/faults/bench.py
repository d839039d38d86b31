"""`vizbot bench faults`: drives and missions in which devices, program or surroundings fail."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any

from benchmarks.episodes.homes import FIRST_HOME
from benchmarks.faults.missions import (
    HOMES,
    FaultMission,
    FaultMissionResult,
    NearGoals,
    missions_in,
    near_goals,
    run_mission,
)
from benchmarks.faults.scores import ENDS_BY_DEFAULT, FaultScore, FaultSeries, run_series
from benchmarks.faults.tables import NAME, fault_result
from benchmarks.faults.totals import DefaultResults, WallClockTiming
from benchmarks.faults.wall_clock import measure_hung_pairs, measure_reflexes
from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import commit, hardware, key_of_robot
from benchmarks.harness.store import Store, StoredResult
from benchmarks.harness.workers import in_parallel
from sim_stubs.faults.catalogue import CATALOGUE
from vizbot.core.errors import ConfigError

__all__ = ["HOMES", "NAME", "FaultBench", "require_homes", "run_faults"]

DRIVES, MISSIONS = "drives.jsonl", "missions.jsonl"
DRIVES_BY_DEFAULT, MISSIONS_BY_DEFAULT = "drives-by-default.jsonl", "missions-by-default.jsonl"
TIMINGS = "timings.jsonl"
"""Files of the results."""
SEEDS, PAIR_SEEDS = 100, 3
"""Numbers of drives with one fault, and with two."""
_QUICK_SEEDS, _QUICK_PAIRS = 4, 40


@dataclass(frozen=True, slots=True)
class FaultBench:
    """Which drives and missions are wanted, and where their results are kept."""

    homes: tuple[int, ...]
    quick: bool
    folder: Path


def run_faults(bench: FaultBench) -> BenchResult:
    """Run the drives, without rendering, and the missions that have no results yet.

    Reflexes are timed on the wall clock.

    Raises:
        VizbotError: a world cannot be built.
    """
    timing = WallClockTiming(measure_reflexes(), measure_hung_pairs())
    if not bench.quick:
        timings = Store(bench.folder / TIMINGS, WallClockTiming)
        timings.add(_key(), commit(), hardware(), timing)
    scores = _drives(bench, series_of(bench.quick), DRIVES)
    missions = _missions(bench, by_default=False)
    by_default = DefaultResults(
        _drives(bench, series_by_default(bench.quick), DRIVES_BY_DEFAULT),
        _missions(bench, by_default=True),
    )
    return fault_result(scores, missions, timing, bench.quick, by_default)


def series_of(quick: bool) -> list[FaultSeries]:
    """The series of every fault alone, then of every pair."""
    singles = tuple(range(_QUICK_SEEDS if quick else SEEDS))
    pairs = list(combinations(CATALOGUE, 2))
    if quick:
        pairs = pairs[:: len(pairs) // _QUICK_PAIRS]
    seeds = tuple(range(1 if quick else PAIR_SEEDS))
    return [
        *(FaultSeries((name,), singles) for name in CATALOGUE),
        *(FaultSeries(pair, seeds) for pair in pairs),
    ]


def series_by_default(quick: bool) -> list[FaultSeries]:
    """The series with the product's settings, of every fault that may end a search by them."""
    seeds = tuple(range(_QUICK_SEEDS if quick else SEEDS))
    return [FaultSeries((name,), seeds, by_default=True) for name in ENDS_BY_DEFAULT]


def _key() -> str:
    return key_of_robot("benchmarks/episodes", "benchmarks/faults")


def _drives(bench: FaultBench, wanted: list[FaultSeries], file: str) -> list[FaultScore]:
    key = _key()
    store = Store(bench.folder / file, FaultScore)
    done = {score.series: score for score in store.results_with_key(key)}
    missing = [series for series in wanted if series not in done]
    for series, score in in_parallel(run_series, missing, "fault drives", _series_line):
        store.add(key, commit(), hardware(), score)
        done[series] = score
    return [done[series] for series in wanted]


def _missions(bench: FaultBench, by_default: bool) -> list[FaultMissionResult]:
    key = _key()
    file = MISSIONS_BY_DEFAULT if by_default else MISSIONS
    store = Store(bench.folder / file, FaultMissionResult)
    homes = Store(bench.folder / "goals.jsonl", NearGoals)
    known = {near.home: near for near in homes.results_with_key(key)}
    unknown = [home for home in bench.homes if home not in known]
    for home, near in in_parallel(near_goals, unknown, "homes", _near_goals_line):
        homes.add(key, commit(), hardware(), near)
        known[home] = near
    wanted = [
        replace(mission, by_default=by_default)
        for mission in missions_in([known[home] for home in bench.homes], bench.quick)
    ]
    done: dict[FaultMission, FaultMissionResult] = {
        r.mission: r for r in store.results_with_key(key)
    }
    missing = [mission for mission in wanted if mission not in done]
    for mission, result in in_parallel(run_mission, missing, "fault missions", _mission_line):
        store.add(key, commit(), hardware(), result)
        done[mission] = result
    return [done[mission] for mission in wanted]


def _series_line(series: FaultSeries, score: FaultScore) -> str:
    stopped = "" if score.stopped_max is None else f", stopped after {score.stopped_max:.2f} s"
    return f"{' + '.join(series.faults)}: {len(series.seeds)} drives{stopped}"


def _near_goals_line(home: int, near: NearGoals) -> str:
    return f"home {home}: {len(near.goals)} goals at most 10 m away"


def _mission_line(mission: FaultMission, result: FaultMissionResult) -> str:
    faults = " + ".join(mission.faults) or "nothing wrong"
    answer = "reached" if result.reached else result.answer
    return f"{faults}, home {mission.home}, {mission.goal}: {answer} in {result.steps} steps"


def require_homes(homes: Sequence[int]) -> None:
    """Reject training homes.

    Raises:
        ConfigError: there is one.
    """
    if min(homes) < FIRST_HOME:
        raise ConfigError(
            f"home {min(homes)} of --seeds is a training home; benchmark homes begin at"
            f" {FIRST_HOME}"
        )


def faults_page(folder: Path, page: Path) -> str:
    """The page of the kept results; empty without drives."""
    drives = _kept_drives(folder / DRIVES, series_of(quick=False))
    if not drives:
        return ""
    drives_by_default = _kept_drives(folder / DRIVES_BY_DEFAULT, series_by_default(quick=False))
    missions = _kept_missions(folder / MISSIONS)
    missions_by_default = _kept_missions(folder / MISSIONS_BY_DEFAULT)
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
    return "\n\n".join(["# Faults", result.text, made_with, ""])


def _kept_missions(path: Path) -> list[StoredResult[FaultMissionResult]]:
    """The newest result of each mission that is kept in a file."""
    return Store(path, FaultMissionResult).newest(lambda result: result.mission)


def _kept_drives(path: Path, wanted: list[FaultSeries]) -> list[StoredResult[FaultScore]]:
    """The newest kept scores of these series, in their order."""
    order = {series: place for place, series in enumerate(wanted)}
    kept = Store(path, FaultScore).newest(lambda score: score.series)
    lines = [line for line in kept if line.result.series in order]
    return sorted(lines, key=lambda line: order[line.result.series])


def _made(lines: Sequence[StoredResult[Any]]) -> str:
    """Commits and machines of some lines, with their number where there are several."""
    counts = Counter(f"{line.commit} on {line.hardware}" for line in lines)
    return " and ".join(
        made if len(counts) == 1 else f"{made} ({count})" for made, count in counts.items()
    )
