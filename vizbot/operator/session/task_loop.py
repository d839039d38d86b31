"""The robot's loop during which people may ask for something at any time."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack

from vizbot.config import ObjectNavConfig
from vizbot.core.interfaces import Clock
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP
from vizbot.mission import SETTLING_TIME
from vizbot.objectnav.tasks import Errand, Goal, Task
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_queue import QueuedTask
from vizbot.operator.session.twist_mux import TwistMux
from vizbot.pipeline import Pipeline

_IDLE = 0.3
"""Pause between two steps while there is nothing to do [s]."""
_HAND_PERIOD = 0.02
"""Period of the motion commands of a driver by hand, on the wall clock [s]."""


def run_tasks(
    pipeline: Pipeline,
    clock: Clock,
    base: TwistMux | None,
    session: OperatorSession,
    config: ObjectNavConfig,
) -> None:
    """Run one task after another until the session is closed or the camera ends.

    Without a task, and while somebody drives by hand, the robot maps what it sees. Without a base
    it only maps, and looks goals up on the map.

    Raises:
        DeviceError: a device is gone; the base was commanded to stop.
    """
    running: int | None = None
    task: Errand = Task.MAP
    steps = 0
    pace = _pace(clock)
    with ExitStack() as ending:
        if base is not None:
            ending.callback(base.rest)
            ending.callback(clock.repeat(_by_hand(clock, base)))
        ending.callback(session.jobs.cancel)
        while not session.closed.is_set():
            session.begin_step()
            session.jobs.do_next(pipeline)
            queued = session.queue.current()
            number = None if queued is None else queued.number
            if number != running:
                running, steps, task = number, 0, _task(pipeline, queued)
                pipeline.map.progress.close()
            if base is None:
                if queued is not None:
                    _look_up(pipeline, session, task)
                elif pipeline.tick(Task.MAP) is None:
                    return
                continue
            if queued is not None and queued.called_off:
                _end(pipeline, clock, base, session, queued, task, (Outcome.GAVE_UP, queued.reason))
                continue
            by_hand = session.lease.holder is not None
            waits = queued is None or session.stopped.is_set() or by_hand
            if waits and not by_hand:
                clock.sleep(_IDLE)
            step = pipeline.tick(Task.MAP if waits else task)
            if step is None:
                return
            pace()
            if step.question is not None:
                clock.sleep(_IDLE)
            if queued is None or waits or step.question is not None:
                continue
            steps += 1
            explores = task is Task.EXPLORE
            most = config.max_exploration_steps if explores else config.max_steps
            if step.ended is not None:
                _end(pipeline, clock, base, session, queued, task, step.ended)
            elif steps >= most:
                gave_up = (Outcome.GAVE_UP, f"not done within {most} steps")
                _end(pipeline, clock, base, session, queued, task, gave_up)


def _task(pipeline: Pipeline, queued: QueuedTask | None) -> Errand:
    if queued is None:
        return Task.MAP
    return pipeline.goal(queued.request) if isinstance(queued.request, str) else queued.request


def _look_up(pipeline: Pipeline, session: OperatorSession, task: Errand) -> None:
    if isinstance(task, Goal):
        pipeline.look_up(task)
    else:
        session.queue.finish(Outcome.GAVE_UP, "there is no base to drive")


def _end(
    pipeline: Pipeline,
    clock: Clock,
    base: TwistMux,
    session: OperatorSession,
    queued: QueuedTask,
    task: Errand,
    ended: tuple[Outcome, str],
) -> None:
    """Come to rest, then report how a task has ended."""
    base.drive(STOP)
    clock.sleep(SETTLING_TIME)
    if isinstance(task, Goal):
        pipeline.report(task, *ended)
    else:
        session.queue.finish(*ended, session.position())
        session.log.write_end(queued.text, *ended)


def _by_hand(clock: Clock, base: TwistMux) -> Callable[[], None]:
    """The commands beside the loop: in lockstep once a period, on the wall clock every 20 ms."""
    if clock.simulated:
        return base.hold

    def hold() -> None:
        base.hold()
        clock.sleep(_HAND_PERIOD)

    return hold


def _pace(clock: Clock) -> Callable[[], None]:
    """The pause after each step that keeps simulated time from running ahead of people's."""
    behind = time.monotonic() - clock.now()

    def wait() -> None:
        nonlocal behind
        ahead = clock.now() + behind - time.monotonic()
        if ahead > 0.0:
            time.sleep(ahead)
        else:
            behind -= ahead

    return wait
