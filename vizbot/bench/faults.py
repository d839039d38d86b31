"""`vizbot bench faults`: what goes wrong in real houses, and what the robot makes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

from sim_stubs.faults import CATALOGUE
from vizbot.bench.board import Outcome
from vizbot.bench.fault_missions import (
    HOMES,
    FaultMission,
    FaultMissionResult,
    NearGoals,
    missions_in,
    near_goals,
    run_mission,
)
from vizbot.bench.fault_scores import FaultScore, FaultSeries, run_series
from vizbot.bench.fingerprint import commit, hardware, key_of_sources
from vizbot.bench.scores import Rate
from vizbot.bench.store import Store
from vizbot.bench.tables import counted, interval, table
from vizbot.bench.wall_clock_reflexes import ReflexLatency, measure_reflexes
from vizbot.bench.workers import in_parallel
from vizbot.core.errors import ConfigError

__all__ = ["HOMES", "NAME", "FaultBench", "require_homes", "run"]

NAME = "faults"
SEEDS, PAIR_SEEDS = 100, 3
"""Of the drives with one fault, and with two."""
_QUICK_SEEDS, _QUICK_PAIRS = 4, 40
_DRIVE_SOURCES = (
    "drivers", "mapping", "nav", "vizbot/core", "sim_stubs/faults.py", "sim_stubs/faulty_base.py",
    "sim_stubs/faulty_body.py", "sim_stubs/faulty_camera.py", "sim_stubs/roomba.py",
    "sim_stubs/roomba_line.py", "sim_stubs/roomba_wheels.py", "sim_stubs/clock.py",
    "sim_stubs/box_room.py", "vizbot/pipeline.py", "vizbot/senses.py", "vizbot/reactions.py",
    "vizbot/patience.py", "vizbot/perception.py", "vizbot/search.py", "vizbot/stride.py",
    "vizbot/config.py", "vizbot/bench/fault_drives.py", "vizbot/bench/fault_watch.py",
    "vizbot/bench/bare_robot.py",
)  # fmt: skip
"""All that can change a drive without rendering."""
_LEGEND = (
    "Times are on the simulated clock, from the first observable effect of the fault: the sensor "
    "frame that tells of it, the first frame that is missing or black, the last command. Stopped: "
    "the wheels are told to rest, or for what is ahead not to go ahead, to the end of that period "
    "of 15 ms. Noticed: the first line for the user. Where nothing can reach the wheels, the robot "
    "rolls on as far as it says, and stopping is the first thing once the cable is back."
)


@dataclass(frozen=True, slots=True)
class FaultBench:
    """What a person asked for.

    Attributes:
        homes: In which goals are sought while something goes wrong.
        quick: A small part, as a smoke test.
        folder: Where finished results are kept.
    """

    homes: tuple[int, ...]
    quick: bool
    folder: Path


def run(asked: FaultBench) -> Outcome:
    """Run what is missing: drives without rendering, missions in homes, reflexes on the wall clock.

    Raises:
        VizbotError: a world cannot be built.
    """
    latency = measure_reflexes()
    scores = _drives(asked)
    missions = _missions(asked)
    return outcome(scores, missions, latency, smoke_test=asked.quick)


def series_of(quick: bool) -> list[FaultSeries]:
    """Every fault alone, then every pair."""
    singles = tuple(range(_QUICK_SEEDS if quick else SEEDS))
    pairs = list(combinations(CATALOGUE, 2))
    if quick:
        pairs = pairs[:: len(pairs) // _QUICK_PAIRS]
    seeds = tuple(range(1 if quick else PAIR_SEEDS))
    return [
        *(FaultSeries((name,), singles) for name in CATALOGUE),
        *(FaultSeries(pair, seeds) for pair in pairs),
    ]


def outcome(
    scores: Sequence[FaultScore],
    missions: Sequence[FaultMissionResult],
    latency: ReflexLatency,
    smoke_test: bool = False,
) -> Outcome:
    """Everything that is printed about these results."""
    singles = [score for score in scores if len(score.series.faults) == 1]
    pairs = [score for score in scores if len(score.series.faults) == 2]
    stopped = Rate(sum(score.in_time for score in scores), sum(score.limits for score in scores))
    allowed = [m for m in missions if m.should_arrive and m.mission.faults]
    reached = Rate.over(m.reached for m in allowed)
    runs = sum(len(score.series.seeds) for score in scores)
    crashes = [line for score in scores for line in score.crashes]
    crashes += [m.crash for m in missions if m.crash]
    lost = sum(score.maps_lost for score in scores) + sum(not m.map_kept for m in missions)
    low, high = reached.interval()
    summary: dict[str, object] = {
        "runs": runs + len(missions),
        "stopped_in_time": stopped.value,
        "goal_reached": reached.value,
        "goal_low": low,
        "goal_high": high,
        "crashes": len(crashes),
        "maps_lost": lost,
        "reflex_ms_median": latency.median_ms,
        "reflex_ms_p99": latency.p99_ms,
        "reflex_ms_max": latency.max_ms,
    }
    parts = [
        _LEGEND,
        _drive_table(singles, missions),
        _pairs_line(pairs),
        _missions_table(missions),
        f"Of {runs} drives and {len(missions)} missions {len(crashes)} crashed or hung, {lost} lost"
        f" the map. The wheels stopped in time in {counted(stopped)} drives that have a limit"
        f" ({interval(stopped)} %), the goal was reached in {counted(reached)} missions whose fault"
        f" allows it ({interval(reached)} %).",
        *(f"- {line}" for line in crashes),
        latency.told(),
    ]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the drives: no claim.")
    rows = [_row(score) for score in singles]
    return Outcome(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def _drives(asked: FaultBench) -> list[FaultScore]:
    key = key_of_sources(*_DRIVE_SOURCES)
    store = Store(asked.folder / "drives.jsonl", FaultScore)
    wanted = series_of(asked.quick)
    done = {score.series: score for score in store.of(key)}
    missing = [series for series in wanted if series not in done]
    for series, score in in_parallel(run_series, missing, "fault drives", _described):
        store.add(key, commit(), hardware(), score)
        done[series] = score
    return [done[series] for series in wanted]


def _missions(asked: FaultBench) -> list[FaultMissionResult]:
    key = key_of_sources("drivers", "mapping", "nav", "sim_stubs", "vizbot")
    store = Store(asked.folder / "missions.jsonl", FaultMissionResult)
    homes = Store(asked.folder / "goals.jsonl", NearGoals)
    known = {near.home: near for near in homes.of(key)}
    unknown = [home for home in asked.homes if home not in known]
    for home, near in in_parallel(near_goals, unknown, "homes", _near):
        homes.add(key, commit(), hardware(), near)
        known[home] = near
    wanted = missions_in([known[home] for home in asked.homes], asked.quick)
    done: dict[FaultMission, FaultMissionResult] = {r.mission: r for r in store.of(key)}
    missing = [mission for mission in wanted if mission not in done]
    for mission, result in in_parallel(run_mission, missing, "fault missions", _told):
        store.add(key, commit(), hardware(), result)
        done[mission] = result
    return [done[mission] for mission in wanted]


def _drive_table(singles: Sequence[FaultScore], missions: Sequence[FaultMissionResult]) -> str:
    rows = []
    for score in singles:
        [name] = score.series.faults
        fault = CATALOGUE[name]
        arrived = Rate.over(m.reached for m in missions if m.mission.faults == (name,))
        limit: object = None if fault.stops_within is None else f"{fault.stops_within:g}"
        if not fault.reaches_wheels:
            limit = f"cannot stop: {score.run_on_max:.2f} m"
        rows.append(
            [name, len(score.series.seeds), _range(score.noticed_median, score.noticed_max),
             _range(score.stopped_median, score.stopped_max), limit,
             counted(Rate(score.in_time, score.limits)) if score.limits else "-", score.drove_on,
             (counted(arrived) if fault.goal else "need not") if arrived.of else "-",
             score.line or "-"]
        )  # fmt: skip
    header = ("fault", "drives", "noticed after, median (most) [s]", "stopped after", "limit",
              "in time", "drove on", "goal reached", "what the user reads first")  # fmt: skip
    return table(header, rows)


def _pairs_line(pairs: Sequence[FaultScore]) -> str:
    if not pairs:
        return ""
    drives = Rate(sum(p.in_time for p in pairs), sum(p.limits for p in pairs))
    runs = sum(len(p.series.seeds) for p in pairs)
    on = sum(p.drove_on for p in pairs)
    late = [" + ".join(p.series.faults) for p in pairs if p.in_time < p.limits]
    text = (
        f"Two at a time: {len(pairs)} pairs, {runs} drives; stopped in time in {counted(drives)}"
        f" that have a limit ({interval(drives)} %), drove on in {on}."
    )
    return f"{text} Late: {', '.join(late)}." if late else text


def _missions_table(missions: Sequence[FaultMissionResult]) -> str:
    if not missions:
        return ""
    plain = Rate.over(m.reached for m in missions if not m.mission.faults)
    pairs = [m for m in missions if len(m.mission.faults) == 2]
    rows = [
        [" + ".join(m.mission.faults), m.mission.home, m.mission.goal,
         "reached" if m.reached else m.answer, m.steps]
        for m in missions
        if m.mission.faults and (len(m.mission.faults) == 2 or not m.reached)
    ]  # fmt: skip
    text = (
        f"Through the whole loop, to goals at most 10 m away: the same goals without a fault"
        f" {counted(plain)} ({interval(plain)} %), two faults at a time"
        f" {counted(Rate.over(m.reached for m in pairs))}. Pairs, and single faults that did not"
        " reach it:"
    )
    return f"{text}\n\n{table(('faults', 'home', 'goal', 'what became of it', 'steps'), rows)}"


def _row(score: FaultScore) -> dict[str, object]:
    return {
        "row": " + ".join(score.series.faults),
        "runs": len(score.series.seeds),
        "limit": score.limit,
        "stopped_median": score.stopped_median,
        "stopped_max": score.stopped_max,
        "in_time": score.in_time,
        "noticed_median": score.noticed_median,
        "run_on_max": score.run_on_max,
        "drove_on": score.drove_on,
    }


def _range(middle: float | None, most: float | None) -> str:
    return "-" if middle is None or most is None else f"{middle:.2f} ({most:.2f})"


def _described(series: FaultSeries, score: FaultScore) -> str:
    stopped = "" if score.stopped_max is None else f", stopped after {score.stopped_max:.2f} s"
    return f"{' + '.join(series.faults)}: {len(series.seeds)} drives{stopped}"


def _near(home: int, near: NearGoals) -> str:
    return f"home {home}: {len(near.goals)} goals at most 10 m away"


def _told(mission: FaultMission, result: FaultMissionResult) -> str:
    faults = " + ".join(mission.faults) or "nothing wrong"
    answer = "reached" if result.reached else result.answer
    return f"{faults}, home {mission.home}, {mission.goal}: {answer} in {result.steps} steps"


def require_homes(homes: Sequence[int]) -> None:
    """Refuse homes whose furniture training saw.

    Raises:
        ConfigError: there is one.
    """
    if min(homes) < 1000:
        raise ConfigError(f"home {min(homes)} of --seeds is a training home; give 1000 or more")
