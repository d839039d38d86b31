"""What the guard on progress takes for progress, and what it does without any."""

import numpy as np
import pytest

from nav.navigator import Navigation
from vizbot.behaviours.progress_guard import BARRED, MOST, PATIENCE, REASON, ProgressGuard
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, Twist
from vizbot.objectnav.tasks import Decision, Goal, ShortMove, Task, Waypoint

GOAL = Goal("yellow chair", np.array([1.0, 0.0], np.float32), 0.3)
AHEAD = Twist(0.2, 0.0)
FRAME = 0.25


class Search:
    """A guard that is asked once a frame, and what it says."""

    def __init__(self, task=GOAL):
        self.guard, self.task, self.now = ProgressGuard(), task, 0.0
        self.said, self.area, self.pose = [], 1.0, planar(0.0, 0.0, 0.0)

    def step(self, decision, aim=None, seconds=FRAME):
        self.now += seconds
        aim_xy = None if aim is None else np.array(aim)
        said = self.guard.instead_of(decision, self.task, aim_xy, self.pose, self.area, self.now)
        if said is not decision:
            self.said.append((self.now, said))
        return said

    def go(self, seconds, aim=(3.0, 0.0), way=lambda t: 3.0, exploring=True):
        """Be on the way to an aim; `way` says what is left of it after so many seconds."""
        for t in np.arange(0.0, seconds, FRAME):
            self.step(on_way(way(t), aim, exploring), aim)

    def wait(self, seconds, decision=None):
        for _ in np.arange(0.0, seconds, FRAME):
            self.step(decision or Decision(STOP, "blind, standing still"))

    @property
    def left_alone(self):
        return self.guard.barred(self.now, exploring=True).tolist()


@pytest.fixture
def search():
    return Search()


def on_way(distance, aim, exploring=True):
    path = np.array([[0.0, 0.0], aim])
    navigation = Navigation(AHEAD, path, 0, np.array(aim), distance, arrived=False)
    return Decision(AHEAD, "exploring", navigation, exploring)


def test_an_aim_of_which_nothing_comes_is_left_alone_for_a_while(search):
    search.go(PATIENCE - 1.0)
    assert not search.said
    search.go(2.0)
    [(at, said)] = search.said
    assert at == pytest.approx(PATIENCE + FRAME)
    assert said.twist == STOP and said.ended is None
    assert search.left_alone == [[3.0, 0.0]]
    search.now += BARRED
    assert search.left_alone == []


def test_what_is_left_alone_stays_where_it_was_while_the_robot_goes_to_something_beside_it(search):
    search.go(PATIENCE + 1.0)
    assert search.left_alone == [[3.0, 0.0]]
    search.go(2.0, aim=(3.0, 0.6))
    assert search.left_alone == [[3.0, 0.0]]
    search.go(PATIENCE, aim=(3.0, 0.6))
    assert search.left_alone == [[3.0, 0.0], [3.0, 0.6]]


@pytest.mark.parametrize("task", (GOAL, Task.EXPLORE, Waypoint(3.0, 0.0)))
def test_the_third_time_the_task_ends_with_its_reason(task):
    search = Search(task)
    search.go(MOST * PATIENCE + 2.0)
    said = [each for _, each in search.said]
    assert [each.ended is None for each in said[:MOST]] == [True] * (MOST - 1) + [False]
    outcome = Outcome.STUCK if task is GOAL else Outcome.GAVE_UP
    assert said[MOST - 1].ended == (outcome, REASON) and said[MOST - 1].twist == STOP


def test_less_way_than_ever_before_is_progress_and_the_same_again_is_none(search):
    search.go(40.0, way=lambda t: 3.0 - 0.03 * t)  # 0.3 m in 10 s
    assert not search.said
    search.go(40.0, way=lambda t: 3.0 - 0.03 * t)
    assert search.said


def test_floor_that_is_newly_seen_is_progress(search):
    for _ in range(10):
        search.area += 0.11
        search.go(10.0)
    assert not search.said
    for _ in range(10):
        search.area += 0.001
        search.go(10.0)
    assert search.said


def test_aims_that_alternate_are_no_new_ones_until_a_minute_later(search):
    for _ in range(4):
        search.go(5.0, aim=(3.0, 0.0))
        search.go(5.0, aim=(0.0, 3.0))
    assert search.said
    search = Search()
    search.go(10.0, aim=(3.0, 0.0))
    for y in range(2, 10):  # each of these is another one
        search.go(10.0, aim=(0.0, 2.0 * y))
    search.go(10.0, aim=(3.0, 0.0))
    assert not search.said


