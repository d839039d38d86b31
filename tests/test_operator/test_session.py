"""What operators see of a run: where the base was, how fast it steps."""

import numpy as np
import pytest

from tests.helpers.served import step
from vizbot.core.errors import ConfigError
from vizbot.operator.session.session import OperatorSession


class Time:
    """A clock that stands until it is set."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def test_the_track_has_places_a_few_centimetres_apart():
    session = OperatorSession()
    assert session.track().shape == (0, 2)
    for index in range(21):
        session.on_step(step(index, x=0.02 * index))
    track = session.track()
    assert (np.diff(track[:, 0]) > 0.05).all() and len(track) == 7
    session.leave_map()
    assert session.track().shape == (0, 2) and session.position() is None


def test_the_step_rate_is_that_of_the_last_seconds_and_falls_when_steps_stop():
    time = Time()
    session = OperatorSession(time)
    assert session.step_rate() == 0.0
    for index in range(100):
        time.now += 0.1
        session.on_step(step(index))
    assert session.step_rate() == pytest.approx(10.0, abs=0.3)
    time.now += 5.0
    assert session.step_rate() == pytest.approx(5.0, abs=0.3)


def test_a_goal_that_is_too_long_is_refused_in_one_line():
    session = OperatorSession()
    with pytest.raises(ConfigError, match="a goal has at most 200 letters"):
        session.ask(["a" * 201])
    assert session.queue.tasks() == []
