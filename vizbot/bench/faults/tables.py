"""The tables of `vizbot bench faults`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sim_stubs.faults.catalogue import CATALOGUE, Fault
from vizbot.bench.faults.camera_lock import CameraLock
from vizbot.bench.faults.missions import FaultMissionResult
from vizbot.bench.faults.monitor import FARTHEST_ASTRAY
from vizbot.bench.faults.reflex_latency import ReflexLatency
from vizbot.bench.faults.scores import MAY_END, FaultScore
from vizbot.bench.harness.bench_plan import BenchResult
from vizbot.bench.harness.scores import Rate
from vizbot.bench.harness.tables import fraction_text, fraction_with_interval, markdown_table

NAME = "faults"
_LEGEND = (
    "Times are on the simulated clock, from the first observable effect of the fault: the first "
    "whole sensor frame that reports it, the first frame that is missing or black, the last "
    "command. Stopped: wheels that turned then are commanded to rest, to the end of that period of "
    "15 ms, and stay at rest while the fault lasts; from an obstacle the robot may back off. "
    "Every second base is in Full mode, where it does not stop by itself. Said so: the user reads "
    "a line about this fault; noticed after: the first one. Ran on: how far a wheel turned in one "
    f"go beyond its commands; {FARTHEST_ASTRAY:.2f} m are allowed. Drove on: rolled ahead 1 s "
    "after the fault was over and the wheels had stopped; ended: gave up and stayed where it was. "
    "The robot resumes Safe mode by itself, but for the columns with the product's settings. "
    "Where no command can reach the wheels, the table says how far the robot rolls; its stop "
    "counts from when a program holds the port again, and must be the first command."
)


@dataclass(frozen=True, slots=True)
class DefaultResults:
    """Results with the product's settings.

    Attributes:
        scores: Scores of the drives, whose faults may end a search by these settings.
        missions: All missions.
    """

    scores: Sequence[FaultScore] = ()
    missions: Sequence[FaultMissionResult] = ()

    def of_drives(self, name: str) -> str:
        """How the drives with a fault went on; a dash where it was not driven."""
        for score in self.scores:
            if score.series.faults == (name,):
                return f"drove on {score.drove_on}, ended {score.ended} of {score.happened}"
        return "-"

    def of_missions(self, name: str) -> str:
        """How the missions with this fault alone ended; a dash where there were none."""
        ours = [m for m in self.missions if m.mission.faults == (name,)]
        if not ours:
            return "-"
        ended = sum(m.ended_by_default for m in ours)
        reached = fraction_text(Rate.over(m.reached for m in ours))
        return f"{reached}, {ended} ended" if ended else reached

    @property
    def right(self) -> Rate:
        """Missions that reached their goal or ended as the settings demand for their fault.

        Counted where the fault happened and allows the goal.
        """
        allowed = [m for m in self.missions if m.should_arrive and m.mission.faults and m.happened]
        return Rate.over(m.reached or m.ended_by_default for m in allowed)

    def text(self) -> str:
        """Totals and what became of the missions that neither arrived nor ended rightly."""
        if not self.missions:
            return ""
        ended = sum(m.ended_by_default for m in self.missions)
        undisturbed = Rate.over(m.reached for m in self.missions if not m.mission.faults)
        rows = [
            [" + ".join(m.mission.faults) or "nothing wrong", m.mission.home, m.mission.goal,
             ("" if m.happened else "before it happened: ") + m.answer, m.steps]
            for m in self.missions
            if m.should_arrive and not m.reached and not m.ended_by_default
        ]  # fmt: skip
        parts = [
            "With the product's settings the base does not resume Safe mode by itself: an edge, a"
            " lift or the loss of its mode may end the search. Where the robot then stays and"
            f" gives that reason it has done right, and is counted as ended: {ended} of"
            f" {len(self.missions)} missions. Right are {fraction_with_interval(self.right)}"
            " missions whose fault happened and allows the goal; without a fault the goal was"
            f" reached {fraction_with_interval(undisturbed)}.",
            FaultTotals.count(self.scores, self.missions).text(),
        ]
        if rows:
            header = ("with the product's settings, neither reached nor ended rightly", "home",
                      "goal", "what became of it", "steps")  # fmt: skip
            parts.append(markdown_table(header, rows))
        return "\n\n".join(parts)

    def summary(self) -> dict[str, object]:
        """The totals for programs."""
        return {
            "default_missions": len(self.missions),
            "default_reached": sum(m.reached for m in self.missions),
            "default_ended": sum(m.ended_by_default for m in self.missions),
            "default_right": self.right.value,
        }


@dataclass(frozen=True, slots=True)
class FaultTotals:
    """Totals over all drives and missions.

    Attributes:
        drives: Number of drives.
        missions: Number of missions.
        stopped: How often turning wheels stopped in time.
        reached: How often a mission reached its goal, where its fault happened and allows it.
        crashes: Errors that ended the program, one line each.
        maps_lost: Runs whose map could not be kept.
        strayed: Drives in which a wheel turned too far beyond its commands.
        silent: Drives with one fault that the user must read about and did not.
        absent: Missions that ended before their fault happened.
    """

    drives: int
    missions: int
    stopped: Rate
    reached: Rate
    crashes: tuple[str, ...]
    maps_lost: int
    strayed: int
    silent: int
    absent: int

    @staticmethod
    def count(scores: Sequence[FaultScore], missions: Sequence[FaultMissionResult]) -> FaultTotals:
        """Sum up drives and missions."""
        mission_stops = [stop for m in missions for stop in m.stops if stop.rolling]
        allowed = [m for m in missions if m.should_arrive and m.mission.faults and m.happened]
        crashes = [line for score in scores for line in score.crashes]
        return FaultTotals(
            drives=sum(len(score.series.seeds) for score in scores),
            missions=len(missions),
            stopped=Rate(
                sum(s.in_time for s in scores) + sum(stop.in_time for stop in mission_stops),
                sum(s.stops for s in scores) + len(mission_stops),
            ),
            reached=Rate.over(m.reached for m in allowed),
            crashes=(*crashes, *(m.crash for m in missions if m.crash)),
            maps_lost=sum(s.maps_lost for s in scores) + sum(m.map_kept is False for m in missions),
            strayed=sum(score.strayed for score in scores),
            silent=sum(s.happened - s.noticed for s in _single(scores) if _must_say(s)),
            absent=sum(not m.happened for m in missions),
        )

    def text(self) -> str:
        """The totals as a paragraph, with a list of the crashes."""
        paragraph = (
            f"Of {self.drives} drives and {self.missions} missions {len(self.crashes)} crashed or"
            f" hung, {self.maps_lost} lost the map. Wheels that turned stopped in time"
            f" {fraction_with_interval(self.stopped)}; the goal was reached in"
            f" {fraction_with_interval(self.reached)} missions whose fault happened and allows it;"
            f" {self.absent} missions had ended before. In {self.strayed} drives a wheel turned too"
            f" far beyond its commands; in {self.silent} with one fault that the user must read"
            " about, there was no line about it."
        )
        return "\n\n".join([paragraph, *(f"- {line}" for line in self.crashes)])

    def summary(self) -> dict[str, object]:
        """The totals for programs."""
        low, high = self.reached.interval()
        return {
            "runs": self.drives + self.missions,
            "stopped_in_time": self.stopped.value,
            "goal_reached": self.reached.value,
            "goal_low": low,
            "goal_high": high,
            "crashes": len(self.crashes),
            "maps_lost": self.maps_lost,
            "strayed": self.strayed,
            "silent": self.silent,
        }


def fault_result(
    scores: Sequence[FaultScore],
    missions: Sequence[FaultMissionResult],
    latency: ReflexLatency,
    lock: CameraLock,
    smoke_test: bool = False,
    by_default: DefaultResults | None = None,
) -> BenchResult:
    """Rows, summary and tables of these results, and beside them those by default."""
    by_default = by_default or DefaultResults()
    singles = _single(scores)
    totals = FaultTotals.count(scores, missions)
    summary = totals.summary() | {
        "reflex_ms_median": latency.median_ms,
        "reflex_ms_p99": latency.p99_ms,
        "reflex_ms_max": latency.max_ms,
    }
    summary |= by_default.summary()
    parts = [
        _LEGEND,
        _drive_table(singles, missions, by_default),
        _pairs_line([score for score in scores if len(score.series.faults) == 2]),
        _missions_table(missions),
        totals.text(),
        by_default.text(),
        latency.summary(),
        lock.summary(),
    ]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the drives: no claim.")
    rows = [_row(score) for score in singles]
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def _single(scores: Sequence[FaultScore]) -> list[FaultScore]:
    """The scores of drives with one fault."""
    return [score for score in scores if len(score.series.faults) == 1]


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


def _must_say(score: FaultScore) -> bool:
    [fault] = (CATALOGUE[name] for name in score.series.faults)
    return fault.must_report and bool(fault.report_pattern)


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
