"""What the robot is asked to do, in order, and what became of it."""

import numpy as np
import pytest

from vizbot.core.errors import ConfigError
from vizbot.core.observer import Candidate, Effort, GoalReport, Outcome
from vizbot.objectnav.tasks import Task, Waypoint
from vizbot.operator.session.task_queue import MOST_WAITING, TaskQueue


@pytest.fixture
def queue():
    return TaskQueue()


def texts(queue):
    return [task.text for task in queue.tasks()]


def test_goals_come_in_the_order_told_each_with_its_outcome(queue):
    queue.add(["sofa", "bed"])
    assert queue.current().text == "sofa"
    found = Candidate(np.array([1.0, 2.0, 0.5]), 0.6, 0, np.array([0, 0, 16, 16]))
    effort = Effort(50.0, 12.3)
    queue.report(GoalReport("sofa", Outcome.ARRIVED, "seen from near by", (found,), effort=effort))
    assert queue.current().text == "bed"
    queue.report(GoalReport("bed", Outcome.GAVE_UP, "not done within 9 steps", (found,)))
    assert queue.current() is None
    sofa, bed = queue.tasks()
    assert (sofa.outcome, sofa.position) == (Outcome.ARRIVED, (1.0, 2.0, 0.5))
    assert (sofa.effort, bed.effort) == (effort, None)
    assert (bed.outcome, bed.position) == (Outcome.GAVE_UP, None)
    assert bed.reason == "not done within 9 steps"


def test_what_is_asked_for_at_once_takes_over_and_what_waits_stays(queue):
    queue.add(["sofa", "bed"])
    assert not queue.current().called_off
    queue.add(["sink"], at_once=True)
    running = queue.current()
    assert running.text == "sofa" and running.called_off
    queue.finish(Outcome.GAVE_UP, running.reason)
    assert queue.current().text == "sink"
    assert texts(queue) == ["sofa", "sink", "bed"]


def test_all_is_called_off_at_once(queue):
    queue.add(["sofa", "bed"])
    queue.current()
    queue.call_all_off("stopped by ann")
    assert queue.current().called_off
    queue.finish(Outcome.GAVE_UP, queue.current().reason)
    assert queue.current() is None
    assert {task.reason for task in queue.tasks()} == {"stopped by ann"}
    assert sorted(texts(queue)) == ["bed", "sofa"]


def test_a_report_of_something_else_ends_nothing(queue):
    queue.add(["sofa"])
    queue.current()
    queue.report(GoalReport("bed", Outcome.LOCATED, "", ()))
    assert queue.current().text == "sofa"


def test_too_many_goals_are_refused(queue):
    queue.add(["sofa"] * MOST_WAITING)
    with pytest.raises(ConfigError, match="are waiting already"):
        queue.add(["bed"])


def test_of_what_is_over_the_last_hundred_are_remembered(queue):
    for first in (0, 60):
        queue.add([f"goal {n}" for n in range(first, first + 60)])
        for _ in range(60):
            queue.current()
            queue.finish(Outcome.ARRIVED, "")
    assert texts(queue) == [f"goal {n}" for n in range(20, 120)]


def test_some_tasks_are_called_off_and_the_others_stay(queue):
    queue.add(["Sofa", "bed", "sofa", Task.DOCK])
    assert queue.current().text == "Sofa"
    called_off = queue.call_off(lambda task: task.text.casefold() == "sofa", "called off by ann")
    assert [task.number for task in called_off] == [1, 3]
    assert queue.current().called_off
    assert [(task.text, task.outcome) for task in queue.tasks()] == [
        ("sofa", Outcome.GAVE_UP), ("Sofa", None), ("bed", None), ("dock", None),
    ]  # fmt: skip
    assert queue.call_off(lambda task: task.text == "lamp", "called off by ann") == []


def test_only_what_waits_is_moved_to_the_front(queue):
    queue.add(["sofa", "bed", "sink"])
    queue.current()
    assert queue.move_to_front(3)
    assert texts(queue) == ["sofa", "sink", "bed"]
    assert not queue.move_to_front(1)
    assert texts(queue) == ["sofa", "sink", "bed"]


def test_places_on_a_map_that_was_left_cannot_be_asked_for_again(queue):
    queue.add([Waypoint(1.0, 2.0), "bed"])
    for _ in range(2):
        queue.current()
        queue.finish(Outcome.ARRIVED, "", (1.0, 2.0, 0.0))
    queue.forget_places()
    assert [(task.text, task.position) for task in queue.tasks()] == [("bed", None)]
