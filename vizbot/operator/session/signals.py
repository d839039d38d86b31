"""The base tells who stands by how a search ended."""

from __future__ import annotations

from vizbot.core.interfaces import Base
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.core.types import Feedback

_FEEDBACK = {
    Outcome.ARRIVED: Feedback.FOUND,
    Outcome.LOCATED: Feedback.FOUND,
    Outcome.EXPLORED: Feedback.FOUND,
    Outcome.NOT_FOUND: Feedback.NOT_FOUND,
    Outcome.GAVE_UP: Feedback.STUCK,
}


class Signals:
    """An observer that shows every outcome by the base's lights and songs."""

    def __init__(self, base: Base) -> None:
        self._base = base

    def on_step(self, step: Step) -> None:
        """Nothing is shown on the way."""

    def on_goal(self, report: GoalReport) -> None:
        """Light and song for the outcome."""
        self._base.show(_FEEDBACK[report.outcome])
