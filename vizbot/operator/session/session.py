"""The session between people and the running robot: what they ask for, what they are shown.

People come from the threads of a server, the robot from its own loop; nothing here waits.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import chain, takewhile
from queue import Full, Queue
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from vizbot.core.errors import ConfigError
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.core.types import BaseState, Feedback
from vizbot.operator.session.drive_lease import DriveLease
from vizbot.operator.session.task_queue import QueuedTask, TaskQueue, TaskRequest
from vizbot.pipeline import Pipeline

T = TypeVar("T")

SOMEBODY = "somebody"
_LINES, _STOPS = 200, 10
"""Of the log; and of these that tell of one stop after another."""
_TRACK, _SPACING = 20_000, 0.05
"""So many places of the track are kept, so far apart [m]."""
_JOBS = 20
"""So many may wait to be done."""
_RATE_OVER = 5.0
"""The rate of steps is that of the last so many seconds [s]."""


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the log.

    Attributes:
        time: When, in seconds since 1970.
        code: What kind of thing happened: `goal`, `activity`, `ended`, `stop`, `wheel`,
            `doubt`, `resume`, `map`, `warning`.
        text: In plain words.
        outcome: How that which has `ended` did; None in other lines.
    """

    time: float
    code: str
    text: str
    outcome: Outcome | None = None


