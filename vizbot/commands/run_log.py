"""`vizbot.log` in a run's folder: what happened and when, to find the cause of a failure."""

from __future__ import annotations

import logging
import time
from contextlib import suppress
from io import FileIO
from pathlib import Path
from types import TracebackType
from typing import Self

from vizbot.core.errors import VizbotError
from vizbot.core.interfaces import Clock
from vizbot.core.observer import GoalReport, Step
from vizbot.operator.printing import PrintableFormatter

FILE_NAME = "vizbot.log"
PACKAGES = ("drivers", "mapping", "nav", "sim_stubs", "vizbot")
"""The log has key events of these packages, and warnings of all others."""

log = logging.getLogger(__name__)


class RunLog(logging.Handler):
    """Writes the log file of a run while it is entered.

    A line holds the wall clock's date and time, the simulated time where the clock is simulated,
    level, module and message. Lines wait until the folder is there. A full disk costs lines, not
    the run. An exception that ends the run is the last line.
    """

    def __init__(self) -> None:
        super().__init__()
        self.setFormatter(PrintableFormatter("%(levelname)s %(name)s: %(message)s"))
        self._waiting: list[str] = []
        self._file: FileIO | None = None
        self._warned = False
        self._simulated: Clock | None = None
        self._levels: dict[str, int] = {}

    def open(self, folder: Path, clock: Clock) -> None:
        """Write to the run's folder what waits, and from now on every line at once."""
        try:
            self._file = (folder / FILE_NAME).open("ab", buffering=0)
        except OSError as error:
            self._warn(error)
        waiting, self._waiting = self._waiting, []
        for line in waiting:
            self._write(line)
        self._simulated = clock if clock.simulated else None

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line, or let it wait."""
        try:
            stamp = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record.created))
            simulated = self._simulated
            at = "" if simulated is None else f" [{simulated.now():9.3f} s]"
            line = f"{stamp}.{int(record.msecs):03d}{at} {self.format(record)}\n"
            if self._file is None and not self._warned:
                self._waiting.append(line)
            else:
                self._write(line)
        except Exception:  # a message that does not fit its arguments, as for any handler
            self.handleError(record)

    def __enter__(self) -> Self:
        for package in PACKAGES:
            logger = logging.getLogger(package)
            self._levels[package] = logger.level
            if logger.getEffectiveLevel() > logging.INFO:
                logger.setLevel(logging.INFO)
        logging.getLogger().addHandler(self)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None and error is not None:
            expected = isinstance(error, (VizbotError, KeyboardInterrupt))
            record = log.makeRecord(
                log.name,
                logging.ERROR,
                __file__,
                0,
                "ended by %s: %s",
                (kind.__name__, error),
                None if expected else (kind, error, trace),
            )
            self.handle(record)  # for the file alone: the command line reports it to the user
        logging.getLogger().removeHandler(self)
        for package, level in self._levels.items():
            logging.getLogger(package).setLevel(level)
        # Not in `close`, which whoever configures logging (uvicorn does) calls for all handlers.
        if self._file is not None:
            with suppress(OSError):
                self._file.close()
        self.close()

    def _write(self, line: str) -> None:
        if self._file is None or self._file.closed:
            return
        try:
            self._file.write(line.encode("utf-8", "backslashreplace"))
        except OSError as error:
            self._warn(error)

    def _warn(self, error: OSError) -> None:
        if not self._warned:
            self._warned = True
            log.warning("%s lacks lines: %s; the run goes on", FILE_NAME, error.strerror or error)


class GoalLog:
    """An observer that logs when the search for a goal begins and how it ends."""

    def __init__(self) -> None:
        self._goal = ""

    def on_step(self, step: Step) -> None:
        """Log the goal of the step if it is a new one."""
        if step.goal and step.goal != self._goal:
            log.info("goal begun in step %d: %s", step.index, step.goal)
        self._goal = step.goal

    def on_goal(self, report: GoalReport) -> None:
        """Log how it ended."""
        log.info("goal ended: %s: %s", report.headline, report.reason)
        self._goal = ""
