"""What the program warns of, shown to people as well."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from vizbot.core.interfaces import Base
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.core.types import Feedback
from vizbot.operator.session.session import OperatorSession

_OURS = ("drivers", "mapping", "nav", "sim_stubs", "vizbot")


@contextmanager
def log_warnings(session: OperatorSession) -> Iterator[None]:
    """Put our warnings into the log of the session while this lasts."""
    alerts = _Alerts(session)
    root = logging.getLogger()
    root.addHandler(alerts)
    try:
        yield
    finally:
        root.removeHandler(alerts)


class _Alerts(logging.Handler):
    """Each warning once, until there is another."""

    def __init__(self, session: OperatorSession) -> None:
        super().__init__(logging.WARNING)
        self._session = session
        self._last = ""

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if record.name.partition(".")[0] in _OURS and text != self._last:
            self._last = text
            self._session.write("warning", text)


_FEEDBACK = {
    Outcome.ARRIVED: Feedback.FOUND,
    Outcome.LOCATED: Feedback.FOUND,
    Outcome.EXPLORED: Feedback.FOUND,
    Outcome.NOT_FOUND: Feedback.NOT_FOUND,
    Outcome.GAVE_UP: Feedback.STUCK,
}


class OutcomeFeedback:
    """An observer that shows every outcome by the base's lights and songs."""

    def __init__(self, base: Base) -> None:
        self._base = base

    def on_step(self, step: Step) -> None:
        """Nothing is shown on the way."""

    def on_goal(self, report: GoalReport) -> None:
        """Light and song for the outcome."""
        self._base.show(_FEEDBACK[report.outcome])
