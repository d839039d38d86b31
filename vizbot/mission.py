"""Missions: several goals one after another, and the outcome of each."""

from __future__ import annotations

from collections.abc import Sequence

from vizbot.core.interfaces import Devices
from vizbot.core.observer import GoalReport, Outcome
from vizbot.core.types import STOP
from vizbot.objectnav.tasks import Goal, Task
from vizbot.pipeline import Pipeline

SETTLING_TIME = 0.5
"""Time that the base has to come to rest before a goal is reported [s]."""


def drive_to_all(
    pipeline: Pipeline, devices: Devices, goals: Sequence[Goal], max_steps: int
) -> list[GoalReport]:
    """Drive to the goals in the order given; a failed one does not end the mission.

    The robot gives a goal up after `max_steps` steps.

    Raises:
        DeviceError: a device is gone or silent; the base was stopped first.
    """
    assert devices.base is not None
    reports = []
    for goal in goals:
        try:
            outcome, reason = _drive(pipeline, goal, max_steps)
        finally:
            devices.base.drive(STOP)
        devices.clock.sleep(SETTLING_TIME)
        reports.append(pipeline.report(goal, outcome, reason))
    return reports


def explore(pipeline: Pipeline, devices: Devices, max_steps: int) -> tuple[Outcome, str]:
    """Drive until nothing is left to see.

    Returns:
        `EXPLORED`, or `GAVE_UP` after `max_steps` and where the base does not drive; and why.

    Raises:
        DeviceError: a device is gone or silent; the base was stopped first.
    """
    assert devices.base is not None
    try:
        return _drive(pipeline, Task.EXPLORE, max_steps)
    finally:
        devices.base.drive(STOP)


def watch(pipeline: Pipeline, goals: Sequence[Goal]) -> list[GoalReport]:
    """Map what a recording shows, driving nothing, then look every goal up on the finished map."""
    while pipeline.tick(Task.MAP) is not None:
        pass
    pipeline.finish()
    return [pipeline.look_up(goal) for goal in goals]


def advise(pipeline: Pipeline, goals: Sequence[Goal], max_steps: int) -> list[GoalReport]:
    """Compute commands with a live camera and no base, then look every goal up.

    `max_steps` is the number of steps for all goals together.
    """
    for goal in goals:
        _drive(pipeline, goal, max_steps // len(goals))
    pipeline.finish()
    return [pipeline.look_up(goal) for goal in goals]


def _drive(pipeline: Pipeline, task: Goal | Task, max_steps: int) -> tuple[Outcome, str]:
    for _ in range(max_steps):
        step = pipeline.tick(task)
        if step is None:
            return Outcome.GAVE_UP, "the camera has ended"
        if step.ended is not None:
            return step.ended
        if step.question is not None:  # nobody is there to be asked
            return Outcome.GAVE_UP, step.question.unanswered
    return Outcome.GAVE_UP, f"not done within {max_steps} steps"
