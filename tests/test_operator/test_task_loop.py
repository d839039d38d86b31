"""The robot's loop while people ask, drive by hand and stop."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest

from tests.helpers.roomba_rig import DEADLINE, wait_for
from tests.helpers.scripted_robot import PERIOD, ScriptedBase
from vizbot.config import ObjectNavConfig
from vizbot.core.errors import DeviceError
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, Twist
from vizbot.objectnav.looks import APART
from vizbot.objectnav.tasks import Task, Waypoint
from vizbot.operator.api.state import state_of
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_loop import run_tasks
from vizbot.operator.session.twist_mux import TwistMux

pytestmark = pytest.mark.slow

YELLOW = (240, 220, 12)
AHEAD = Twist(0.2, 0.0)


def asks(*goals, at_once=False):
    """Somebody asks for goals."""
    return lambda session: session.ask([*goals], at_once=at_once)


class ScriptedRun:
    """A robot, and a `script` of what people do before each step, by number."""

    def __init__(self, pipeline_on, script, colour=YELLOW, base=True, last=120):
        self.session = OperatorSession()
        self.body = ScriptedBase()
        self.shared = None
        if base:
            self.shared = TwistMux(self.body, self.session.lease, self.session.stopped)
        self.script, self.last = script, last
        self.steps = []
        self.pipeline = pipeline_on(self.shared, colour=colour, observers=[self.session, self])
        self.clock = self.pipeline._devices.clock

    def run(self, **settings):
        self.script.get(0, lambda session: None)(self.session)
        run_tasks(self.pipeline, self.clock, self.shared, self.session, ObjectNavConfig(**settings))
        return self.session.queue.tasks()

    def drive_by_hand(self):
        self.link = self.session.take_lease("ann")
        self.session.lease.accept(self.link, 1, self.session.lease.time(), AHEAD)

    def on_step(self, step):
        self.steps.append(step)
        number = len(self.steps)
        self.script.get(number, lambda session: None)(self.session)
        if number >= self.last:
            self.session.closed.set()

    def on_goal(self, report):
        pass


@pytest.fixture(autouse=True)
def no_pacing(monkeypatch):
    monkeypatch.setattr("vizbot.operator.session.task_loop._pace", lambda clock: lambda: None)


def test_goals_are_visited_in_order_and_each_outcome_is_told(pipeline_on):
    robot = ScriptedRun(pipeline_on, {0: asks("yellow chair", "blue chair")}, last=300)
    first, second = robot.run(max_steps=100)
    assert first.outcome is Outcome.ARRIVED and first.position is not None
    assert second.outcome is not Outcome.ARRIVED and second.reason
    assert robot.body.driven[-1] == STOP


def test_stop_ends_everything_at_once_and_a_new_goal_begins_again(pipeline_on):
    robot = ScriptedRun(
        pipeline_on,
        {
            0: asks("blue chair", "green chair"),
            10: lambda session: session.stop("ann"),
            40: asks("yellow chair"),
        },
    )
    outcomes = {task.text: (task.outcome, task.reason) for task in robot.run()}
    for text in ("blue chair", "green chair"):
        assert outcomes[text] == (Outcome.GAVE_UP, "stopped by ann")
    assert outcomes["yellow chair"][0] is Outcome.ARRIVED
    resting = np.array([step.T_map_base[:2, 3] for step in robot.steps[12:38]])
    assert np.ptp(resting, axis=0).max() < 1e-3


def test_a_goal_that_takes_over_ends_the_one_that_runs(pipeline_on):
    robot = ScriptedRun(pipeline_on, {0: asks("blue chair"), 5: asks("yellow chair", at_once=True)})
    blue, yellow = robot.run()
    assert (blue.outcome, blue.reason) == (Outcome.GAVE_UP, "another goal took over")
    assert yellow.outcome is Outcome.ARRIVED


def test_who_drives_by_hand_comes_before_the_goal_which_goes_on_after_that(pipeline_on):
    def drive(session):
        robot.drive_by_hand()
        driven.append(len(robot.body.driven))

    def let_go(session):
        driven.append(len(robot.body.driven))
        session.release_lease(robot.link, given_back=True)

    driven = []
    robot = ScriptedRun(pipeline_on, {0: asks("yellow chair"), 4: drive, 5: let_go})
    [task] = robot.run()
    by_hand = robot.body.driven[slice(*driven)]
    assert by_hand and set(by_hand) == {AHEAD}
    assert robot.steps[4].activity == "mapping"
    assert task.outcome is Outcome.ARRIVED


def test_when_the_link_of_who_drives_is_lost_the_robot_rests_until_it_is_asked_to_go_on(
    pipeline_on,
):
    robot = ScriptedRun(
        pipeline_on,
        {
            0: asks("yellow chair"),
            4: lambda session: robot.drive_by_hand(),
            6: lambda session: session.release_lease(robot.link, given_back=False),
            20: lambda session: session.go_on(),
        },
        last=200,
    )
    [task] = robot.run()
    assert {step.activity for step in robot.steps[6:20]} == {"mapping"}
    resting = np.array([step.T_map_base[:2, 3] for step in robot.steps[8:20]])
    assert np.ptp(resting, axis=0).max() < 1e-3
    assert task.outcome is Outcome.ARRIVED


def test_stop_takes_the_wheel_away_and_a_new_goal_does_not_give_it_back(pipeline_on):
    links = []

    def drive(session):
        links.append(session.take_lease("ann"))

    def hold(session):
        session.lease.accept(links[0], len(robot.steps), session.lease.time(), AHEAD)

    def stop_and_ask(session):
        session.stop("bob")
        session.ask(["blue chair"])
        driven.append(len(robot.body.driven))

    driven = []
    script = {n: hold for n in range(3, 30)} | {2: drive, 10: stop_and_ask}
    robot = ScriptedRun(pipeline_on, script, last=30)
    robot.run()
    assert AHEAD in robot.body.driven[: driven[0]]
    assert AHEAD not in robot.body.driven[driven[0] :]
    assert robot.session.lease.holder is None


def test_an_exploration_is_asked_for_like_a_goal(pipeline_on):
    robot = ScriptedRun(pipeline_on, {0: lambda session: session.ask([Task.EXPLORE])}, last=200)
    [task] = robot.run()
    assert task.outcome is Outcome.EXPLORED


def find_place(session):
    session.ask([Task.FIND_PLACE])


def carry(robot):
    """Lift a robot that knows where it is, and put it down again."""
    for feels in ({}, {0: {"wheel_drops": (True, True)}}):
        robot.body.feels = feels
        robot.pipeline.tick(Task.MAP)
    robot.body.feels = {}


def turned(robot):
    """The way around of a robot that only turns [rad]."""
    assert {twist.linear for twist in robot.body.driven} <= {0.0}
    return sum(abs(twist.angular) for twist in robot.body.driven) * PERIOD


def test_a_lost_robot_turns_once_for_each_task_to_find_its_place(pipeline_on):
    robot = ScriptedRun(pipeline_on, {0: find_place, 150: find_place}, last=300)
    carry(robot)
    first, second = robot.run()
    assert "lost, looking around" in {step.activity for step in robot.steps}
    for task in (first, second):
        assert task.outcome is Outcome.GAVE_UP and "recognises nothing" in task.reason
    assert 2 * 6.2 < turned(robot) < 2 * 7.5


def test_stop_ends_the_turn_of_a_lost_robot(pipeline_on):
    script = {0: find_place, 8: lambda session: session.stop("ann")}
    robot = ScriptedRun(pipeline_on, script, last=40)
    carry(robot)
    [task] = robot.run()
    assert task.reason == "stopped by ann" and 0.5 < turned(robot) < 3.0
    assert robot.steps[-1].activity == "mapping" and robot.body.driven[-1] == STOP


def test_a_robot_that_knows_its_place_does_not_turn_to_find_it(pipeline_on):
    [task] = (robot := ScriptedRun(pipeline_on, {0: find_place}, last=20)).run()
    assert (task.outcome, turned(robot)) == (Outcome.LOCATED, 0.0)


@pytest.mark.parametrize("charges", [{"docked": True}, {"plugged_in": True}])
def test_a_robot_on_a_charger_stays_there_until_it_is_asked_for_something(pipeline_on, charges):
    robot = ScriptedRun(pipeline_on, {0: find_place}, last=20)
    robot.body.feels = dict.fromkeys(range(100), charges)
    [task] = robot.run()
    assert task.outcome is Outcome.GAVE_UP and "charges" in task.reason
    assert turned(robot) == 0.0


def test_the_same_task_asked_for_again_is_judged_by_what_comes_of_it_alone(pipeline_on):
    accounts = []

    def note(session):
        accounts.append(robot.pipeline.map.progress._account)

    script = {0: lambda session: session.ask([Task.EXPLORE] * 2), 4: note, 5: note, 9: note}
    robot = ScriptedRun(pipeline_on, script, last=40)
    first, second = robot.run(max_exploration_steps=5)
    assert first.reason == second.reason == "not done within 5 steps"
    assert accounts[0] is accounts[1] is not None
    assert accounts[2] not in (accounts[0], None)


def test_a_goal_is_given_up_after_so_many_steps(pipeline_on):
    robot = ScriptedRun(pipeline_on, {0: asks("blue chair")}, last=30)
    [task] = robot.run(max_steps=7)
    assert task.reason == "not done within 7 steps"
    told = [line.text for line in robot.session.log.lines()]
    [ended] = [line for line in told if line.startswith("Gave up on the blue chair after ")]
    assert ended.endswith(" m: not done within 7 steps")


def test_without_a_base_goals_are_looked_up_on_the_map(pipeline_on):
    script = {4: lambda session: session.ask(["yellow chair", "blue chair", Task.DOCK])}
    robot = ScriptedRun(pipeline_on, script, base=False, last=20)
    outcomes = [task.outcome for task in robot.run()]
    assert outcomes == [Outcome.LOCATED, Outcome.NOT_FOUND, Outcome.GAVE_UP]


def test_what_people_want_of_the_map_is_done_between_two_steps(pipeline_on):
    answers = []

    def ask(session):
        answers.append(session.jobs.submit(lambda pipeline: pipeline.steps))

    def ask_wrong(session):
        answers.append(session.jobs.submit(lambda pipeline: 1 // 0))

    robot = ScriptedRun(pipeline_on, {0: ask, 7: ask_wrong, 15: ask, 20: ask}, last=20)
    assert robot.run() == []
    first, wrong, second, late = answers
    assert (first.result(timeout=0), second.result(timeout=0)) == (0, 15)
    assert isinstance(wrong.exception(timeout=0), ZeroDivisionError)
    assert late.cancelled()


def test_a_place_is_gone_to_and_the_robot_comes_back(pipeline_on):
    script = {0: lambda session: session.ask([Waypoint(0.6, 0.0), Task.COME_BACK])}
    robot = ScriptedRun(pipeline_on, script, colour=(120, 110, 100), last=150)
    there, back = robot.run()
    assert (there.outcome, back.outcome) == (Outcome.ARRIVED, Outcome.ARRIVED)
    assert np.linalg.norm(np.subtract(there.position[:2], (0.6, 0.0))) < 0.3
    assert np.linalg.norm(back.position[:2]) < 0.3
    assert (there.text, back.text) == ("go to 0.6 m, 0.0 m", "come back")


def test_when_a_device_is_gone_the_wheels_are_stopped(pipeline_on, monkeypatch):
    robot = ScriptedRun(pipeline_on, {0: asks("blue chair")})
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
    robot = ScriptedRun(pipeline_on, {0: asks("yellow chair")}, last=30)
    robot.session.robot.base_state = lambda: robot.shared.state
    robot.run()
    state = state_of(robot.session)
    assert state["step"] == 29
    assert state["base"]["mode"] == "safe" and state["base"]["feels"] == []
    assert [goal["text"] for goal in state["goals"]] == ["yellow chair"]
    assert state["log"][0]["code"] == "goal"
    assert state["wheel"] is None and state["stopped"] is False


class Verdicts:
    """What people say of arrivals, each from a thread of its own while the loop does a step."""

    def __init__(self, confirmed=False):
        self.confirmed, self.answers, self.kept = confirmed, [], []
        self.people = ThreadPoolExecutor(1)

    def say(self, session):
        session.robot.keep_verdict = lambda report, confirmed: self.kept.append(
            (report.text, confirmed)
        )
        answer = self.people.submit(session.judge, confirmed=self.confirmed, who="ann")
        self.answers.append(answer)
        wait_for(lambda: len(session.jobs) or answer.done())

    def refusals(self):
        return [str(answer.exception(timeout=DEADLINE)) for answer in self.answers]


def test_what_is_not_it_is_searched_for_again_at_once(pipeline_on):
    verdicts = Verdicts()
    script = {0: asks("yellow chair"), 100: verdicts.say}
    robot = ScriptedRun(pipeline_on, script, last=240)
    first, second = robot.run()
    assert first.outcome is Outcome.ARRIVED and first.effort.way > 0.0
    assert [task.number for task in verdicts.answers[0].result()] == [second.number]
    assert second.text == "yellow chair" and robot.steps[101].goal == "yellow chair"
    assert verdicts.kept == [("yellow chair", False)]
    [line] = [line for line in robot.session.log.lines() if line.code == "verdict"]
    assert line.text == "yellow chair: ann says that is not it; the search goes on"
    if second.position is not None:
        assert np.linalg.norm(np.subtract(second.position, first.position)[:2]) > APART


def test_what_is_it_stays_found_and_the_robot_rests(pipeline_on):
    verdicts = Verdicts(confirmed=True)
    script = {0: asks("yellow chair"), 100: verdicts.say}
    robot = ScriptedRun(pipeline_on, script)
    [task] = robot.run()
    assert verdicts.answers[0].result() == [] and verdicts.kept == [("yellow chair", True)]
    assert robot.session.arrival.number == task.number and robot.session.arrival.confirmed
    assert not robot.session.awaits_verdict


def test_before_an_arrival_and_once_another_search_has_begun_nothing_can_be_refuted(pipeline_on):
    verdicts = Verdicts()
    script = {0: asks("yellow chair"), 3: verdicts.say, 100: asks("blue chair"), 110: verdicts.say}
    ScriptedRun(pipeline_on, script).run()
    assert all("the robot has not arrived, or has begun" in each for each in verdicts.refusals())
    assert verdicts.kept == [] and len(verdicts.answers) == 2


def test_a_robot_that_goes_on_already_is_not_sent_back_to_search(pipeline_on):
    verdicts = Verdicts()
    asks = {0: ["yellow chair"], 100: [Waypoint(-0.6, 0.0)]}
    script = {step: lambda session, what=what: session.ask(what) for step, what in asks.items()}
    robot = ScriptedRun(pipeline_on, script | {102: verdicts.say}, last=110)
    robot.run()
    assert verdicts.refusals() == ["the robot goes on already: go to -0.6 m, 0.0 m; stop it first"]
    assert robot.session.awaits_verdict


def test_a_stop_after_a_verdict_was_sent_keeps_the_search_from_going_on(pipeline_on):
    verdicts = Verdicts()

    def say_and_stop(session):
        verdicts.say(session)
        session.stop("bob")

    script = {0: asks("yellow chair"), 100: say_and_stop}
    robot = ScriptedRun(pipeline_on, script)
    assert len(robot.run()) == 1
    assert verdicts.refusals() == ["the robot was stopped meanwhile; ask again"]
    assert robot.session.stopped.is_set() and robot.session.awaits_verdict


def test_by_the_method_of_the_paper_an_arrival_cannot_be_refuted(pipeline_on):
    verdicts = Verdicts()
    script = {0: asks("yellow chair"), 80: verdicts.say}
    robot = ScriptedRun(partial(pipeline_on, method="paper"), script)
    [task] = robot.run()
    assert task.outcome is Outcome.ARRIVED
    assert "the method 'paper' cannot learn" in verdicts.refusals()[0]
    assert robot.session.queue.current() is None


def test_what_the_robot_goes_up_to_and_is_not_it_is_left_within_the_same_search(pipeline_on):
    people, answers, seen, kept = ThreadPoolExecutor(1), [], [], []

    def deny(session):
        seen.append(session.candidate)
        session.robot.keep_verdict_on_way = lambda *verdict: kept.append(verdict)
        number = session.candidate.number
        answer = people.submit(session.judge_candidate, number, confirmed=False, who="ann")
        answers.append(answer)
        wait_for(lambda: len(session.jobs) or answer.done())

    plain = ScriptedRun(pipeline_on, {0: asks("yellow chair")})
    plain.run()
    first = next(i for i, step in enumerate(plain.steps) if step.candidate_xy is not None)
    script = {0: asks("yellow chair"), first + 2: deny}
    robot = ScriptedRun(pipeline_on, script, last=first + 8)
    robot.run()
    assert answers[0].exception(timeout=DEADLINE) is None
    place_xy, after = seen[0].place_xy, robot.steps[first + 3]
    before = robot.steps[first + 1].scores.look_up(place_xy[None])[0]
    assert after.goal == "yellow chair" and after.scores.look_up(place_xy[None])[0] < 0.1 * before
    [task] = robot.session.queue.tasks()
    assert task.outcome is None or task.outcome is not Outcome.ARRIVED
    assert "ann says that is not it" in "".join(line.text for line in robot.session.log.lines())
    assert [(tuple(xy), confirmed) for xy, confirmed in kept] == [(tuple(place_xy), False)]
