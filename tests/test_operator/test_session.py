"""What operators see of a run: where the base was, how fast it steps, what it warns of."""

import logging
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.helpers.served import step
from vizbot.core.errors import ConfigError
from vizbot.core.observer import Outcome
from vizbot.operator.figures.steps import StepRate
from vizbot.operator.session.notifications import log_warnings
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.verdicts import ApproachedCandidate, candidate_of


def test_the_track_has_places_a_few_centimetres_apart(session):
    assert session.track().shape == (0, 2)
    for index in range(21):
        session.on_step(step(index, x=0.02 * index))
    track = session.track()
    assert (np.diff(track[:, 0]) > 0.05).all() and len(track) == 7
    session.leave_map()
    assert session.track().shape == (0, 2) and session.position() is None


def test_the_step_rate_is_that_of_the_last_seconds_and_falls_when_steps_stop():
    time = SimpleNamespace(now=100.0)
    session = OperatorSession(now=lambda: time.now)
    assert session.step_rate() == 0.0
    for index in range(100):
        time.now += 0.1
        session.on_step(step(index))
    assert session.step_rate() == pytest.approx(10.0, abs=0.3)
    time.now += 5.0
    assert session.step_rate() == pytest.approx(5.0, abs=0.3)


def test_a_goal_that_is_too_long_is_refused_in_one_line(session):
    with pytest.raises(ConfigError, match="a goal has at most 200 letters"):
        session.ask(["a" * 201])
    assert session.queue.tasks() == []


def going_up_to(index, xy, goal="sofa", **changes):
    return replace(step(index), goal=goal, candidate_xy=np.array(xy), **changes)


def test_what_the_robot_goes_up_to_is_one_thing_while_the_point_of_it_moves():
    first = candidate_of(going_up_to(3, (2.0, 1.0)), None)
    moved = candidate_of(going_up_to(4, (2.5, 1.0)), replace(first, confirmed=True))
    assert (moved.number, moved.confirmed) == (3, True) and moved.place_xy[0] == 2.5
    assert candidate_of(going_up_to(5, (4.0, 1.0)), moved).number == 5
    other = candidate_of(going_up_to(5, (2.5, 1.0), goal="bed"), moved)
    assert (other.number, other.confirmed) == (5, False)


def test_who_explores_or_has_arrived_goes_up_to_nothing():
    first = candidate_of(going_up_to(3, (2.0, 1.0)), None)
    assert candidate_of(step(4), first) is None
    arrived = going_up_to(4, (2.0, 1.0), ended=(Outcome.ARRIVED, "near by"))
    assert candidate_of(arrived, first) is None


@pytest.mark.parametrize(
    ("goal", "named"),
    [("sofa", "a sofa"), ("armchair", "an armchair"), ("glass", "a glass"), ("chairs", "chairs"),
     ("An oven", "An oven"), ("my desk", "my desk"), ("the kitchen", "the kitchen")],
)  # fmt: skip
def test_it_is_named_as_people_name_it(goal, named):
    assert ApproachedCandidate(1, goal, np.zeros(2)).headline == f"I see something like {named}"


TEN_A_SECOND = [0.1 * n for n in range(101)]


@pytest.mark.parametrize(
    ("stamps", "later", "expected"),
    [(TEN_A_SECOND[:-1], 0.0, 10.0), ([*range(9), *(9.0 + t for t in TEN_A_SECOND)], 0.0, 10.0),
     ([0.0, 20.0, 40.0], 0.0, 0.05), ([0.0, 0.5, 1.0], 19.0, 0.1),
     ([3.0], 0.0, None), ([3.0], 1.0, None)],
)  # fmt: skip
def test_the_rate_is_the_mean_of_the_last_five_seconds_or_of_less(stamps, later, expected):
    rate = StepRate()
    for stamp in stamps:
        rate.add(stamp)
    found = rate.rate(stamps[-1] + later)
    assert found is None if expected is None else found == pytest.approx(expected)


def test_people_are_shown_our_warnings_once_and_nobody_elses(session):
    with log_warnings(session):
        logging.getLogger("drivers.realsense.camera").warning(
            "the camera is gone: %s", "plug it in"
        )
        logging.getLogger("vizbot.perception.sensor_reader").error("the camera is gone: plug it in")
        logging.getLogger("mapping.slam.slam").info("tracking")
        logging.getLogger("uvicorn.error").warning("Invalid HTTP request received.")
        logging.getLogger("nav").warning("no way")
    logging.getLogger("nav").warning("nobody listens any more")
    assert [(line.code, line.text) for line in session.log.lines()] == [
        ("warning", "the camera is gone: plug it in"),
        ("warning", "no way"),
    ]
