"""The robot's loop while people ask, drive by hand and stop."""

import numpy as np
import pytest

from tests.helpers.scripted_robot import ScriptedBase
from vizbot.config import ObjectNavConfig
from vizbot.core.errors import DeviceError
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, Twist
from vizbot.objectnav.tasks import Task, Waypoint
from vizbot.operator.api.state import state_of
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_loop import attend
from vizbot.operator.session.twist_mux import TwistMux

YELLOW = (240, 220, 12)
AHEAD = Twist(0.2, 0.0)


class ServedRun:
    """A robot at a desk; `script` says what people do before each step, by number."""

    def __init__(self, pipeline_on, script, colour=YELLOW, base=True, last=120):
        self.desk = OperatorSession()
        self.body = ScriptedBase()
        self.shared = None
        if base:
            self.shared = TwistMux(self.body, self.desk.wheel, self.desk.stopped)
        self.script, self.last = script, last
        self.steps = []
        self.pipeline = pipeline_on(self.shared, colour=colour, observers=[self.desk, self])
        self.clock = self.pipeline._devices.clock

    def run(self, **settings):
        self.script.get(0, lambda desk: None)(self.desk)
        attend(self.pipeline, self.clock, self.shared, self.desk, ObjectNavConfig(**settings))
        return self.desk.agenda.errands()

    def on_step(self, step):
        self.steps.append(step)
        number = len(self.steps)
        self.script.get(number, lambda desk: None)(self.desk)
        if number >= self.last:
            self.desk.closed.set()

    def on_goal(self, report):
        pass


@pytest.fixture(autouse=True)
def no_pacing(monkeypatch):
    monkeypatch.setattr("vizbot.operator.session.task_loop._pace", lambda clock: lambda: None)


def test_goals_are_visited_in_order_and_each_outcome_is_told(pipeline_on):
    robot = ServedRun(
        pipeline_on, {0: lambda desk: desk.ask(["yellow chair", "blue chair"])}, last=300
    )
    first, second = robot.run(max_steps=100)
    assert first.outcome is Outcome.ARRIVED and first.position is not None
    assert second.outcome is not Outcome.ARRIVED and second.reason
    assert robot.body.driven[-1] == STOP


def test_stop_ends_everything_at_once_and_a_new_goal_begins_again(pipeline_on):
    robot = ServedRun(
        pipeline_on,
        {
            0: lambda desk: desk.ask(["blue chair", "green chair"]),
            10: lambda desk: desk.stop("ann"),
            40: lambda desk: desk.ask(["yellow chair"]),
        },
    )
    errands = robot.run()
    outcomes = {errand.text: (errand.outcome, errand.reason) for errand in errands}
    for text in ("blue chair", "green chair"):
        assert outcomes[text] == (Outcome.GAVE_UP, "stopped by ann")
    assert outcomes["yellow chair"][0] is Outcome.ARRIVED
    resting = np.array([step.T_map_base[:2, 3] for step in robot.steps[12:38]])
    assert np.ptp(resting, axis=0).max() < 1e-3


def test_a_goal_that_takes_over_ends_the_one_that_runs(pipeline_on):
    robot = ServedRun(
        pipeline_on,
        {
            0: lambda desk: desk.ask(["blue chair"]),
            5: lambda desk: desk.ask(["yellow chair"], at_once=True),
        },
    )
    blue, yellow = robot.run()
    assert (blue.outcome, blue.reason) == (Outcome.GAVE_UP, "another goal took over")
    assert yellow.outcome is Outcome.ARRIVED


def test_who_drives_by_hand_comes_before_the_goal_which_goes_on_after_that(pipeline_on):
    links = []

    def drive(desk):
        links.append(desk.take_wheel("ann"))
        desk.wheel.tell(links[0], 1, desk.wheel.time(), AHEAD)
        driven.append(len(robot.body.driven))

    def let_go(desk):
        driven.append(len(robot.body.driven))
        desk.release_wheel(links[0], given_back=True)

    driven = []
    robot = ServedRun(
        pipeline_on,
        {0: lambda desk: desk.ask(["yellow chair"]), 4: drive, 5: let_go},
    )
    [errand] = robot.run()
    by_hand = robot.body.driven[slice(*driven)]
    assert by_hand and set(by_hand) == {AHEAD}
    assert robot.steps[4].activity == "mapping"
    assert errand.outcome is Outcome.ARRIVED


def test_when_the_link_of_who_drives_is_lost_the_robot_rests_until_it_is_asked_to_go_on(
    pipeline_on,
):
    links = []

    def drive(desk):
        links.append(desk.take_wheel("ann"))
        desk.wheel.tell(links[0], 1, desk.wheel.time(), AHEAD)

    robot = ServedRun(
        pipeline_on,
        {
            0: lambda desk: desk.ask(["yellow chair"]),
            4: drive,
            6: lambda desk: desk.release_wheel(links[0], given_back=False),
            20: lambda desk: desk.go_on(),
        },
        last=200,
    )
    [errand] = robot.run()
    assert {step.activity for step in robot.steps[6:20]} == {"mapping"}
    resting = np.array([step.T_map_base[:2, 3] for step in robot.steps[8:20]])
    assert np.ptp(resting, axis=0).max() < 1e-3
    assert errand.outcome is Outcome.ARRIVED


