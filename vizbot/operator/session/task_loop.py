"""The robot's loop while people may ask for something at any time."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack

from sim_stubs.clock import SimulatedClock
from vizbot.config import ObjectNavConfig
from vizbot.core.interfaces import Clock
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP
from vizbot.mission import SETTLING
from vizbot.objectnav.tasks import Goal, Task, Waypoint
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_queue import QueuedTask
from vizbot.operator.session.twist_mux import TwistMux
from vizbot.pipeline import Pipeline

_IDLE = 0.3
"""Between two looks around while there is nothing to do [s]."""
_HAND_PERIOD = 0.02
"""Between two looks at what is told by hand, on the wall clock [s]."""


def run_tasks(
    pipeline: Pipeline,
    clock: Clock,
    base: TwistMux | None,
    session: OperatorSession,
    config: ObjectNavConfig,
) -> None:
    """Do what is asked for, one task after another, until the session is closed or the camera ends.

    While nothing is asked for, and while somebody drives by hand, the robot maps what it sees.
    Without a base that is all, and what is asked for is looked up on the map.

    Raises:
        DeviceError: a device is gone; the base has been told to stop.
    """
    running: int | None = None
    task: Goal | Waypoint | Task = Task.MAP
    steps = 0
    pace = _pace(clock)
    with ExitStack() as ending:
        if base is not None:
            ending.callback(base.rest)
            ending.callback(clock.repeat(_by_hand(clock, base)))
        ending.callback(_refuse_jobs, session)
        while not session.closed.is_set():
            session.begin_step()
            if not session.jobs.empty():
                session.jobs.get()[0](pipeline)
            asked = session.queue.current()
            number = None if asked is None else asked.number
            if number != running:
                running, steps, task = number, 0, _task(pipeline, asked)
            if base is None:
                if asked is not None:
                    _look_up(pipeline, session, task)
                elif pipeline.tick(Task.MAP) is None:
                    return
                continue
            if asked is not None and asked.called_off:
                _end(pipeline, clock, base, session, asked, task, (Outcome.GAVE_UP, asked.reason))
                continue
            by_hand = session.lease.holder is not None
            waits = asked is None or session.stopped.is_set() or by_hand
            if waits and not by_hand:
                clock.sleep(_IDLE)
            step = pipeline.tick(Task.MAP if waits else task)
            if step is None:
                return
            pace()
            if asked is None or waits:
                continue
            steps += 1
            explores = task is Task.EXPLORE
            most = config.max_exploration_steps if explores else config.max_steps
            if step.ended is not None:
                _end(pipeline, clock, base, session, asked, task, step.ended)
            elif steps >= most:
                gave_up = (Outcome.GAVE_UP, f"not done within {most} steps")
                _end(pipeline, clock, base, session, asked, task, gave_up)


def _refuse_jobs(session: OperatorSession) -> None:
    """Nobody waits for a run that is over."""
    while not session.jobs.empty():
        session.jobs.get()[1].cancel()


def _task(pipeline: Pipeline, queued: QueuedTask | None) -> Goal | Waypoint | Task:
    if queued is None:
        return Task.MAP
    return pipeline.goal(queued.request) if isinstance(queued.request, str) else queued.request


def _look_up(pipeline: Pipeline, session: OperatorSession, task: Goal | Waypoint | Task) -> None:
    if isinstance(task, Goal):
        pipeline.look_up(task)
    else:
        session.queue.finish(Outcome.GAVE_UP, "there is no base to drive")


def _end(
    pipeline: Pipeline,
    clock: Clock,
    base: TwistMux,
    session: OperatorSession,
    asked: QueuedTask,
    task: Goal | Waypoint | Task,
    ended: tuple[Outcome, str],
) -> None:
    """Come to rest, then tell what became of it."""
    base.drive(STOP)
    clock.sleep(SETTLING)
    if isinstance(task, Goal):
        pipeline.report(task, *ended)
    else:
        session.queue.finish(*ended, session.position())
        session.write_end(asked.text, *ended)


def _by_hand(clock: Clock, base: TwistMux) -> Callable[[], None]:
    """What is repeated beside the loop: in lockstep once a period, else every 20 ms."""
    if isinstance(clock, SimulatedClock):
        return base.hold

    def hold() -> None:
        base.hold()
        clock.sleep(_HAND_PERIOD)

    return hold


def _pace(clock: Clock) -> Callable[[], None]:
    """Keep simulated time from running ahead of people's; the wall clock does not."""
    behind = time.monotonic() - clock.now()

    def wait() -> None:
        nonlocal behind
        ahead = clock.now() + behind - time.monotonic()
        if ahead > 0.0:
            time.sleep(ahead)
        else:
            behind -= ahead

    return wait
