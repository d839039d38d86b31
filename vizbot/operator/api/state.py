"""The state of a running robot, ready for JSON; `answers.RobotState` is its model."""

from __future__ import annotations

import json
import math
import threading
import time

from vizbot.core.geometry import yaw_of
from vizbot.core.observer import Effort, Step
from vizbot.core.types import BaseState
from vizbot.operator.client.base_json import base_report
from vizbot.operator.figures.panels import LARGE, MapView
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.session_log import LogEntry
from vizbot.operator.session.task_queue import QueuedTask
from vizbot.operator.session.verdicts import ApproachedCandidate, Arrival
from vizbot.operator.teleop.status_line import contacts

_MAX_AGE = 0.15
"""A state that is made for all is used again for so long [s]."""


class SharedState:
    """The state as JSON, made once for everybody who watches; safe to use from several threads."""

    def __init__(self, session: OperatorSession) -> None:
        self._session = session
        self._lock = threading.Lock()
        self._json, self._made_at = "", -math.inf

    def json(self) -> str:
        """The state, at most 0.15 s old."""
        with self._lock:
            now = time.monotonic()
            if now - self._made_at >= _MAX_AGE:
                self._json, self._made_at = json.dumps(state_of(self._session)), now
            return self._json


def state_of(session: OperatorSession) -> dict[str, object]:
    """The state, ready for JSON."""
    state: dict[str, object] = {
        "stopped": session.stopped.is_set(),
        "wheel": session.lease.holder,
        "goals": [_task(task) for task in session.queue.tasks()],
        "steps_per_second": round(session.step_rate(), 1),
        "base": _base(session.robot.base_state()),
        "arrival": _arrival(session.arrival),
        "candidate": _candidate(session.candidate),
        "question": None if session.question is None else session.question.text,
        "log": [_line(line) for line in session.log.lines()],
        "run": None if session.robot.folder is None else str(session.robot.folder.absolute()),
    }
    step, scored = session.newest_step(), session.scored_step()
    if step is None:
        return state | {"step": None, "activity": "starting", "map_view": None}
    score, to_go = step.shown_score, step.distance_to_go
    return state | {
        "step": step.index,
        "activity": step.activity,
        "why": step.why,
        "goal": step.goal,
        "likeness": "" if scored is None else scored.goal,
        "tracking": step.estimate.tracking,
        "position": [round(float(value), 3) for value in step.T_map_base[:2, 3]],
        "heading": round(yaw_of(step.T_map_base), 3),
        "score": None if score is None else round(score, 4),
        "measure": step.measure,
        "threshold": round(step.threshold, 4),
        "distance_to_go": None if to_go is None else round(to_go, 2),
        "map_view": _map_view(step, session.map_turn.turn_at(step)),
    }


def _map_view(step: Step, turn: float) -> dict[str, object]:
    """Where the picture of the map lies in `map`; see `answers.MapPictureView`."""
    view = MapView.from_step(step, turn, LARGE)
    return {
        "corner": [round(float(value), 3) for value in view.corner],
        "metres_per_pixel": 1.0 / view.scale,
        "width": view.size[0],
        "height": view.size[1],
        "turn": view.turn,
    }


def _line(line: LogEntry) -> dict[str, object]:
    """A line of the log; only the end of a task has an outcome."""
    fields: dict[str, object] = {"time": line.time, "code": line.code, "text": line.text}
    return fields if line.outcome is None else fields | {"outcome": line.outcome}


def _task(task: QueuedTask) -> dict[str, object]:
    over = task.outcome is not None
    return {
        "number": task.number,
        "text": task.text,
        "headline": task.headline,
        "outcome": task.outcome,
        "reason": task.reason if over else "",
        "position": task.position,
        **_effort(task.effort),
    }


def _arrival(arrival: Arrival | None) -> dict[str, object] | None:
    if arrival is None:
        return None
    return {
        "number": arrival.number,
        "text": arrival.report.text,
        "headline": arrival.report.headline,
        "has_picture": arrival.picture is not None,
        "confirmed": arrival.confirmed,
        **_effort(arrival.report.effort),
    }


def _candidate(candidate: ApproachedCandidate | None) -> dict[str, object] | None:
    if candidate is None:
        return None
    return {
        "number": candidate.number,
        "text": candidate.goal,
        "headline": candidate.headline,
        "position": [round(float(value), 3) for value in candidate.place_xy],
        "confirmed": candidate.confirmed,
    }


def _effort(effort: Effort | None) -> dict[str, object]:
    if effort is None:
        return {"seconds": None, "way": None}
    return {"seconds": round(effort.seconds, 1), "way": round(effort.way, 2)}


def _base(state: BaseState | None) -> dict[str, object] | None:
    if state is None:
        return None
    return base_report(state) | {"feels": contacts(state)}