class OperatorSession:
    """An observer that people talk to.

    Attributes:
        queue: What is to be done.
        lease: Who drives by hand.
        stopped: Set while the robot must rest, until somebody asks for something new.
        stops: How often somebody has stopped it.
        closed: Set when the run is to end.
        jobs: What the loop is to do between two steps, each with where its answer goes.
        base_state: What the base said last; None without one.
        resume_base: Asks a base that has ceased to obey, at an edge or lifted, to obey again.
        show: Tells people by the base's light and sound.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        """Nobody has asked for anything.

        Args:
            now: Time of the wall clock [s].
        """
        self._now = now
        self._lock = threading.Lock()
        self._orders = threading.RLock()
        self._goes_on = False
        self._step: Step | None = None
        self._track: deque[tuple[float, float]] = deque(maxlen=_TRACK)
        self._steps_at: deque[float] = deque()
        self._log: deque[Line] = deque(maxlen=_LINES)
        self._activity = ""
        self.base_state: Callable[[], BaseState | None] = lambda: None
        self.resume_base: Callable[[], None] = lambda: None
        self.show: Callable[[Feedback], None] = lambda feedback: None
        self.jobs: Queue[tuple[Callable[[Pipeline], None], Future[Any]]] = Queue(_JOBS)
        self.queue = TaskQueue()
        self.lease = DriveLease(now)
        self.stopped = threading.Event()
        self.stops = 0
        self.closed = threading.Event()

    def ask(
        self, requests: Sequence[TaskRequest], *, at_once: bool = False, stops: int | None = None
    ) -> list[QueuedTask]:
        """Ask for goals in words, places, or what needs no words.

        Args:
            requests: In this order.
            at_once: What is running gives way.
            stops: What `stops` was when this was said, where that was a while ago.

        Raises:
            ConfigError: too many are waiting, or the robot was stopped since.
        """
        requests = [
            printable(request, 200) if isinstance(request, str) else request for request in requests
        ]
        with self._orders:
            if stops is not None and stops != self.stops:
                raise ConfigError("the robot was stopped meanwhile; ask again")
            tasks = self.queue.add(requests, at_once=at_once)
            self._goes_on = True
        for task in tasks:
            self.write("goal", task.text)
        return tasks

    def go_on(self) -> None:
        """Do what is still to be done although the robot was stopped."""
        with self._orders:
            self._goes_on = True

    def begin_step(self) -> None:
        """The robot's loop looks here: what was asked for after a stop ends the resting.

        It does not before the loop has ended what the stop has called off.
        """
        with self._orders:
            running = self.queue.current()
            if self._goes_on and not (running is not None and running.called_off):
                self._goes_on = False
                self.stopped.clear()

    def between_steps(self, job: Callable[[Pipeline], T]) -> Future[T]:
        """Have the robot's loop do something short with its maps.

        Raises:
            ConfigError: too much is waiting.
        """
        done: Future[T] = Future()

        def do(pipeline: Pipeline) -> None:
            if done.set_running_or_notify_cancel():
                try:
                    done.set_result(job(pipeline))
                except Exception as error:  # whatever it is, it is the asker's, not the run's
                    done.set_exception(error)

        try:
            self.jobs.put_nowait((do, done))
        except Full as error:
            raise ConfigError(f"{_JOBS} questions are waiting already; ask later") from error
        return done

    def begin_map(self) -> None:
        """The robot has left its map for another one: what was shown of it is no more."""
        with self._lock:
            self._step = None
            self._track.clear()
        self.queue.forget_places()

    def stop(self, who: str) -> None:
        """Rest now: what was asked for is called off, nobody drives any more."""
        who = printable(who, 40) or SOMEBODY
        with self._orders:
            self._goes_on = False
            self.stops += 1
            self.stopped.set()
            self.lease.revoke()
            self.queue.call_all_off(f"stopped by {who}")
        self._write_stop(f"stopped by {who}")

    def take_lease(self, who: str, *, over: bool = False) -> int | None:
        """Drive by hand; see `DriveLease.take`. A running task waits until it is given back."""
        who = printable(who, 40) or SOMEBODY
        with self._orders:
            before = self.lease.holder
            link = self.lease.take(who, over=over)
            if link is None:
                return None
            self._goes_on = True
        self.write("wheel", f"{who} drives" + (f" instead of {before}" if before else ""))
        return link

    def release_lease(self, link: int, *, given_back: bool) -> None:
        """Drive no more.

        Args:
            link: That drove; nothing happens where it does not any more.
            given_back: What is running goes on. Else the link was lost, and the robot rests until
                somebody asks it to go on: nobody may be looking.
        """
        with self._orders:
            if not self.lease.holds(link):
                return
            who = self.lease.holder
            if not given_back:
                self._goes_on = False
                self.stopped.set()
            self.lease.release(link)
        lost = "" if given_back else ", the link ended: the robot rests until it is asked to go on"
        self.write("wheel", f"{who} drives no more{lost}")

    def write(self, code: str, text: str, outcome: Outcome | None = None) -> None:
        """Add a line to the log."""
        with self._lock:
            self._log.append(Line(time.time(), code, text, outcome))

    def _write_stop(self, text: str) -> None:
        """Add a line; anybody may stop a thousand times, and the rest of the log shall stay."""
        with self._lock:
            row = list(takewhile(lambda line: line.code == "stop", reversed(self._log)))
            same = [line for line in row if line.text == text]
            for line in same or row[_STOPS - 1 :]:
                self._log.remove(line)
        self.write("stop", text)

    def write_end(self, text: str, outcome: Outcome, reason: str) -> None:
        """Add how something that was asked for has ended."""
        self.write("ended", f"{text}: {outcome.replace('_', ' ')} ({reason})", outcome)

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
        self.queue.report(report)
        self.write_end(report.text, report.outcome, report.reason)

    def newest_step(self) -> Step | None:
        """The newest step; None before the first."""
        return self._step

    def position(self) -> tuple[float, float, float] | None:
        """x, y, z of the base in `map` [m]; None before the first step."""
        if (step := self._step) is None:
            return None
        x, y, z = (round(float(value), 3) for value in step.T_map_base[:3, 3])
        return x, y, z

    def track(self) -> NDArray[np.float64]:
        """Where the base was, (N, 2) x, y in `map` [m], every few centimetres."""
        with self._lock:
            return np.fromiter(chain.from_iterable(self._track), np.float64).reshape(-1, 2)

    def log(self) -> list[Line]:
        """What has happened lately, oldest first."""
        with self._lock:
            return list(self._log)

    def step_rate(self) -> float:
        """Steps of the last seconds [1/s]."""
        with self._lock:
            since = self._now() - self._steps_at[0] if self._steps_at else 0.0
            return len(self._steps_at) / max(since, 1.0)


def printable(text: str, longest: int) -> str:
    """Text without what a terminal would obey, cut."""
    return "".join(letter for letter in text if letter.isprintable()).strip()[:longest]
