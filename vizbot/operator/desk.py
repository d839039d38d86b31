"""The desk between people and the running robot: what they ask for, what they are shown.

People come from the threads of a server, the robot from its own loop; nothing here waits.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from queue import Full, Queue

import numpy as np
from numpy.typing import NDArray

from vizbot.core.errors import ConfigError
from vizbot.core.geometry import yaw_of
from vizbot.core.observation import GoalReport, Step
from vizbot.core.types import BaseState
from vizbot.operator.agenda import Agenda, Errand
from vizbot.operator.answers import Answer
from vizbot.operator.base_report import base_report
from vizbot.operator.state_line import contacts
from vizbot.operator.wheel import Wheel

SOMEBODY = "somebody"
_LINES = 200
_TRACK, _SPACING = 20_000, 0.05
"""So many places of the track are kept, so far apart [m]."""
_TOLD_EVERY = 0.15
"""[s]"""
_QUESTIONS = 20
"""So many may wait for an answer."""
_RATE_OVER = 5.0
"""The rate of steps is that of the last so many seconds [s]."""


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the log.

    Attributes:
        time: When, in seconds since 1970.
        code: What kind of thing happened: `goal`, `activity`, `ended`, `stop`, `wheel`.
        text: In plain words.
    """

    time: float
    code: str
    text: str


