"""Totals of `vizbot bench faults`: over drives and missions, by default, on the wall clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.faults.missions import FaultMissionResult
from benchmarks.faults.scores import MAY_END, RESTS_BY_DEFAULT, FaultScore
from benchmarks.faults.wall_clock import HungPairs, ReflexLatency
from benchmarks.harness.scores import Rate
from benchmarks.harness.tables import fraction_text, fraction_with_interval, markdown_table
from sim_stubs.faults.catalogue import CATALOGUE


@dataclass(frozen=True, slots=True)
class WallClockTiming:
    """What is timed on this machine's own clock.

    Attributes:
        reflexes: Time from a bump to the stop.
        hung_pairs: Times from a hang of watchdog and reflexes to the wheels at rest; None in
            results from before this was measured.
    """

    reflexes: ReflexLatency
    hung_pairs: HungPairs | None = None

    def text(self) -> str:
        """Each in a paragraph."""
        timed = (self.reflexes, self.hung_pairs)
        return "\n\n".join(each.summary() for each in timed if each is not None)


@dataclass(frozen=True, slots=True)
class DefaultResults:
    """Results with the product's settings."""

    scores: Sequence[FaultScore] = ()
    missions: Sequence[FaultMissionResult] = ()

    def of_drives(self, name: str) -> str:
        """How the drives with a fault went on; a dash where it was not driven."""
        for score in self.scores:
            if score.series.faults == (name,) and name in (*MAY_END, *RESTS_BY_DEFAULT):
                return f"ended {score.ended} of {score.happened}"
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
        """Missions that reached their goal, if they may, or ended as the settings demand.

        Counted where the fault happened and allows the goal.
        """
        allowed = [m for m in self.missions if m.should_arrive and m.mission.faults and m.happened]
        return Rate.over(m.right_by_default for m in allowed)

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
            if m.should_arrive and not m.right_by_default
        ]  # fmt: skip
        parts = [
            "With the product's settings the base does not resume Safe mode by itself: an edge, a"
            " lift, the loss of its mode, or a silence in which somebody may have moved it may end"
            " the search, since nobody is there to be asked. Where the robot then stays and"
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
            silent=sum(s.happened - s.noticed for s in single_faults(scores) if must_say(s)),
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


def single_faults(scores: Sequence[FaultScore]) -> list[FaultScore]:
    """The scores of drives with one fault."""
    return [score for score in scores if len(score.series.faults) == 1]


def must_say(score: FaultScore) -> bool:
    """Whether the user must read about the one fault of these drives."""
    [fault] = (CATALOGUE[name] for name in score.series.faults)
    return fault.must_report and bool(fault.report_pattern)