def test_a_round_of_aims_that_takes_longer_than_a_minute_ends_as_well(search):
    aims = [(3.0 * n, 0.0) for n in range(1, 9)]  # 8 aims for 10 s each
    for _ in range(10):
        for aim in aims:
            search.go(10.0, aim=aim)
    assert any(said.ended is not None for _, said in search.said)


def test_a_longer_way_after_the_map_closed_the_former_one_is_begun_anew_but_not_for_ever(search):
    search.go(5.0, way=lambda t: 1.0)
    search.go(25.0, way=lambda t: 12.0 - 0.4 * t)
    assert not search.said
    for _ in range(5):
        search.go(10.0, way=lambda t: 12.0 - 0.4 * t)
    assert search.said


def test_looking_around_on_the_spot_is_progress_once():
    turning = Decision(Twist(0.0, 0.1), "looking around")
    search = Search()
    for degrees in np.arange(0.0, 360.0, 2.0):  # 45 s
        search.pose = planar(0.0, 0.0, np.radians(degrees))
        search.step(turning)
    assert not search.said
    for degrees in np.arange(0.0, 360.0, 2.0):
        search.pose = planar(0.0, 0.0, np.radians(degrees))
        search.step(turning)
    assert search.said


def test_a_behaviour_that_demands_something_goes_on_while_its_aim_is_dropped(search):
    search.go(1.0)
    search.wait(PATIENCE, Decision(STOP, "blind, standing still"))
    assert search.said == [] and search.left_alone == [[3.0, 0.0]]


def test_waiting_for_a_person_and_the_time_of_others_do_not_count(search):
    search.go(1.0)
    search.wait(100.0, Decision(STOP, "waiting to be put down", idle=True))
    search.guard.rest()  # somebody drives
    search.now += 100.0
    search.go(10.0)
    assert not search.said and not search.left_alone


def test_one_frame_that_takes_long_is_not_the_robots_fault(search):
    search.go(1.0)
    for _ in range(10):
        search.step(on_way(3.0, (3.0, 0.0)), (3.0, 0.0), seconds=20.0)
    assert not search.said


def test_frames_within_a_step_count(search):
    search.go(1.0)
    for _ in range(60):
        search.now += FRAME
        search.guard.elapse(search.now)
    search.go(0.5)
    assert search.said


def test_another_task_begins_anew(search):
    search.go(MOST * PATIENCE - 1.0)
    search.task, search.said = Task.EXPLORE, []
    search.go(PATIENCE - 1.0)
    assert not search.said and not search.left_alone


@pytest.mark.parametrize("end", ["stuck", "ended", "called off"])
def test_the_same_task_asked_for_again_begins_anew(end):
    search = Search(Task.COME_BACK)
    search.go(MOST * PATIENCE + FRAME if end == "stuck" else 2 * PATIENCE + 2.0)
    if end == "ended":
        search.step(Decision(STOP, "arrived", ended=(Outcome.ARRIVED, "")))
    elif end == "called off":
        search.guard.close()
    else:
        assert search.said[-1][1].ended is not None
    search.said.clear()
    search.go(MOST * PATIENCE - 1.0)
    assert [said.ended for _, said in search.said] == [None] * (MOST - 1)


def test_where_nothing_else_is_left_what_was_left_alone_is_tried_again(search):
    search.go(PATIENCE + 1.0)
    in_vain = Decision(STOP, "nothing left to try", ended=(Outcome.NOT_FOUND, "seen"))
    again = search.step(in_vain)
    assert again.ended is None and search.left_alone == []
    assert search.step(in_vain) is in_vain


def test_a_short_move_that_gets_nowhere_ends_at_once_and_one_that_does_is_left_to_end():
    search = Search(ShortMove(forward=5.0))
    for t in np.arange(0.0, 28.0, FRAME):
        search.step(Decision(AHEAD, "driving ahead", way_left=5.0 - 0.17 * t))
    assert not search.said
    search = Search(ShortMove(forward=5.0))
    for _ in range(70):
        search.step(Decision(AHEAD, "driving ahead", way_left=5.0))
    assert search.said[0][1].ended == (Outcome.GAVE_UP, "the robot does not move")


def test_a_frontier_that_blinds_the_robot_twice_is_named_and_a_place_is_not(search):
    assert search.guard.blinding_frontier() is None
    search.go(1.0, aim=(2.0, 0.0))
    assert search.guard.blinding_frontier() is None
    assert search.guard.blinding_frontier().tolist() == [2.0, 0.0]
    search.go(1.0, aim=(0.0, 2.0), exploring=False)
    assert [search.guard.blinding_frontier() for _ in range(3)] == [None] * 3