class Desk:
    """An observer that people talk to.

    Attributes:
        agenda: What is to be done.
        wheel: Who drives by hand.
        stopped: Set while the robot must rest, until somebody asks for something new.
        closed: Set when the run is to end.
        questions: Texts to be looked up on the map as it is, each with where its answer goes.
        base_state: What the base said last; None without one.
        resume_base: Asks a base that has ceased to obey, at an edge or lifted, to obey again.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        """Nobody has asked for anything.

        Args:
            now: Time of the wall clock [s].
        """
        self._now = now
        self._lock = threading.Lock()
        self._orders = threading.RLock()
        self._telling = threading.Lock()
        self._told, self._told_at = "", -math.inf
        self._goes_on = False
        self._step: Step | None = None
        self._track: deque[tuple[float, float]] = deque(maxlen=_TRACK)
        self._steps_at: deque[float] = deque()
        self._log: deque[Line] = deque(maxlen=_LINES)
        self._activity = ""
        self.base_state: Callable[[], BaseState | None] = lambda: None
        self.resume_base: Callable[[], None] = lambda: None
        self.questions: Queue[tuple[str, Future[Answer]]] = Queue(_QUESTIONS)
        self.agenda = Agenda()
        self.wheel = Wheel(now)
        self.stopped = threading.Event()
        self.closed = threading.Event()

    def ask(self, texts: Sequence[str], *, at_once: bool = False) -> list[Errand]:
        """Ask for goals in words, or, with an empty text, for an exploration.

        Raises:
            ConfigError: too many are waiting.
        """
        with self._orders:
            errands = self.agenda.add([plain(text, 200) for text in texts], at_once=at_once)
            self._goes_on = True
        for errand in errands:
            self.write("goal", errand.text or "explore")
        return errands

    def go_on(self) -> None:
        """Do what is still to be done although the robot was stopped."""
        with self._orders:
            self._goes_on = True

    def begin_step(self) -> None:
        """The robot's loop looks here: what was asked for after a stop ends the resting.

        It does not before the loop has ended what the stop has called off.
        """
        with self._orders:
            running = self.agenda.current()
            if self._goes_on and not (running is not None and running.called_off):
                self._goes_on = False
                self.stopped.clear()

    def look_up(self, text: str) -> Future[Answer]:
        """Ask the map as it is; the robot answers between two steps.

        Raises:
            ConfigError: too many questions are waiting.
        """
        answer: Future[Answer] = Future()
        try:
            self.questions.put_nowait((text, answer))
        except Full as error:
            raise ConfigError(f"{_QUESTIONS} questions are waiting already; ask later") from error
        return answer

    def stop(self, who: str) -> None:
        """Rest now: what was asked for is called off, nobody drives any more."""
        who = plain(who, 40) or SOMEBODY
        with self._orders:
            self._goes_on = False
            self.stopped.set()
            self.wheel.take_away()
            self.agenda.call_all_off(f"stopped by {who}")
        self.write("stop", f"stopped by {who}")

    def take_wheel(self, who: str, *, over: bool = False) -> int | None:
        """Drive by hand; see `Wheel.take`. What is running waits until the wheel is given back."""
        who = plain(who, 40) or SOMEBODY
        with self._orders:
            before = self.wheel.holder
            link = self.wheel.take(who, over=over)
            if link is None:
                return None
            self._goes_on = True
        self.write("wheel", f"{who} drives" + (f" instead of {before}" if before else ""))
        return link

    def release_wheel(self, link: int, *, given_back: bool) -> None:
        """Drive no more.

        Args:
            link: That drove; nothing happens where it does not any more.
            given_back: What is running goes on. Else the link was lost, and the robot rests until
                somebody asks it to go on: nobody may be looking.
        """
        with self._orders:
            if not self.wheel.holds(link):
                return
            who = self.wheel.holder
            if not given_back:
                self._goes_on = False
                self.stopped.set()
            self.wheel.release(link)
        lost = "" if given_back else ", the link ended: the robot rests until it is asked to go on"
        self.write("wheel", f"{who} drives no more{lost}")

    def write(self, code: str, text: str) -> None:
        """Add a line to the log."""
        with self._lock:
            self._log.append(Line(time.time(), code, text))

    def on_step(self, step: Step) -> None:
        """Keep the newest step, and when it was."""
        now = self._now()
        here = float(step.T_map_base[0, 3]), float(step.T_map_base[1, 3])
        with self._lock:
            self._step = step
            if not self._track or math.dist(here, self._track[-1]) > _SPACING:
                self._track.append(here)
            self._steps_at.append(now)
            while now - self._steps_at[0] > _RATE_OVER:
                self._steps_at.popleft()
            changed, self._activity = step.activity != self._activity, step.activity
        if changed:
            self.write("activity", step.activity)

    def on_goal(self, report: GoalReport) -> None:
        """Keep the answer."""
        self.agenda.report(report)
        self.write("ended", f"{report.text}: {report.outcome} ({report.reason})")

    def newest(self) -> Step | None:
        """The newest step; None before the first."""
        return self._step

    def track(self) -> NDArray[np.float64]:
        """Where the base was, (N, 2) x, y in `map` [m], every few centimetres."""
        with self._lock:
            return np.array(self._track).reshape(-1, 2)

    def told(self) -> str:
        """The state as JSON, made once for all who watch."""
        with self._telling:
            now = self._now()
            if now - self._told_at >= _TOLD_EVERY:
                self._told, self._told_at = json.dumps(self.state()), now
            return self._told

    def state(self) -> dict[str, object]:
        """All that a person is shown in words and figures, ready for JSON."""
        with self._lock:
            step, log = self._step, list(self._log)
            since = self._now() - self._steps_at[0] if self._steps_at else 0.0
            rate = len(self._steps_at) / max(since, 1.0)
        state: dict[str, object] = {
            "stopped": self.stopped.is_set(),
            "wheel": self.wheel.holder,
            "goals": [_errand(errand) for errand in self.agenda.errands()],
            "steps_per_second": round(rate, 1),
            "base": _base(self.base_state()),
            "log": [{"time": line.time, "code": line.code, "text": line.text} for line in log],
        }
        if step is None:
            return state | {"step": None, "activity": "starting"}
        x, y, yaw = *step.T_map_base[:2, 3], yaw_of(step.T_map_base)
        best, to_go = step.best_similarity, step.distance_to_go
        return state | {
            "step": step.index,
            "activity": step.activity,
            "goal": step.goal,
            "tracking": step.estimate.tracking,
            "position": [round(float(x), 3), round(float(y), 3)],
            "heading": round(yaw, 3),
            "best_similarity": None if best is None else round(best, 4),
            "threshold": round(step.threshold, 4),
            "distance_to_go": None if to_go is None else round(to_go, 2),
        }


def plain(text: str, longest: int) -> str:
    """Text without what a terminal would obey, cut."""
    return "".join(letter for letter in text if letter.isprintable()).strip()[:longest]


def _errand(errand: Errand) -> dict[str, object]:
    over = errand.outcome is not None
    return {
        "number": errand.number,
        "text": errand.text or "explore",
        "outcome": errand.outcome,
        "reason": errand.reason if over else "",
        "position": errand.position,
    }


def _base(state: BaseState | None) -> dict[str, object] | None:
    if state is None:
        return None
    return base_report(state) | {"feels": contacts(state)}
