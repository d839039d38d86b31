"""How the searches for goals ended, and the time and distance of each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Candidate, Effort, GoalReport, Observer, Outcome
from vizbot.core.types import SE3
from vizbot.current_map import CurrentMap
from vizbot.objectnav.tasks import Goal


class Odometer:
    """Measures the search that is under way; what somebody drives by hand meanwhile counts."""

    def __init__(self) -> None:
        self._goal: Goal | None = None
        self._began = self._now = self._way = 0.0
        self._xy: NDArray[np.float64] | None = None

    def observe(self, goal: Goal | None, T_map_base: SE3, now: float) -> None:
        """Observe a step at `now` [s]; another `goal` begins anew, None goes on."""
        if goal is not None and goal is not self._goal:
            self._goal, self._began, self._way, self._xy = goal, now, 0.0, None
        xy = T_map_base[:2, 3].copy()
        if self._xy is not None:
            self._way += float(np.linalg.norm(xy - self._xy))
        self._xy, self._now = xy, now

    def effort(self, goal: Goal) -> Effort | None:
        """What the search for a goal took; None where it is not the last one that began."""
        if goal is not self._goal:
            return None
        return Effort(self._now - self._began, self._way)


class GoalReports:
    """Reports to an observer how each goal ended.

    Attributes:
        odometer: Measures the search that is under way.
    """

    def __init__(self, observer: Observer) -> None:
        self.odometer, self._observer = Odometer(), observer

    def report(
        self,
        goal: Goal,
        outcome: Outcome,
        reason: str,
        current: CurrentMap,
        threshold: float | None = None,
    ) -> GoalReport:
        """Report how the search for a goal ended, with the best places on the map.

        The reason ends with how the encoder understood the words, where that needs saying.

        `threshold` is what the best place was compared with; None takes that of the search.
        """
        search, arrived = current.search, outcome is Outcome.ARRIVED
        report = GoalReport(
            goal.text,
            outcome,
            reason if goal.note is None else f"{reason}; {goal.note}",
            _candidates(goal, current, arrived=arrived),
            search.measure,
            self.odometer.effort(goal),
            search.threshold(goal) if threshold is None else threshold,
        )
        self._observer.on_goal(report)
        return report

    def look_up(self, goal: Goal, current: CurrentMap) -> GoalReport:
        """Ask the map as it is now (paper, section III-B) and report the answer."""
        candidates, measure = _candidates(goal, current), current.search.measure
        least = current.search.found_above(goal)
        enough = f"{measure} {measure.text(least)}"
        if candidates and candidates[0].score > least:
            return self.report(goal, Outcome.LOCATED, f"above the {enough}", current, least)
        reason = f"the best place on the map is not above the {enough}"
        return self.report(goal, Outcome.NOT_FOUND, reason, current, least)


def _candidates(goal: Goal, current: CurrentMap, *, arrived: bool = False) -> tuple[Candidate, ...]:
    """The best places for a goal; that where the robot has arrived comes first."""
    if not current.has_frames:
        return ()
    return current.search.candidates(goal, current.perception, arrived=arrived)