def test_stop_takes_the_wheel_away_and_a_new_goal_does_not_give_it_back(pipeline_on):
    links = []

    def drive(desk):
        links.append(desk.take_wheel("ann"))

    def hold(desk):
        desk.wheel.tell(links[0], len(robot.steps), desk.wheel.time(), AHEAD)

    def stop_and_ask(desk):
        desk.stop("bob")
        desk.ask(["blue chair"])
        driven.append(len(robot.body.driven))

    driven = []
    script = {n: hold for n in range(3, 30)} | {2: drive, 10: stop_and_ask}
    robot = ServedRun(pipeline_on, script, last=30)
    robot.run()
    assert AHEAD in robot.body.driven[: driven[0]]
    assert AHEAD not in robot.body.driven[driven[0] :]
    assert robot.desk.wheel.holder is None


def test_an_exploration_is_asked_for_like_a_goal(pipeline_on):
    robot = ServedRun(pipeline_on, {0: lambda desk: desk.ask([Task.EXPLORE])}, last=200)
    [errand] = robot.run()
    assert errand.outcome is Outcome.EXPLORED


def test_a_goal_is_given_up_after_so_many_steps(pipeline_on):
    robot = ServedRun(pipeline_on, {0: lambda desk: desk.ask(["blue chair"])}, last=30)
    [errand] = robot.run(max_steps=7)
    assert errand.reason == "not done within 7 steps"
    told = [line.text for line in robot.desk.log()]
    assert "blue chair: gave up (not done within 7 steps)" in told


def test_without_a_base_goals_are_looked_up_on_the_map(pipeline_on):
    script = {4: lambda desk: desk.ask(["yellow chair", "blue chair", Task.DOCK])}
    robot = ServedRun(pipeline_on, script, base=False, last=20)
    outcomes = [errand.outcome for errand in robot.run()]
    assert outcomes == [Outcome.LOCATED, Outcome.NOT_FOUND, Outcome.GAVE_UP]


def test_what_people_want_of_the_map_is_done_between_two_steps(pipeline_on):
    steps, late, wrong = [], [], []

    def ask(desk):
        steps.append(desk.between_steps(lambda pipeline: pipeline.steps))

    def ask_wrong(desk):
        wrong.append(desk.between_steps(lambda pipeline: 1 // 0))

    def ask_late(desk):
        late.append(desk.between_steps(lambda pipeline: pipeline.steps))

    script = {0: ask, 7: ask_wrong, 15: ask, 20: ask_late}
    robot = ServedRun(pipeline_on, script, last=20)
    assert robot.run() == []
    assert [answer.result(timeout=0) for answer in steps] == [0, 15]
    assert isinstance(wrong[0].exception(timeout=0), ZeroDivisionError)
    assert late[0].cancelled()


def test_a_place_is_gone_to_and_the_robot_comes_back(pipeline_on):
    script = {0: lambda desk: desk.ask([Waypoint(0.6, 0.0), Task.COME_BACK])}
    robot = ServedRun(pipeline_on, script, colour=(120, 110, 100), last=150)
    there, back = robot.run()
    assert (there.outcome, back.outcome) == (Outcome.ARRIVED, Outcome.ARRIVED)
    assert np.linalg.norm(np.subtract(there.position[:2], (0.6, 0.0))) < 0.3
    assert np.linalg.norm(back.position[:2]) < 0.3
    assert (there.text, back.text) == ("go to 0.6 m, 0.0 m", "come back")


def test_when_a_device_is_gone_the_wheels_are_stopped(pipeline_on, monkeypatch):
    robot = ServedRun(pipeline_on, {0: lambda desk: desk.ask(["blue chair"])})
    ticks = iter(range(5))
    tick = robot.pipeline.tick

    def fail(task):
        if next(ticks, None) is None:
            raise DeviceError("the camera is gone")
        return tick(task)

    monkeypatch.setattr(robot.pipeline, "tick", fail)
    with pytest.raises(DeviceError, match="gone"):
        robot.run()
    assert robot.body.driven[-1] == STOP


def test_the_state_tells_what_a_person_wants_to_know(pipeline_on):
    robot = ServedRun(pipeline_on, {0: lambda desk: desk.ask(["yellow chair"])}, last=30)
    robot.desk.base_state = lambda: robot.shared.state
    robot.run()
    state = state_of(robot.desk)
    assert state["step"] == 29
    assert state["base"]["mode"] == "safe" and state["base"]["feels"] == []
    assert [goal["text"] for goal in state["goals"]] == ["yellow chair"]
    assert state["log"][0]["code"] == "goal"
    assert state["wheel"] is None and state["stopped"] is False
