"""How much of the log is shown on standard error."""

from __future__ import annotations

import logging

from vizbot.core.program.log_records import NOTICE
from vizbot.operator.printing import PrintableFormatter


def show_warnings() -> None:
    """Show notices and warnings."""
    shown = logging.StreamHandler()
    shown.setLevel(NOTICE)  # a run's log file has more
    shown.setFormatter(PrintableFormatter("%(levelname)s: %(message)s"))
    logging.basicConfig(level=NOTICE, handlers=[shown])


def show_events() -> None:
    """Show the key events of our packages as well (`--verbose`)."""
    from vizbot.commands.run_log import PACKAGES

    for package in PACKAGES:
        logging.getLogger(package).setLevel(logging.INFO)
    for handler in logging.getLogger().handlers:
        handler.setLevel(min(handler.level, logging.INFO))
