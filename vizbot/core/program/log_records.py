"""Log records of a process of its own, for the log of the one that began it."""

from __future__ import annotations

import logging

NOTICE = 25
"""Between info, which a run's log file has, and warning."""
logging.addLevelName(NOTICE, "NOTE")

_MOST_RECORDS, _LONGEST_LINE = 100, 4000
"""Log records that are kept between two answers, and their characters."""


class LogRecords(logging.Handler):
    """Keeps log records until they are sent."""

    def __init__(self) -> None:
        super().__init__()
        self._kept: list[logging.LogRecord] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a record, its message formatted; the oldest ones give way."""
        record.msg, record.args = record.getMessage()[:_LONGEST_LINE], None
        record.exc_info = record.exc_text = record.stack_info = None
        self._kept = [*self._kept[-_MOST_RECORDS:], record]

    def take(self) -> list[logging.LogRecord]:
        """The records since the last call."""
        taken, self._kept = self._kept, []
        return taken
