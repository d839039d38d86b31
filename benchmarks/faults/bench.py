"""`vizbot bench faults`: drives and missions in which devices, program or surroundings fail."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

from benchmarks.episodes.homes import FIRST_HOME
from benchmarks.faults.hung_pairs import measure_hung_pairs
from benchmarks.faults.missions import (
    HOMES,
    FaultMission,
    FaultMissionResult,
    NearGoals,
    missions_in,
    near_goals,
    run_mission,
)
from benchmarks.faults.reflex_latency import measure_reflexes
from benchmarks.faults.scores import ENDS_BY_DEFAULT, FaultScore, FaultSeries, run_series
from benchmarks.faults.tables import NAME, fault_result
from benchmarks.faults.totals import DefaultResults, WallClockTiming
from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import commit, hardware, key_of_robot
from benchmarks.harness.store import Store
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
