"""What the base feels comes before the search: what the robot does then."""

import re

import numpy as np
import pytest

from tests.helpers.scripted_robot import PERIOD, ScriptedBase, ticks, until_it_ends
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, BaseMode, Button, Tracking
from vizbot.objectnav.tasks import Task

CLIFF = {"cliffs": (False, True, False, False), "mode": BaseMode.PASSIVE}


def test_a_robot_that_is_lifted_does_not_know_where_it_is(pipeline_on):
    hangs = {"wheel_drops": (True, True)}
    base = ScriptedBase(feels={3: hangs, 4: {"wheel_drops": (True, False)}})
    steps = ticks(pipeline_on(base), 5)
    states = [step.estimate.tracking for step in steps]
    assert Tracking.LOST not in states[:3]
    assert states[3] is Tracking.LOST
    assert base.driven[3:] == [STOP, STOP]


def test_a_bump_makes_it_stop_back_off_mark_the_place_and_go_on(pipeline_on):
    base = ScriptedBase(feels={2: {"bump_left": True, "bump_right": True}})
    steps = ticks(pipeline_on(base), 12)
    backing = [step.activity == "backing off after a bump" for step in steps]
    assert backing.index(True) == 2
    assert base.driven[2] == STOP
    back = [twist.linear for twist, b in zip(base.driven, backing, strict=True) if b][1:]
    assert back and all(speed <= 0.0 for speed in back)
    assert -0.25 < sum(back) * PERIOD < -0.05
    assert not backing[-1]
    touched = (steps[2].T_map_base @ [0.2, 0.0, 0.0, 1.0])[:2]
    grid = steps[-1].grid
    assert grid.occupancy[tuple(grid.to_cells(touched))] == 1.0


@pytest.mark.parametrize(
    ("felt", "named", "marked"),
    [
        ({"virtual_wall": True}, "a virtual wall", True),
        ({"overcurrents": (True, False)}, "a stuck wheel", False),
        ({"overcurrents": (True, False), "bump_left": True, "bump_right": True}, "a bump", True),
    ],
)
def test_a_virtual_wall_and_a_stuck_wheel_are_backed_off_from_as_well(
    pipeline_on, felt, named, marked
):
    base = ScriptedBase(feels={2: felt})
    steps = ticks(pipeline_on(base), 12)
    backing = [step.activity == f"backing off after {named}" for step in steps]
    assert backing.index(True) == 2 and not backing[-1]
    assert sum(backing) > 3
    assert min(twist.linear for twist in base.driven) < -0.05
    ahead = (steps[2].T_map_base @ [0.2, 0.0, 0.0, 1.0])[:2]
    grid = steps[-1].grid
    assert (grid.occupancy[tuple(grid.to_cells(ahead))] == 1.0) == marked


@pytest.mark.parametrize("felt", [{"bump_right": True}, {"virtual_wall": True}, CLIFF])
def test_only_what_was_bumped_into_can_be_forgotten(pipeline_on, felt):
    pipeline = pipeline_on(ScriptedBase(feels={2: felt}), resume_safe=True)
    ticks(pipeline, 6)
    assert pipeline.map.perception.depth_mapper.forget_touched() == ("bump_right" in felt)


def shut_in(pipeline, task, at, touched):
    """Mark a ring of obstacles around the robot, and go on until it ends or tries again."""
    angles = np.arange(0.0, 2 * np.pi, 0.1)
    ring = 0.35 * np.column_stack([np.cos(angles), np.sin(angles)])
    pipeline.map.perception.depth_mapper.mark_obstacle(at, ring, touched=touched)
    step = pipeline.tick(task)
    while step.ended is None and step.activity != "trying again":
        step = pipeline.tick(task)
    return step


@pytest.mark.parametrize("touched", [True, False])
def test_what_is_shut_in_by_bumps_alone_tries_once_more_before_it_ends(pipeline_on, touched):
    pipeline = pipeline_on(ScriptedBase())
    at = pipeline.tick(Task.EXPLORE).T_map_base
    if touched:
        again = shut_in(pipeline, Task.EXPLORE, at, touched)
        assert again.activity == "trying again" and again.why
        assert pipeline.tick(Task.EXPLORE).ended is None
    last = shut_in(pipeline, Task.EXPLORE, at, touched)
    assert last.ended is not None and last.ended[0] is Outcome.EXPLORED
    next_one = shut_in(pipeline, Task.EXPLORE, at, touched)
    assert next_one.activity == ("trying again" if touched else last.activity)


