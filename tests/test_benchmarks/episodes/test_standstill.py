"""Which failed searches count as stuck."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.episodes import run as runs
from benchmarks.episodes.run import LAST, RADIUS, enclosing_radius, is_stuck
from sim_stubs.scoring.success import Verdict
from vizbot.config import Config
from vizbot.core.observer import GoalReport, Outcome

far = st.floats(-200, 200)
near = st.floats(-3, 3)


def circle(radius, count=LAST + 1, centre=(7.0, -3.0)):
    angles = np.linspace(0, 2 * np.pi, count)
    return np.array(centre) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def limited(xy):
    return is_stuck(Outcome.GAVE_UP, at_limit=True, xy=np.asarray(xy, float))


def test_a_search_that_the_robot_ends_since_nothing_brings_it_on_is_stuck_wherever_it_was():
    across_the_house = np.column_stack([np.linspace(0, 12, 400), np.zeros(400)])
    assert is_stuck(Outcome.STUCK, at_limit=False, xy=across_the_house)


@pytest.mark.parametrize("outcome", [each for each in Outcome if each is not Outcome.STUCK])
def test_a_search_that_ends_otherwise_is_not_stuck_however_still_it_stood(outcome):
    assert not is_stuck(outcome, at_limit=False, xy=np.zeros((300, 2)))


def test_an_error_is_no_standstill():
    assert not is_stuck(None, at_limit=True, xy=np.zeros((1000, 2)))


def test_a_search_whose_last_hundred_steps_stay_within_half_a_metre_is_stuck():
    assert limited(circle(RADIUS - 0.001))
    assert not limited(circle(RADIUS + 0.001))


def test_two_frontiers_a_metre_apart_are_one_circle_and_farther_ones_are_none():
    pair = np.tile([[0.0, 0.0], [0.99, 0.0]], (LAST, 1))
    assert limited(pair)
    assert not limited(pair * 1.02)


def test_only_the_steps_before_the_limit_count_and_each_of_them_does():
    drive = np.column_stack([np.linspace(0, 40, 900), np.zeros(900)])
    still = np.repeat(drive[-1:], LAST + 1, axis=0)
    assert limited(np.concatenate([drive, still]))
    away = still.copy()
    away[0] += (2.0, 0.0)  # where the first of the hundred steps began
    assert not limited(np.concatenate([drive, away]))
    away = still.copy()
    away[-1] += (2.0, 0.0)  # where the last of them ended
    assert not limited(np.concatenate([drive, away]))


def test_a_limit_of_fewer_steps_than_that_shows_no_standstill():
    assert limited(np.zeros((LAST + 1, 2)))
    assert not limited(np.zeros((LAST, 2)))


def searched(monkeypatch, outcome, steps, xy, success=False):
    """The result of a search that ends so after steps that lead to these places."""

    def drive(pipeline, devices, goals, max_steps):
        pipeline.steps += steps
        return [GoalReport("sofa", outcome, "whatever was said", ())]

    class Recorder(SimpleNamespace):
        def xy(self):
            return np.concatenate([np.zeros((7, 2)), xy])

    monkeypatch.setattr(runs, "drive_to_all", drive)
    monkeypatch.setattr(runs, "nearest_path_length", lambda world, text: 4.0)
    monkeypatch.setattr(
        runs, "judge", lambda world, text, *, stopped: Verdict(success, 5.0, success, "")
    )
    pipeline = SimpleNamespace(steps=7, goal=lambda text: text)
    recorder = Recorder(
        world=None, path_length=lambda: 9.0, said_seen=None, floor=SimpleNamespace(share=0.5)
    )
    devices = SimpleNamespace(clock=SimpleNamespace(now=lambda: 0.0))
    return runs._search_goal("sofa", pipeline, devices, recorder, Config())


STILL = np.full((1001, 2), 3.0)


@pytest.mark.parametrize(
    ("outcome", "steps", "xy", "stuck"),
    [
        (Outcome.STUCK, 40, STILL[:41], True),
        (Outcome.GAVE_UP, 1000, STILL, True),
        (Outcome.GAVE_UP, 999, STILL[:1000], False),  # it ended for another reason
        (Outcome.NOT_FOUND, 1000, STILL, False),  # by a decision
        (Outcome.ARRIVED, 1000, STILL, False),  # wrongly, but by a decision
        (Outcome.GAVE_UP, 1000, np.cumsum(np.full((1001, 2), 0.1), axis=0), False),
    ],
)
def test_an_episode_that_failed_keeps_whether_it_was_stuck(monkeypatch, outcome, steps, xy, stuck):
    assert searched(monkeypatch, outcome, steps, xy).stuck is stuck


def test_what_was_reached_was_not_stuck(monkeypatch):
    assert searched(monkeypatch, Outcome.ARRIVED, 1000, STILL, success=True).stuck is False


def test_a_slow_drive_through_a_room_is_not_stuck():
    assert not limited(np.column_stack([np.linspace(0, 1.2, LAST + 1), np.zeros(LAST + 1)]))


@given(st.lists(st.tuples(near, near), min_size=1, max_size=40), far, far)
def test_the_circle_holds_every_point_and_no_smaller_one_would(points, x, y):
    xy = np.add(points, (x, y))
    radius = enclosing_radius(xy)
    distances = np.linalg.norm(xy[:, None] - xy, axis=-1)
    # Jung 1901: between half the diameter and that times 2 / sqrt(3).
    assert distances.max() / 2 - 1e-3 <= radius <= distances.max() / np.sqrt(3) + 1e-3
