"""The tables of `vizbot bench faults`."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.faults.missions import FaultMissionResult
from benchmarks.faults.monitor import FARTHEST_ASTRAY
from benchmarks.faults.scores import MAY_END, FaultScore
from benchmarks.faults.totals import DefaultResults, FaultTotals, WallClockTiming, single_faults
from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.scores import Rate
from benchmarks.harness.tables import fraction_text, fraction_with_interval, markdown_table
from sim_stubs.faults.catalogue import CATALOGUE, Fault

NAME = "faults"
_LEGEND = (
    "Times are on the simulated clock, from the first observable effect of the fault: the first "
    "whole sensor frame that reports it, the first frame that is missing or black, the last "
    "command. Stopped: wheels that turned then are commanded to rest, to the end of that period of "
    "15 ms, and stay at rest while the fault lasts; from an obstacle the robot may back off. "
    "Every second base is in Full mode, where it does not stop by itself. Said so: the user reads "
    "a line about this fault; noticed after: the first such line. Ran on: how far a wheel turned "
    f"in one go beyond its commands; {FARTHEST_ASTRAY:.2f} m are allowed. Drove on: the robot "
    "rolled ahead 1 s after the fault was over and the wheels had stopped; ended: it gave up and "
    "stayed where it was. The robot resumes Safe mode by itself, except in the columns with the "
    "product's settings. Where no command can reach the wheels, the table says how far the robot "
    "rolls; its stop counts from when a program holds the port again, and must be the first "
    "command."
)


def fault_result(
    scores: Sequence[FaultScore],
    missions: Sequence[FaultMissionResult],
    timing: WallClockTiming | None,
    smoke_test: bool = False,
    by_default: DefaultResults | None = None,
) -> BenchResult:
    """Rows, summary and tables of these results, and beside them those by default.

    Args:
        scores: Scores of the drives.
        missions: The missions.
        timing: Times on the wall clock; None where they were not kept.
        smoke_test: Whether only a part was run.
        by_default: Results with the product's settings.
    """
    by_default = by_default or DefaultResults()
    singles = single_faults(scores)
    totals = FaultTotals.count(scores, missions)
    summary = totals.summary() | by_default.summary()
    if timing is not None:
        summary |= {
            "reflex_ms_median": timing.reflexes.median_ms,
            "reflex_ms_p99": timing.reflexes.p99_ms,
            "reflex_ms_max": timing.reflexes.max_ms,
        }
        if timing.hung_pairs is not None:
            summary["hung_pair_ms_max"] = timing.hung_pairs.max_ms
    parts = [
        _drive_table(singles, missions, by_default),
        _LEGEND,
        _pairs_line([score for score in scores if len(score.series.faults) == 2]),
        _missions_table(missions),
        totals.text(),
        by_default.text(),
        "" if timing is None else timing.text(),
    ]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the drives: no claim.")
    rows = [_row(score) for score in singles]
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def _drive_table(
    singles: Sequence[FaultScore],
    missions: Sequence[FaultMissionResult],
    by_default: DefaultResults,
) -> str:
    rows = []
    for score in singles:
        [name] = score.series.faults
        fault = CATALOGUE[name]
        arrived = Rate.over(m.reached for m in missions if m.mission.faults == (name,))
        rows.append(
            [name, fraction_text(Rate(score.happened, len(score.series.seeds))),
             _said(fault, score),
             _range(score.noticed_median, score.noticed_max),
             _range(score.stopped_median, score.stopped_max), _limit(fault, score),
             fraction_with_interval(Rate(score.in_time, score.stops)),
             "-" if score.astray_max is None else f"{score.astray_max:.3f}",
             ("ended " if name in MAY_END else "")
             + fraction_with_interval(Rate(score.drove_on, score.happened)),
             (fraction_text(arrived) if fault.goal else "need not") if arrived.trials else "-",
             by_default.of_drives(name), by_default.of_missions(name), score.line or "-"]
        )  # fmt: skip
    header = ("fault", "happened", "said so", "noticed after, median (most) [s]", "stopped after",
              "limit", "in time", "ran on [m], most", "drove on", "goal reached",
              "drives, product's settings", "goal reached, product's settings",
              "what the user reads of it first")  # fmt: skip
    return markdown_table(header, rows)


def _said(fault: Fault, score: FaultScore) -> str:
    if not fault.report_pattern:
        return "need not"
    return (
        fraction_text(Rate(score.noticed, score.happened))
        if fault.must_report
        else f"{score.noticed}"
    )


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
        f" wheels that turned stopped in time {fraction_with_interval(stops)}, the"
        f" robot drove on in {on}."
    )
    text += f" Late: {', '.join(late)}." if late else ""
    return f"{text} Not driven on: {', '.join(stuck)}." if stuck else text


def _missions_table(missions: Sequence[FaultMissionResult]) -> str:
    if not missions:
        return ""
    undisturbed = Rate.over(m.reached for m in missions if not m.mission.faults)
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
        f" {fraction_with_interval(undisturbed)}, two faults at a time"
        f" {fraction_with_interval(Rate.over(m.reached for m in pairs))}. Pairs, and single faults"
        " that did not reach it:"
    )
    header = ("faults", "home", "goal", "what became of it", "steps")
    return f"{text}\n\n{markdown_table(header, rows)}"


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