@pytest.mark.parametrize(("method", "tries"), [("belief", True), ("paper", False)])
def test_a_search_in_vain_tries_once_more_but_for_that_of_the_paper(pipeline_on, method, tries):
    pipeline = pipeline_on(ScriptedBase(), method=method)
    goal = pipeline.goal("yellow chair")
    step = shut_in(pipeline, goal, pipeline.tick(goal).T_map_base, touched=True)
    assert (step.activity == "trying again") == tries
    assert step.ended is not None or until_it_ends(pipeline, goal, 60)


AT_EDGE = {"cliffs": (True, True, False, False), "mode": BaseMode.PASSIVE}


@pytest.mark.parametrize(
    ("feels", "said"),
    [
        ({3: {"wheel_drops": (False, True)}}, ""),
        ({3: {"battery": 0.08}}, "^the battery is at 8 %; put the robot on its dock$"),
        ({3: {"buttons": frozenset({Button.CLEAN})}}, "Clean"),
        (dict.fromkeys(range(3, 60), AT_EDGE), "resume_safe"),
    ],
    ids=["wheel drop", "battery", "Clean", "an edge where nobody allows it to go on"],
)
def test_what_it_feels_may_end_the_search_at_once_with_the_wheels_stopped(pipeline_on, feels, said):
    base = ScriptedBase(feels=feels)
    *steps, last = ticks(pipeline_on(base), 4)
    assert [step.ended for step in steps] == [None] * 3
    outcome, reason = last.ended
    assert outcome is Outcome.GAVE_UP and re.search(said, reason)
    assert base.driven[-1] == STOP


def test_where_a_person_allows_it_a_robot_that_was_lifted_goes_on_once_it_is_put_down(pipeline_on):
    hangs = {"wheel_drops": (True, True), "mode": BaseMode.PASSIVE}
    base = ScriptedBase(feels={2: hangs, 3: hangs, 4: {"mode": BaseMode.PASSIVE}})
    steps = ticks(pipeline_on(base, resume_safe=True), 7)
    assert [step.activity for step in steps[2:5]] == ["waiting to be put down"] * 3
    assert all(step.ended is None for step in steps)
    assert base.driven[2:5] == [STOP] * 3
    assert "waiting" not in steps[6].activity


def test_who_presses_clean_on_a_lifted_robot_ends_the_search(pipeline_on):
    pressed = {"wheel_drops": (True, True), "buttons": frozenset({Button.CLEAN})}
    pipeline = pipeline_on(ScriptedBase(feels={2: pressed}), resume_safe=True)
    assert "Clean" in ticks(pipeline, 3)[-1].ended[1]


def end_of_exploring(pipeline_on, feels):
    """The last step of a robot that may go on by itself."""
    pipeline = pipeline_on(ScriptedBase(feels=feels), resume_safe=True)
    return next(step for step in (pipeline.tick(Task.EXPLORE) for _ in range(400)) if step.ended)


@pytest.mark.slow
def test_a_robot_that_does_not_obey_since_it_was_lifted_says_so(pipeline_on):
    passive = {"mode": BaseMode.PASSIVE}
    feels = dict.fromkeys(range(1000), passive) | {0: passive | {"wheel_drops": (True, True)}}
    last = end_of_exploring(pipeline_on, feels)
    assert "does not obey since it was lifted" in last.ended[1]


def test_a_robot_that_nobody_puts_down_gives_up(pipeline_on):
    hangs = {"wheel_drops": (True, True), "mode": BaseMode.PASSIVE}
    last = end_of_exploring(pipeline_on, dict.fromkeys(range(1000), hangs))
    assert last.ended[0] is Outcome.GAVE_UP
    assert last.frame.stamp == pytest.approx(60.0, abs=2.0)


def test_in_full_mode_the_cable_of_a_charger_is_waited_for_and_said(pipeline_on):
    plugged = {"plugged_in": True, "mode": BaseMode.FULL}
    base = ScriptedBase(mode=BaseMode.FULL, feels={n: plugged for n in range(4, 8)})
    steps = ticks(pipeline_on(base), 12)
    waiting = [step for step in steps if step.activity.startswith("waiting for the charger")]
    assert waiting and all(step.command == STOP for step in waiting)
    assert steps[-1].ended is None and not steps[-1].activity.startswith("waiting")


def test_it_backs_away_from_its_dock_before_it_does_anything_else(pipeline_on):
    base = ScriptedBase(feels={n: {"docked": True} for n in range(7)})
    steps = ticks(pipeline_on(base, look_around=True), 40)
    leaving = [step.activity == "leaving the dock" for step in steps]
    gone = leaving.index(False, leaving.index(True))
    assert gone > 7 and not any(leaving[gone:])
    assert steps[gone].T_map_base[0, 3] == pytest.approx(-0.5, abs=0.05)
    assert all(twist.angular == 0.0 for twist in base.driven[:gone])


