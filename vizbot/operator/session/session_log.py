"""The log of a session: what happened, in lines for people."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass
from itertools import takewhile

from vizbot.core.observer import Outcome

_LINES, _STOPS = 200, 10
"""Lines of the log, and lines about stops in a row."""


@dataclass(frozen=True, slots=True)
class LogEntry:
    """One line of the log.

    Attributes:
        time: When, in seconds since 1970.
        code: What kind of thing happened: `goal`, `activity`, `ended`, `stop`, `wheel`,
            `verdict`, `doubt`, `resume`, `map`, `warning`.
        outcome: How that which has `ended` did; None in other lines.
    """

    time: float
    code: str
    text: str
    outcome: Outcome | None = None


class SessionLog:
    """The newest lines; written and read by any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._lines: deque[LogEntry] = deque(maxlen=_LINES)

    def lines(self) -> list[LogEntry]:
        """The lines, oldest first."""
        with self._lock:
            return list(self._lines)

    def write(self, code: str, text: str, outcome: Outcome | None = None) -> None:
        """Add a line."""
        with self._lock:
            now = time.time()  # noqa: TID251 - people read it, nothing is measured with it
            self._lines.append(LogEntry(now, code, text, outcome))

    def write_end(self, text: str, outcome: Outcome, reason: str) -> None:
        """Add how a task has ended."""
        self.write("ended", f"{text}: {outcome.replace('_', ' ')} ({reason})", outcome)

    def write_stop(self, text: str) -> None:
        """Add a stop; a thousand stops in a row leave the rest of the log alone."""
        with self._lock:
            row = list(takewhile(lambda line: line.code == "stop", reversed(self._lines)))
            same = [line for line in row if line.text == text]
            for line in same or row[_STOPS - 1 :]:
                self._lines.remove(line)
        self.write("stop", text)
