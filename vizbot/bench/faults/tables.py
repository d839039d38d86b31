"""The tables of `vizbot bench faults`."""

from __future__ import annotations

from collections.abc import Sequence

from sim_stubs.faults.catalogue import CATALOGUE, Fault
from vizbot.bench.faults.camera_lock import CameraLock
from vizbot.bench.faults.missions import FaultMissionResult
from vizbot.bench.faults.monitor import FARTHEST_ASTRAY
from vizbot.bench.faults.reflex_latency import ReflexLatency
from vizbot.bench.faults.scores import MAY_END, FaultScore
from vizbot.bench.harness.board import BenchResult
from vizbot.bench.harness.scores import Rate
from vizbot.bench.harness.tables import counted, table, with_interval

NAME = "faults"
_LEGEND = (
    "Times are on the simulated clock, from the first observable effect of the fault: the sensor "
    "frame that tells of it and arrives whole, the first frame that is missing or black, the last "
    "command. Stopped: the wheels, if they turned then, are told to rest, to the end of that "
    "period of 15 ms, and stay at rest while the fault lasts; from what it has run into the "
    "robot may back off. Every second base is in Full mode: it does not stop by itself. Said "
    "so: the user reads a line about this fault; noticed after: the first one. Ran on: how far "
    f"a wheel turned in one go beyond what it had been told, {FARTHEST_ASTRAY:.2f} m being "
    "allowed. Drove on: rolled ahead 1 s after it was over and the wheels had stopped; ended: "
    "gave up and stayed where it was. Where nothing can reach the wheels, the robot rolls on as "
    "far as it says; its stop counts from when a program holds the port again, and must be the "
    "first command."
)


def outcome(
    scores: Sequence[FaultScore],
    missions: Sequence[FaultMissionResult],
    latency: ReflexLatency,
    lock: CameraLock,
    smoke_test: bool = False,
) -> BenchResult:
    """Everything that is printed about these results."""
    singles = [score for score in scores if len(score.series.faults) == 1]
    pairs = [score for score in scores if len(score.series.faults) == 2]
    on_missions = [stop for m in missions for stop in m.stops if stop.rolling]
    stopped = Rate(
        sum(score.in_time for score in scores) + sum(stop.in_time for stop in on_missions),
        sum(score.stops for score in scores) + len(on_missions),
    )
    allowed = [m for m in missions if m.should_arrive and m.mission.faults and m.happened]
    reached = Rate.over(m.reached for m in allowed)
    runs = sum(len(score.series.seeds) for score in scores)
    crashes = [line for score in scores for line in score.crashes]
    crashes += [m.crash for m in missions if m.crash]
    lost = sum(score.maps_lost for score in scores) + sum(m.map_kept is False for m in missions)
    strayed = sum(score.strayed for score in scores)
    silent = sum(score.happened - score.noticed for score in singles if _must_say(score))
    absent = sum(not m.happened for m in missions)
    low, high = reached.interval()
    summary: dict[str, object] = {
        "runs": runs + len(missions),
        "stopped_in_time": stopped.value,
        "goal_reached": reached.value,
        "goal_low": low,
        "goal_high": high,
        "crashes": len(crashes),
        "maps_lost": lost,
        "strayed": strayed,
        "silent": silent,
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
        f" the map. Wheels that turned stopped in time {with_interval(stopped)}; the goal"
        f" was reached in {with_interval(reached)} missions whose fault happened and allows it;"
        f" {absent} missions had ended before. In {strayed} drives a wheel turned too far beyond"
        f" what it had been told; in {silent} with one fault, that must be told, the user read"
        " nothing about it.",
        *(f"- {line}" for line in crashes),
        latency.told(),
        lock.told(),
    ]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the drives: no claim.")
    rows = [_row(score) for score in singles]
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def _drive_table(singles: Sequence[FaultScore], missions: Sequence[FaultMissionResult]) -> str:
    rows = []
    for score in singles:
        [name] = score.series.faults
        fault = CATALOGUE[name]
        arrived = Rate.over(m.reached for m in missions if m.mission.faults == (name,))
        rows.append(
            [name, counted(Rate(score.happened, len(score.series.seeds))), _said(fault, score),
             _range(score.noticed_median, score.noticed_max),
             _range(score.stopped_median, score.stopped_max), _limit(fault, score),
             with_interval(Rate(score.in_time, score.stops)),
             "-" if score.astray_max is None else f"{score.astray_max:.3f}",
             ("ended " if name in MAY_END else "")
             + with_interval(Rate(score.drove_on, score.happened)),
             (counted(arrived) if fault.goal else "need not") if arrived.of else "-",
             score.line or "-"]
        )  # fmt: skip
    header = ("fault", "happened", "said so", "noticed after, median (most) [s]", "stopped after",
              "limit", "in time", "ran on [m], most", "drove on", "goal reached",
              "what the user reads of it first")  # fmt: skip
    return table(header, rows)


