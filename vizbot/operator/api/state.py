"""All that a person is shown of a running robot in words and figures."""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable

from vizbot.core.geometry import yaw_of
from vizbot.core.observer import Step
from vizbot.core.types import BaseState
from vizbot.operator.client.base_json import base_report
from vizbot.operator.figures.panels import TILE, MapView
from vizbot.operator.session.session import Line, OperatorSession
from vizbot.operator.session.task_queue import QueuedTask
from vizbot.operator.teleop.status_line import contacts

_EVERY = 0.15
"""[s]"""


class SharedState:
    """The state as JSON, made once for all who watch; safe to use from several threads."""

    def __init__(self, desk: OperatorSession, now: Callable[[], float] = time.monotonic) -> None:
        """Nothing is made before somebody asks.

        Args:
            desk: Of the robot.
            now: Time of the wall clock [s].
        """
        self._desk = desk
        self._now = now
        self._lock = threading.Lock()
        self._json, self._made_at = "", -math.inf

    def json(self) -> str:
        """As it was a moment ago at most."""
        with self._lock:
            now = self._now()
            if now - self._made_at >= _EVERY:
                self._json, self._made_at = json.dumps(state_of(self._desk)), now
            return self._json


def state_of(desk: OperatorSession) -> dict[str, object]:
    """The state, ready for JSON."""
    state: dict[str, object] = {
        "stopped": desk.stopped.is_set(),
        "wheel": desk.wheel.holder,
        "goals": [_errand(errand) for errand in desk.agenda.errands()],
        "steps_per_second": round(desk.rate(), 1),
        "base": _base(desk.base_state()),
        "log": [_line(line) for line in desk.log()],
    }
    step = desk.newest()
    if step is None:
        return state | {"step": None, "activity": "starting", "map_view": None}
    best, to_go = step.best_similarity, step.distance_to_go
    return state | {
        "step": step.index,
        "activity": step.activity,
        "goal": step.goal,
        "tracking": step.estimate.tracking,
        "position": [round(float(value), 3) for value in step.T_map_base[:2, 3]],
        "heading": round(yaw_of(step.T_map_base), 3),
        "best_similarity": None if best is None else round(best, 4),
        "threshold": round(step.threshold, 4),
        "distance_to_go": None if to_go is None else round(to_go, 2),
        "map_view": _map_view(step),
    }


def _map_view(step: Step) -> dict[str, object]:
    """Where the picture of the map lies in `map`: x, y of its lower left corner [m], and its size.

    A pixel `column, row` from its upper left corner shows
    `corner + (column, height - row) * metres_per_pixel`.
    """
    view = MapView.from_step(step)
    return {
        "corner": [round(float(value), 3) for value in view.corner],
        "metres_per_pixel": 1.0 / view.scale,
        "width": TILE[0],
        "height": TILE[1],
    }


def _line(line: Line) -> dict[str, object]:
    """A line of the log; an outcome is told only where something has ended."""
    told: dict[str, object] = {"time": line.time, "code": line.code, "text": line.text}
    return told if line.outcome is None else told | {"outcome": line.outcome}


def _errand(errand: QueuedTask) -> dict[str, object]:
    over = errand.outcome is not None
    return {
        "number": errand.number,
        "text": errand.text,
        "outcome": errand.outcome,
        "reason": errand.reason if over else "",
        "position": errand.position,
    }


def _base(state: BaseState | None) -> dict[str, object] | None:
    if state is None:
        return None
    return base_report(state) | {"feels": contacts(state)}
