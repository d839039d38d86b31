"""JPEGs of what the robot sees and knows, drawn once however many people watch."""

from __future__ import annotations

import threading

from vizbot.operator.desk import Desk
from vizbot.operator.encoded import jpeg
from vizbot.operator.panels import panel

NAMES = ("colour", "depth", "map", "similarity")
"""Of the pictures; `similarity` is the heat map of what is asked for."""
_PANELS = {
    "colour": "colour",
    "depth": "depth",
    "map": "obstacle map",
    "similarity": "similarity",
}


class Pictures:
    """Of the newest step; safe to use from several threads."""

    def __init__(self, desk: Desk) -> None:
        """Nothing is drawn before somebody asks for it."""
        self._desk = desk
        self._lock = threading.Lock()
        self._drawn: int | None = None
        self._jpegs: dict[str, bytes] = {}

    def newest(self, name: str) -> tuple[int, bytes] | None:
        """The number of the step and a picture of it as JPEG; None before the first step.

        Args:
            name: One of `NAMES`.
        """
        step = self._desk.newest()
        if step is None:
            return None
        with self._lock:
            if self._drawn != step.index:
                self._jpegs, self._drawn = {}, step.index
            if name not in self._jpegs:
                self._jpegs[name] = jpeg(panel(_PANELS[name], step, self._desk.track()))
            return step.index, self._jpegs[name]
