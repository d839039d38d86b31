"""Warnings of the program in the log of a session, outcomes by the base's lights and songs."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from vizbot.core.interfaces import Base
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.core.types import Feedback
from vizbot.operator.session.session import OperatorSession

_OUR_PACKAGES = ("drivers", "mapping", "nav", "sim_stubs", "vizbot")


@contextmanager
def log_warnings(session: OperatorSession) -> Iterator[None]:
    """Copy the warnings of this program's packages to the session's log while entered."""
    handler = _SessionLogHandler(session)
    root = logging.getLogger()
    root.addHandler(handler)
    try:
        yield
    finally:
        root.removeHandler(handler)


class _SessionLogHandler(logging.Handler):
    """Writes each warning once, until another one comes."""

    def __init__(self, session: OperatorSession) -> None:
        super().__init__(logging.WARNING)
        self._session = session
        self._last = ""

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if record.name.partition(".")[0] in _OUR_PACKAGES and text != self._last:
            self._last = text
            self._session.log.write("warning", text)


_FEEDBACK = {
    Outcome.ARRIVED: Feedback.FOUND,
    Outcome.LOCATED: Feedback.FOUND,
    Outcome.EXPLORED: Feedback.FOUND,
    Outcome.NOT_FOUND: Feedback.NOT_FOUND,
    Outcome.GAVE_UP: Feedback.STUCK,
    Outcome.STUCK: Feedback.STUCK,
}


class OutcomeFeedback:
    """An observer that plays the outcome of each goal on the base's lights and speaker."""

    def __init__(self, base: Base) -> None:
        self._base = base

    def on_step(self, step: Step) -> None:
        """Do nothing: only outcomes are shown."""

    def on_goal(self, report: GoalReport) -> None:
        """Show the outcome."""
        self._base.show(_FEEDBACK[report.outcome])
