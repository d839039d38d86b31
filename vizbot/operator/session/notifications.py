"""What the program warns of, shown to people as well."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from vizbot.operator.session.session import Desk

_OURS = ("drivers", "mapping", "nav", "sim_stubs", "vizbot")


@contextmanager
def alerting(desk: Desk) -> Iterator[None]:
    """Put our warnings into the log of the desk while this lasts."""
    alerts = _Alerts(desk)
    root = logging.getLogger()
    root.addHandler(alerts)
    try:
        yield
    finally:
        root.removeHandler(alerts)


class _Alerts(logging.Handler):
    """Each warning once, until there is another."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(logging.WARNING)
        self._desk = desk
        self._last = ""

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if record.name.partition(".")[0] in _OURS and text != self._last:
            self._last = text
            self._desk.write("warning", text)
