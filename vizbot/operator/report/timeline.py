"""What becomes of a run's goals, as the report tells it: curves, answers, events."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vizbot.core.observer import GoalReport, Step
from vizbot.operator.report.chart import Chart, chart
from vizbot.operator.report.events import Events, StepRate

_MOST_EVENTS = 300
_MOST_STEPS = 20_000


@dataclass(slots=True)
class GoalTimeline:
    """The search for one goal.

    Attributes:
        text: The goal.
        steps: Indices of its steps; none where a goal was only looked up.
        best: Best similarity in each; NaN while the map was empty.
        thresholds: What it had to exceed.
        report: How it ended; None if the run ended first.
    """

    text: str
    steps: list[int] = field(default_factory=list)
    best: list[float] = field(default_factory=list)
    thresholds: list[float] = field(default_factory=list)
    report: GoalReport | None = None

    @property
    def chart(self) -> Chart | None:
        """Similarity over steps; None without any."""
        return chart(self.steps, {"best": self.best, "threshold": self.thresholds})


@dataclass(frozen=True, slots=True)
class TimelineEvent:
    """When something happened.

    Attributes:
        seconds: Since the first frame [s].
        step: Its index.
        text: What.
        warns: Whether something was not as it should be.
    """

    seconds: float
    step: int
    text: str
    warns: bool


class Timeline:
    """Follows a run; of curves longer than 20 000 steps older ones are told ever more coarsely.

    Attributes:
        chapters: One for each goal, in order.
        moments: Events, oldest first.
    """

    def __init__(self) -> None:
        """Nothing has happened yet."""
        self.chapters: list[GoalTimeline] = []
        self.moments: list[TimelineEvent] = []
        self._events, self._rate = Events(), StepRate()
        self._count = 0
        self._steps: list[int] = []
        self._rates: list[float] = []
        self._began: float | None = None
        self._now = 0.0

    def add(self, step: Step) -> None:
        """Tell on."""
        stamp = step.frame.stamp
        self._began = stamp if self._began is None else self._began
        self._now = stamp - self._began
        for event in self._events.of(step):
            self.moments.append(TimelineEvent(self._now, step.index, event.text, event.warns))
        self._steps.append(step.index)
        self._rates.append(_or_nan(self._rate.after(stamp)))
        self._count += 1
        _thin(self._steps, self._rates)
        if not step.goal:
            return
        chapter = self._open(step.goal)
        chapter.steps.append(step.index)
        chapter.best.append(_or_nan(step.best_similarity))
        chapter.thresholds.append(step.threshold)
        _thin(chapter.steps, chapter.best, chapter.thresholds)

    def begin_map(self) -> None:
        """Tell that the next step is on another map."""
        self._tell("another map begins")

    def end(self, report: GoalReport) -> None:
        """Close the chapter of a goal."""
        self._open(report.text).report = report
        self._tell(f"{report.text}: {report.outcome}")

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
        """The events that the page has room for."""
        return self.moments[-_MOST_EVENTS:]

    def _tell(self, text: str) -> None:
        """Of what happens after the last step."""
        step = self._steps[-1] if self._steps else 0
        self.moments.append(TimelineEvent(self._now, step, text, False))

    def _open(self, goal: str) -> GoalTimeline:
        """The chapter that is being told, or a new one."""
        if not self.chapters or self.chapters[-1].report or self.chapters[-1].text != goal:
            self.chapters.append(GoalTimeline(goal))
        return self.chapters[-1]


def _or_nan(number: float | None) -> float:
    return np.nan if number is None else number


def _thin(*curve: list[int] | list[float]) -> None:
    """Leave every second step out of a curve that is too long, but not the last one."""
    if len(curve[0]) > _MOST_STEPS:
        for numbers in curve:
            del numbers[1:-1:2]
