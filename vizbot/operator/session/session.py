"""The exchange between people and a running robot: their requests, and what they are shown.

People come from the threads of a server, the robot from its own loop; nothing here waits.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapping.clip.reading import Reading
from vizbot.core.errors import ConfigError
from vizbot.core.observer import Candidate, GoalReport, OpenQuestion, Outcome, Step
from vizbot.operator.figures.steps import StepRate, Track
from vizbot.operator.figures.wall_direction import MapTurn
from vizbot.operator.session.loop_jobs import LoopJobs
from vizbot.operator.session.session_log import SessionLog
from vizbot.operator.session.shared_robot import BareRobot, SharedRobot
from vizbot.operator.session.task_queue import QueuedTask, TaskQueue, TaskRequest
from vizbot.operator.session.verdicts import ApproachedCandidate, Arrival, candidate_of
from vizbot.pipeline import Pipeline

SOMEBODY = "somebody"
_LONGEST_REQUEST, _LONGEST_NAME = 200, 40
"""Letters of a goal, and of a person's name."""
_SPACING = 0.05
"""Places of the track are at least this far apart [m]."""


class OperatorSession:
    """The operators' side of a run: an observer that takes their requests.

    What waits for the robot's loop raises a `ConfigError` where too much is asked at once, and a
    `DeviceTimeoutError` where the robot is too busy or its run ends.

    Attributes:
        queue: The tasks that they asked for.
        lease: Who drives by hand.
        stopped: Set while the robot must rest, until somebody asks for something new.
        stops: How often somebody has stopped the robot.
        closed: Set when the run is to end.
        jobs: What the loop has to do between two steps.
        arrival: Where the robot has arrived last; None before, and once another search has begun.
        candidate: What the robot approaches because it may be the goal; None without one.
        map_turn: How its map is turned to be shown upright.
    """

    def __init__(
        self,
        robot: SharedRobot | None = None,
        now: Callable[[], float] = time.monotonic,
        reading: Callable[[str], Reading] = Reading,
    ) -> None:
        """Create it without tasks.

        Args:
            robot: None has no base and keeps nothing.
            now: Time [s].
            reading: How the encoder understands a goal, as `TextEncoder.reading`.
        """
        self._now, self._reading = now, reading
        self._lock = threading.Lock()
        self._orders = threading.RLock()
        self._goes_on = False
        self._step: Step | None = None
        self._scored: Step | None = None
        self._first_frame = 0
        self._track = Track(spacing=_SPACING)
        self._rate = StepRate()
        self._activity = ""
        self.robot: SharedRobot = BareRobot(now) if robot is None else robot
        self.lease, self.stopped = self.robot.lease, self.robot.stopped
        self.arrival: Arrival | None = None
        self.candidate: ApproachedCandidate | None = None
        self.map_turn = MapTurn()
        self.log = SessionLog()
        self.jobs = LoopJobs()
        self.queue = TaskQueue()
        self.stops = 0
        self.closed = threading.Event()

    def ask(
        self, requests: Sequence[TaskRequest], *, at_once: bool = False, stops: int | None = None
    ) -> list[QueuedTask]:
        """Queue goals in words, places, or tasks that need no words.

        With `at_once` the running task gives way; `stops` is the session's count when somebody
        asked, if that was a while ago.

        Raises:
            ConfigError: a goal cannot be taken, too many wait, or the robot was stopped since.
        """
        requests = [self.readable(request) for request in requests]
        with self._orders:
            if stops is not None:
                self._require_no_stop_since(stops)
            tasks = self.queue.add(requests, at_once=at_once)
            self._goes_on = True
        for task in tasks:
            self.log.write("goal", task.text)
        return tasks

    def readable(self, request: TaskRequest) -> TaskRequest:
        """A request as it is queued.

        Raises:
            ConfigError: a goal is too long, or the encoder has no name for it.
        """
        if not isinstance(request, str):
            return request
        if len(request) > _LONGEST_REQUEST:
            raise ConfigError(f"a goal has at most {_LONGEST_REQUEST} letters; say it shorter")
        goal = printable(request, _LONGEST_REQUEST)
        self._reading(goal)
        return goal

    @property
    def awaits_verdict(self) -> bool:
        """Whether nobody has said yet if what the robot has arrived at is it."""
        arrival = self.arrival
        return arrival is not None and arrival.confirmed is None

    def judge(self, *, confirmed: bool, who: str) -> list[QueuedTask]:
        """Say whether what the robot has arrived at last is what it was asked for.

        Where it is not, that place is believed less, and the search for the same words goes on at
        once. Waits for the robot's loop.

        Returns:
            The search that goes on; nothing where it was found.

        Raises:
            ConfigError: the robot has not arrived, or does something else by now, or was stopped
                meanwhile, or its method of search believes nothing.
        """
        who, stops = printable(who, _LONGEST_NAME) or SOMEBODY, self.stops

        def judge(pipeline: Pipeline) -> list[QueuedTask]:
            arrival = self.arrival
            if arrival is None:
                raise ConfigError(
                    "nothing is to be judged: the robot has not arrived, or has begun another"
                    " search or map since"
                )
            tasks = [] if confirmed else self._search_on(arrival, pipeline, stops)
            self.arrival = replace(arrival, confirmed=confirmed)
            self.robot.keep_verdict(arrival.report, confirmed)
            verdict = "that is it" if confirmed else "that is not it; the search goes on"
            self.log.write("verdict", f"{arrival.report.text}: {who} says {verdict}")
            return tasks

        return self.jobs.wait_for(judge)

    def judge_candidate(self, number: int, *, confirmed: bool, who: str) -> None:
        """Say whether to go to what the robot sees, and take it for the goal, or to keep looking.

        In the latter case that place is believed less, as where `judge` says that it is not it.
        Waits for the robot's loop.

        Raises:
            ConfigError: the robot approaches something else by now.
        """
        who = printable(who, _LONGEST_NAME) or SOMEBODY

        def judge(pipeline: Pipeline) -> None:
            candidate = self.candidate
            if candidate is None or candidate.number != number:
                raise ConfigError("the robot has turned to something else by now")
            if confirmed:
                pipeline.affirm(candidate.place_xy)
            else:
                pipeline.refute(candidate.place_xy)
            self.candidate = replace(candidate, confirmed=True) if confirmed else None
            self.robot.keep_verdict_on_way(candidate.place_xy, confirmed)
            verdict = "go there" if confirmed else "that is not it; the search goes on"
            self.log.write("verdict", f"{candidate.goal}: {who} says {verdict}")

        self.jobs.wait_for(judge)

    def candidate_picture(self, number: int) -> bytes:
        """JPEG of the candidate that the robot approaches, with a box around it.

        Waits for the robot's loop.

        Raises:
            LookupError: the robot has turned to something else, or kept no picture; it says why.
        """

        def draw(pipeline: Pipeline) -> bytes:
            candidate, place = self.candidate, None
            if candidate is not None and candidate.number == number:
                place = pipeline.candidate(candidate.place_xy)
            if place is None:
                raise LookupError("the robot has turned to something else by now")
            if (picture := self.robot.picture_of_place(place)) is None:
                raise LookupError(self._why_no_picture([place]))
            return picture

        return self.jobs.wait_for(draw)

    def _why_no_picture(self, places: Sequence[Candidate]) -> str:
        """Why there is no picture of the best of these places."""
        if places and places[0].frame < self._first_frame:
            return "no picture: the robot knows this place from the saved map"
        return "no picture of this place was kept"

    def _search_on(self, arrival: Arrival, pipeline: Pipeline, stops: int) -> list[QueuedTask]:
        """Refute an arrival and queue the search for the same words."""
        with self._orders:  # a stop comes before all of this or after it
            if (running := self.queue.current()) is not None:
                raise ConfigError(f"the robot goes on already: {running.text}; stop it first")
            self._require_no_stop_since(stops)
            pipeline.refute()
            return self.ask([arrival.report.text])

    def _require_no_stop_since(self, stops: int) -> None:
        if stops != self.stops:
            raise ConfigError("the robot was stopped meanwhile; ask again")

    @property
    def question(self) -> OpenQuestion | None:
        """What the robot asks; it rests until somebody says to go on. None where it asks nothing.

        Unlike a verdict on an arrival, every task waits for the answer.
        """
        return None if self._step is None else self._step.question

    def go_on(self) -> None:
        """Go on with the queue although the robot was stopped, or asks whether it may."""
        with self._orders:
            self._goes_on = True
            asks = self.question is not None
        if asks:
            self.robot.resume_base()
            self.log.write("resume", "somebody said to go on")

    def begin_step(self) -> None:
        """Called by the robot's loop: end the rest after a stop, if something new was asked for.

        The rest goes on until the loop has ended the task that the stop called off.
        """
        with self._orders:
            running = self.queue.current()
            if self._goes_on and not (running is not None and running.called_off):
                self._goes_on = False
                self.stopped.clear()

    def leave_map(self) -> None:
        """Drop what was shown of the map that the robot has left."""
        self.arrival = self.candidate = None
        with self._lock:
            self._step = self._scored = None
            self._track = Track(spacing=_SPACING)
        self.queue.forget_places()

    def stop(self, who: str) -> None:
        """Stop the robot now, call off all tasks and end the lease."""
        who = printable(who, _LONGEST_NAME) or SOMEBODY
        with self._orders:
            self._goes_on = False
            self.stops += 1
            self.stopped.set()
            self.lease.revoke()
            self.queue.call_all_off(f"stopped by {who}")
        self.log.write_stop(f"stopped by {who}")

    def call_off(self, goals: Collection[str], who: str) -> list[str]:
        """Call off some goals, and return them in the queue's words; the others stay."""
        texts = {goal.casefold() for goal in goals}
        called_off = self._call_off(lambda task: task.text.casefold() in texts, who)
        return [task.text for task in called_off]

    def cancel(self, number: int, who: str) -> None:
        """Call off one task that runs or waits.

        Raises:
            ConfigError: no such task runs or waits.
        """
        if not self._call_off(lambda task: task.number == number, who):
            raise ConfigError(f"no task {number} runs or waits; look at what was asked for")

    def _call_off(self, chosen: Callable[[QueuedTask], bool], who: str) -> list[QueuedTask]:
        reason = f"called off by {printable(who, _LONGEST_NAME) or SOMEBODY}"
        called_off = self.queue.call_off(chosen, reason)
        for task in called_off:
            if task.outcome is not None:  # the end of a running one is written by the loop
                self.log.write_end(task.text, task.outcome, reason)
        return called_off

    def do_next(self, number: int) -> None:
        """Let a task that waits be the next one.

        Raises:
            ConfigError: no such task waits.
        """
        if not self.queue.move_to_front(number):
            raise ConfigError(f"no task {number} waits; look at what was asked for")

    def ask_again(self, number: int) -> list[QueuedTask]:
        """Queue once more what a task that is over was about.

        Raises:
            ConfigError: no such task is over, or too many wait.
        """
        for task in self.queue.tasks():
            if task.number == number and task.outcome is not None:
                return self.ask([task.request])
        raise ConfigError(f"no task {number} is over; ask for it in words")

    def take_lease(self, who: str, *, over: bool = False) -> int | None:
        """Take the lease to drive by hand; see `DriveLease.take`. The running task waits."""
        who = printable(who, _LONGEST_NAME) or SOMEBODY
        with self._orders:
            before = self.lease.holder
            link = self.lease.take(who, over=over)
            if link is None:
                return None
            self._goes_on = True
        self.log.write("wheel", f"{who} drives" + (f" instead of {before}" if before else ""))
        return link

    def release_lease(self, link: int, *, given_back: bool) -> None:
        """End the lease of a link.

        Args:
            link: Number of the link; without the lease nothing happens.
            given_back: Whether the driver gave the lease back, so that the running task goes on.
                Otherwise the link was lost, and the robot rests until somebody asks it to go on,
                since it may be that nobody is looking.
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
        self.log.write("wheel", f"{who} drives no more{lost}")

    def on_step(self, step: Step) -> None:
        """Keep the newest step, where the base was and when."""
        now = self._now()
        with self._lock:
            if self._step is None:
                self._first_frame = step.frame_number
            self._step = step
            if step.scores is not None:
                self._scored = step
            self._track.add(step.T_map_base[:2, 3])
            self._rate.add(now)
            changed, self._activity = step.activity != self._activity, step.activity
        if step.goal:
            self.arrival = None
        self.candidate = candidate_of(step, self.candidate)
        if changed:
            self.log.write("activity", step.activity)

    def on_goal(self, report: GoalReport) -> None:
        """End the task that asked for this goal; an arrival is kept for people to judge."""
        task = self.queue.report(report)
        if task is not None and report.outcome is Outcome.ARRIVED:
            picture = self.robot.picture_of(report)
            why_not = "" if picture else self._why_no_picture(report.candidates)
            self.arrival = Arrival(task.number, report, picture, why_not)
        self.log.write("ended", f"{report.headline}: {report.reason}", report.outcome)

    def newest_step(self) -> Step | None:
        """The newest step; None before the first."""
        return self._step

    def scored_step(self) -> Step | None:
        """The newest step that searched for something on this map; None before."""
        return self._scored

    def position(self) -> tuple[float, float, float] | None:
        """Position of the base, x, y, z in `map` [m]; None before the first step."""
        if (step := self._step) is None:
            return None
        x, y, z = (round(float(value), 3) for value in step.T_map_base[:3, 3])
        return x, y, z

    def track(self) -> NDArray[np.float64]:
        """Where the base was, (N, 2) x, y in `map` [m], every few centimetres."""
        with self._lock:
            return self._track.xy.copy()

    def step_rate(self) -> float:
        """Rate of the steps over the last seconds, lower while none comes [1/s]."""
        with self._lock:
            return self._rate.rate(self._now()) or 0.0


def printable(text: str, longest: int) -> str:
    """The first `longest` printable letters of a text, without control codes of terminals."""
    return "".join(letter for letter in text if letter.isprintable()).strip()[:longest]
