"""The course of a run: its events, and for its report the curves and answers of each goal."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from vizbot.core.observer import GoalReport, Step
from vizbot.core.types import Tracking
from vizbot.operator.figures.steps import StepRate
from vizbot.operator.report.chart import Chart, chart

_MOST_EVENTS = 300
_MOST_STEPS = 20_000
_NUMBERS = re.compile(r"\d+")


@dataclass(slots=True)
class GoalTimeline:
    """The search for one goal.

    Attributes:
        steps: Indices of its steps; empty where a goal was only looked up.
        best: Best score in each step; NaN while the map was empty.
        thresholds: The score to exceed in each step.
        report: How the search ended; None if the run ended first.
    """

    text: str
    steps: list[int] = field(default_factory=list)
    best: list[float] = field(default_factory=list)
    thresholds: list[float] = field(default_factory=list)
    report: GoalReport | None = None

    @property
    def chart(self) -> Chart | None:
        """The best score over steps; None without any."""
        return chart(self.steps, {"best": self.best, "threshold": self.thresholds})


@dataclass(frozen=True, slots=True)
class TimelineEvent:
    """When something happened.

    Attributes:
        seconds: Since the first frame [s].
        step: Index of the step.
        warns: Whether something was not as it should be.
    """

    seconds: float
    step: int
    text: str
    warns: bool


class Timeline:
    """Collects the course of a run; curves longer than 20 000 steps are thinned.

    Attributes:
        goals: One timeline for each goal, in order.
        events: Oldest first.
    """

    def __init__(self) -> None:
        self.goals: list[GoalTimeline] = []
        self.events: list[TimelineEvent] = []
        self._changes, self._rate = Events(), StepRate()
        self._count = 0
        self._steps: list[int] = []
        self._rates: list[float] = []
        self._began: float | None = None
        self._now = 0.0

    def add(self, step: Step) -> None:
        """Add a step."""
        stamp = step.frame.stamp
        self._began = stamp if self._began is None else self._began
        self._now = stamp - self._began
        for event in self._changes.changes(step):
            self.events.append(TimelineEvent(self._now, step.index, event.text, event.warns))
        self._steps.append(step.index)
        self._rate.add(stamp)
        self._rates.append(_or_nan(self._rate.rate(stamp)))
        self._count += 1
        _thin(self._steps, self._rates)
        if not step.goal:
            return
        goal = self._timeline(step.goal)
        goal.steps.append(step.index)
        goal.best.append(_or_nan(step.best_score))
        goal.thresholds.append(step.threshold)
        _thin(goal.steps, goal.best, goal.thresholds)

    def end(self, report: GoalReport) -> None:
        """End the timeline of a goal."""
        self._timeline(report.text).report = report
        step = self._steps[-1] if self._steps else 0
        self.events.append(TimelineEvent(self._now, step, report.headline, False))

    @property
    def seconds(self) -> float:
        """From the first frame to the last [s]."""
        return self._now

    @property
    def rate(self) -> float | None:
        """Steps per second of the whole run [1/s]; None where it is too short."""
        return (self._count - 1) / self._now if self._now > 0.0 else None

    @property
    def rates(self) -> Chart | None:
        """Steps per second over steps; None without any."""
        return chart(self._steps, {"rate": self._rates}, from_zero=True)

    @property
    def latest(self) -> list[TimelineEvent]:
        """The newest events, as many as the page has room for."""
        return self.events[-_MOST_EVENTS:]

    def _timeline(self, goal: str) -> GoalTimeline:
        """The timeline of the running search, or a new one."""
        if not self.goals or self.goals[-1].report or self.goals[-1].text != goal:
            self.goals.append(GoalTimeline(goal))
        return self.goals[-1]


def _or_nan(number: float | None) -> float:
    return np.nan if number is None else number


def _thin(*curve: list[int] | list[float]) -> None:
    """Drop every second step of a curve that is too long, but not the last one."""
    if len(curve[0]) > _MOST_STEPS:
        for numbers in curve:
            del numbers[1:-1:2]


@dataclass(frozen=True, slots=True)
class Event:
    """One line.

    Attributes:
        text: In plain words.
        warns: Whether something is not as it should be.
    """

    text: str
    warns: bool = False


class Events:
    """Notices what changes from step to step: map, goal, activity and why, tracking.

    A reason whose numbers alone have changed is the same one.
    """

    def __init__(self) -> None:
        self._map_number: int | None = None
        self._goal, self._doing = "", ("", "")
        self._lost = False

    def changes(self, step: Step) -> list[Event]:
        """The events of a step; call once for each."""
        events = []
        if self._map_number not in (None, step.map_number):
            events.append(Event("another map begins"))
        if step.goal and step.goal != self._goal:
            events.append(Event(f"goal: {step.goal}"))
        lost = step.estimate.tracking is Tracking.LOST
        if lost and not self._lost:
            events.append(Event("it has lost its place", warns=True))
        elif self._lost and not lost:
            events.append(Event("it knows its place again"))
        doing = step.activity, _NUMBERS.sub("", step.short_why)
        if doing != self._doing:
            events.append(Event(f"{step.activity}: {step.why}" if step.why else step.activity))
        self._map_number = step.map_number
        self._goal, self._doing, self._lost = step.goal, doing, lost
        return events
