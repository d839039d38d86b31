"""What the robot is asked to do, in order, and what became of it."""

import numpy as np
import pytest

from vizbot.core.errors import ConfigError
from vizbot.core.observer import Candidate, GoalReport, Outcome
from vizbot.operator.session.task_queue import MOST_WAITING, TaskQueue


def texts(agenda):
    return [errand.text for errand in agenda.errands()]


def test_goals_come_in_the_order_told_each_with_its_outcome():
    agenda = TaskQueue()
    agenda.add(["sofa", "bed"])
    assert agenda.current().text == "sofa"
    found = Candidate(np.array([1.0, 2.0, 0.5]), 0.6, 0, np.array([0, 0, 16, 16]))
    agenda.report(GoalReport("sofa", Outcome.ARRIVED, "seen from near by", (found,)))
    assert agenda.current().text == "bed"
    agenda.report(GoalReport("bed", Outcome.GAVE_UP, "not done within 9 steps", (found,)))
    assert agenda.current() is None
    sofa, bed = agenda.errands()
    assert (sofa.outcome, sofa.position) == (Outcome.ARRIVED, (1.0, 2.0, 0.5))
    assert (bed.outcome, bed.position) == (Outcome.GAVE_UP, None)
    assert bed.reason == "not done within 9 steps"


def test_what_is_asked_for_at_once_takes_over_and_what_waits_stays():
    agenda = TaskQueue()
    agenda.add(["sofa", "bed"])
    assert not agenda.current().called_off
    agenda.add(["sink"], at_once=True)
    running = agenda.current()
    assert running.text == "sofa" and running.called_off
    agenda.finish(Outcome.GAVE_UP, running.reason)
    assert agenda.current().text == "sink"
    assert texts(agenda) == ["sofa", "sink", "bed"]


def test_all_is_called_off_at_once():
    agenda = TaskQueue()
    agenda.add(["sofa", "bed"])
    agenda.current()
    agenda.call_all_off("stopped by ann")
    assert agenda.current().called_off
    agenda.finish(Outcome.GAVE_UP, agenda.current().reason)
    assert agenda.current() is None
    assert {errand.reason for errand in agenda.errands()} == {"stopped by ann"}
    assert sorted(texts(agenda)) == ["bed", "sofa"]


def test_a_report_of_something_else_ends_nothing():
    agenda = TaskQueue()
    agenda.add(["sofa"])
    agenda.current()
    agenda.report(GoalReport("bed", Outcome.LOCATED, "", ()))
    assert agenda.current().text == "sofa"


def test_too_many_goals_are_refused():
    agenda = TaskQueue()
    agenda.add(["sofa"] * MOST_WAITING)
    with pytest.raises(ConfigError, match="are waiting already"):
        agenda.add(["bed"])


def test_of_what_is_over_the_last_hundred_are_remembered():
    agenda = TaskQueue()
    agenda.add([f"goal {n}" for n in range(60)])
    for _ in range(60):
        agenda.current()
        agenda.finish(Outcome.ARRIVED, "")
    agenda.add([f"goal {n}" for n in range(60, 120)])
    for _ in range(60):
        agenda.current()
        agenda.finish(Outcome.ARRIVED, "")
    assert texts(agenda) == [f"goal {n}" for n in range(20, 120)]
