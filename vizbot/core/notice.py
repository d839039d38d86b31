"""The level of what a person should read though nothing is wrong."""

from __future__ import annotations

import logging

NOTICE = 25
"""Between info, which a run's log file has, and warning."""
logging.addLevelName(NOTICE, "NOTE")