def _must_say(score: FaultScore) -> bool:
    [fault] = (CATALOGUE[name] for name in score.series.faults)
    return fault.tells and bool(fault.says)


def _said(fault: Fault, score: FaultScore) -> str:
    if not fault.says:
        return "need not"
    return counted(Rate(score.noticed, score.happened)) if fault.tells else f"{score.noticed}"


def _limit(fault: Fault, score: FaultScore) -> str:
    if fault.stops_within is None:
        return "-"
    within = f"{fault.stops_within:g}"
    if fault.reaches_wheels:
        return within
    return f"cannot stop: {score.run_on_max:.2f} m; {within} once back"


def _pairs_line(pairs: Sequence[FaultScore]) -> str:
    if not pairs:
        return ""
    stops = Rate(sum(p.in_time for p in pairs), sum(p.stops for p in pairs))
    runs, happened = sum(len(p.series.seeds) for p in pairs), sum(p.happened for p in pairs)
    on = sum(p.drove_on for p in pairs)
    late = [" + ".join(p.series.faults) for p in pairs if p.in_time < p.stops]
    stuck = [" + ".join(p.series.faults) for p in pairs if p.drove_on < p.happened]
    text = (
        f"Two at a time: {len(pairs)} pairs, {runs} drives, in {happened} of which both happened;"
        f" wheels that turned stopped in time {with_interval(stops)}, the"
        f" robot drove on in {on}."
    )
    text += f" Late: {', '.join(late)}." if late else ""
    return f"{text} Not driven on: {', '.join(stuck)}." if stuck else text


def _missions_table(missions: Sequence[FaultMissionResult]) -> str:
    if not missions:
        return ""
    plain = Rate.over(m.reached for m in missions if not m.mission.faults)
    pairs = [m for m in missions if len(m.mission.faults) == 2]
    rows = [
        [" + ".join(m.mission.faults), m.mission.home, m.mission.goal,
         ("" if m.happened else "before it happened: ") + ("reached" if m.reached else m.answer),
         m.steps]
        for m in missions
        if m.mission.faults and (len(m.mission.faults) == 2 or not m.reached)
    ]  # fmt: skip
    text = (
        f"Through the whole loop, to goals at most 10 m away: the same goals without a fault"
        f" {with_interval(plain)}, two faults at a time"
        f" {with_interval(Rate.over(m.reached for m in pairs))}. Pairs, and single faults that did"
        " not reach it:"
    )
    return f"{text}\n\n{table(('faults', 'home', 'goal', 'what became of it', 'steps'), rows)}"


def _row(score: FaultScore) -> dict[str, object]:
    return {
        "row": " + ".join(score.series.faults),
        "runs": len(score.series.seeds),
        "happened": score.happened,
        "limit": score.limit,
        "stopped_median": score.stopped_median,
        "stopped_max": score.stopped_max,
        "in_time": score.in_time,
        "stops": score.stops,
        "noticed_median": score.noticed_median,
        "run_on_max": score.run_on_max,
        "drove_on": score.drove_on,
        "said": score.noticed,
        "astray_max": score.astray_max,
    }


def _range(middle: float | None, most: float | None) -> str:
    return "-" if middle is None or most is None else f"{middle:.2f} ({most:.2f})"