def test_at_an_edge_it_stops_backs_off_once_it_may_marks_the_edge_and_goes_on(pipeline_on):
    cliffs = (False, True, False, False)
    passive = {"cliffs": cliffs, "mode": BaseMode.PASSIVE}
    base = ScriptedBase(feels={2: passive, 3: {"cliffs": cliffs}, 4: {"cliffs": cliffs}})
    steps = ticks(pipeline_on(base, resume_safe=True), 14)
    backing = [step.activity == "backing off after an edge" for step in steps]
    assert backing.index(True) == 2 and not backing[-1]
    assert base.driven[2] == STOP
    back = [twist for twist, b in zip(base.driven, backing, strict=True) if b]
    assert all(twist.linear <= 0.0 and twist.angular == 0.0 for twist in back)
    assert -0.25 < sum(twist.linear for twist in back) * PERIOD < -0.05
    assert all(step.ended is None for step in steps)
    felt = steps[2].T_map_base @ [0.2 * np.cos(0.26), 0.2 * np.sin(0.26), 0.0, 1.0]
    grid = steps[-1].grid
    assert grid.occupancy[tuple(grid.to_cells(felt[:2]))] == 1.0


def test_an_edge_that_cannot_be_left_ends_the_search(pipeline_on):
    at_edge = {"cliffs": (True, True, True, True), "mode": BaseMode.PASSIVE}
    base = ScriptedBase(feels=dict.fromkeys(range(3, 60), at_edge))
    steps = ticks(pipeline_on(base, resume_safe=True), 50)
    ended = [step.ended for step in steps if step.ended is not None]
    assert ended and ended[0][0] is Outcome.GAVE_UP and "edge" in ended[0][1]
    assert all(twist == STOP for twist in base.driven[3:])


def test_a_base_that_obeys_again_soon_does_not_end_the_search(pipeline_on):
    passive = {"mode": BaseMode.PASSIVE}
    base = ScriptedBase(feels={2: passive, 3: passive, 4: passive})
    steps = ticks(pipeline_on(base), 8)
    assert all(step.ended is None for step in steps)
    assert [step.activity for step in steps[2:5]] == ["waiting for the base to obey"] * 3
    assert base.driven[2:5] == [STOP] * 3


def test_a_base_that_does_not_drive_ends_the_search(pipeline_on):
    steps = ticks(pipeline_on(ScriptedBase(mode=BaseMode.PASSIVE)), 17)
    assert [step.ended is None for step in steps[:14]] == [True] * 14
    step = next(step for step in steps if step.ended is not None)
    outcome, reason = step.ended
    assert outcome is Outcome.GAVE_UP and "PASSIVE" in reason


def test_a_robot_that_sees_no_depth_stands_still_and_goes_on_when_it_does(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base)
    camera = pipeline._devices.camera
    camera.distance = 3.0
    while not base.driven or base.driven[-1].linear < 0.1:
        pipeline.tick(Task.EXPLORE)
    camera.distance = 0.0
    steps = [pipeline.tick(Task.EXPLORE) for _ in range(15)]
    assert {(step.activity, step.ended) for step in steps} == {("blind, standing still", None)}
    assert base.driven[-15:] == [STOP] * 15
    camera.distance = 1.2
    assert "blind" not in pipeline.tick(Task.EXPLORE).activity


def test_a_robot_that_sees_no_depth_anywhere_turns_around_once_and_gives_up(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base)
    pipeline._devices.camera.distance = 0.0
    last = until_it_ends(pipeline, Task.EXPLORE)[-1]
    assert last.ended[0] is Outcome.GAVE_UP and "clean the camera" in last.ended[1]
    assert all(twist.linear == 0.0 for twist in base.driven)
    turned = sum(twist.angular for twist in base.driven) * PERIOD
    assert 2 * np.pi - 0.1 < turned < 2 * np.pi + 0.6
    assert last.frame.stamp < 25.0


def test_who_is_lifted_at_an_edge_and_put_down_at_one_has_time_to_get_away_from_it(pipeline_on):
    at_edge = {"cliffs": (True, True, True, True)}
    passive = {"mode": BaseMode.PASSIVE}
    hangs = {"wheel_drops": (True, True)} | passive
    feels = dict.fromkeys(range(3, 43), hangs) | {2: at_edge | passive, 43: passive, 44: at_edge}
    pipeline = pipeline_on(ScriptedBase(feels=feels), resume_safe=True)
    steps = ticks(pipeline, 45)
    assert "edge" in steps[2].activity
    assert [step.ended for step in steps] == [None] * 45
