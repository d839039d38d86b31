"""What was understood reaches a robot that is running."""

import threading
from dataclasses import replace
from datetime import UTC, datetime

import httpx
import pytest

from tests.helpers.roomba_rig import DEADLINE
from tests.helpers.served import step
from vizbot.commands.dispatch import CommandSender, obey
from vizbot.core.errors import DeviceError
from vizbot.core.observer import Outcome
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.language.command import All, ComeBack, Dock, Explore, GoTo, Stop, WhereIs
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.place_answers import Answer, FoundPlace
from vizbot.operator.session.vocabulary import VocabularyUpdater
from vizbot.operator.voice.intent import ResolvedGoal, Utterance

JUST_NOW = datetime.now(UTC).isoformat()
DOUBTFUL = ResolvedGoal("so far", "so far", "sofa")


class NotingRobot:
    """Notes what it is told; `answers` is whether it is there."""

    def __init__(self, answers=True):
        self.told = []
        self.answers = answers

    def say(self, text, who, *, at_once):
        self.told.append(text)
        return {"said": [f"asked for: {text}"], "numbers": [1]}

    def doubt(self, question):
        self.told.append(question)

    def vocabulary(self):
        if not self.answers:
            raise DeviceError("no robot answers")
        return ["sofa", "lamp"]


def heard(command, *resolved):
    return Utterance("as it was said", command, resolved)


def texts(session):
    return [task.text for task in session.queue.tasks()]


def test_goals_are_asked_for_and_stop_stops(client, session, capsys):
    obey(heard(GoTo(("kitchen", "sofa"))), client)
    assert texts(session) == ["kitchen", "sofa"]
    assert capsys.readouterr().out == "command: go to kitchen, then sofa\n"
    obey(heard(Stop()), client)
    assert session.stopped.is_set()


@pytest.mark.parametrize("command", [GoTo(("sofa",)), ComeBack(), Dock(), Explore()])
def test_what_must_not_wait_ends_what_is_running(client, session, command):
    obey(heard(GoTo(("kitchen",))), client)
    assert session.queue.current().request == "kitchen"
    obey(replace(heard(command), at_once=True), client)
    assert session.queue.current().called_off


def test_a_mission_that_must_not_wait_stays_together(client, session):
    obey(heard(GoTo(("bed",))), client)
    obey(replace(heard(GoTo(("sofa",), ComeBack())), at_once=True), client)
    assert texts(session) == ["sofa", "come back", "bed"]
    assert session.queue.current().request == "sofa"
    assert not session.queue.current().called_off


def test_of_all_things_one_is_gone_to_and_that_is_said(client, session, capsys):
    obey(heard(All("chair")), client)
    assert texts(session) == ["chair"]
    assert "it goes to one, and of several on its map to one near by" in capsys.readouterr().out


def test_where_something_is_is_looked_up(client, session, capsys, monkeypatch):
    place = FoundPlace((1.0, -2.0, 0.4), 0.5, 3, (), JUST_NOW)
    monkeypatch.setattr(
        LiveMap, "places", lambda live_map, text: Answer(text, Outcome.LOCATED, 0.3, (place,))
    )
    session.on_step(step(0))
    obey(heard(WhereIs("sofa")), client)
    assert "sofa: 2.2 m ahead and to the right of the robot" in capsys.readouterr().out
    assert texts(session) == []


def test_it_is_sent_back_and_to_its_dock(capsys):
    robot = NotingRobot()
    for command in (ComeBack(), Dock(), GoTo(("sofa", "bed"), Dock())):
        obey(heard(command), robot)
    assert robot.told == ["come back", "dock", "go to sofa, then bed, then dock"]
    assert "learnt" not in capsys.readouterr().out


def test_in_doubt_it_only_tells_what_is_asked(capsys):
    robot = NotingRobot()
    doubtful = heard(GoTo(("sofa",)), DOUBTFUL)
    obey(doubtful, robot)
    assert robot.told == [doubtful.question]
    assert capsys.readouterr().out == f"{doubtful.question}\n"


def test_the_words_of_the_map_are_learnt_again_and_again():
    robot, learnt, enough = NotingRobot(), [], threading.Event()

    def learn(found):
        learnt.append(found)
        robot.answers = False
        if len(learnt) == 2:
            enough.set()

    with VocabularyUpdater(robot.vocabulary, learn, period=0.0):
        assert enough.wait(DEADLINE)
    assert learnt[:2] == [("sofa", "lamp"), ()]


def test_not_understood_or_without_a_robot_nothing_is_done(client, session, capsys):
    obey(heard(None), client)
    obey(heard(GoTo(("bed",))), None)
    assert texts(session) == []
    assert "command: go to bed" in capsys.readouterr().out


class StuckRobot(NotingRobot):
    """Whose link is stuck: what it is asked for arrives once `link` is set.

    Attributes:
        unheard: So many stops are lost.
        asked: Set when something is on its way.
    """

    def __init__(self, unheard=0):
        super().__init__()
        self.unheard = unheard
        self.asked, self.stopped, self.link = (threading.Event() for _ in range(3))

    def say(self, text, who, *, at_once):
        self.asked.set()
        assert self.link.wait(DEADLINE)
        return super().say(text, who, at_once=at_once)

    def stop(self, who, timeout):
        self.unheard -= 1
        if self.unheard >= 0:
            raise DeviceError("no robot answers")
        self.told.append("stop")
        self.stopped.set()


def test_a_stop_is_sent_until_it_is_heard_and_that_is_said_once(capsys):
    robot = StuckRobot(unheard=5)
    with CommandSender(robot, pause=0.0) as sender:
        sender.send(heard(Stop()))
    assert robot.told == ["stop"]
    assert capsys.readouterr() == (
        "stopped\n",
        "STOP was not heard and is sent until it is: no robot answers\n",
    )


def test_a_stop_overtakes_what_is_on_its_way_and_follows_it_and_the_rest_is_not_done():
    robot = StuckRobot()
    with CommandSender(robot) as sender:
        sender.send(heard(GoTo(("sofa",))))
        assert robot.asked.wait(DEADLINE)
        sender.send(heard(GoTo(("bed",))))
        sender.send(heard(Stop()))
        assert robot.stopped.wait(DEADLINE)
        robot.link.set()
    assert robot.told == ["stop", "go to sofa", "stop"]


def test_what_is_said_after_a_stop_is_done_once_it_was_heard():
    robot = StuckRobot(unheard=100)
    robot.link.set()
    with CommandSender(robot, pause=0.0) as sender:
        sender.send(heard(Stop()))
        sender.send(heard(GoTo(("bed",))))
    assert robot.told == ["stop", "go to bed"]


@pytest.mark.parametrize("error", [DeviceError("no robot answers"), KeyError("told")])
def test_a_command_that_fails_does_not_end_the_listening(capsys, monkeypatch, error):
    say = NotingRobot.say

    def fail(robot, text, who, *, at_once):
        if text.startswith("where is"):
            raise error
        return say(robot, text, who, at_once=at_once)

    robot = NotingRobot()
    monkeypatch.setattr(NotingRobot, "say", fail)
    with CommandSender(robot) as sender:
        sender.send(heard(WhereIs("sofa")))
        sender.send(heard(Dock()))
    assert robot.told == ["dock"]
    assert capsys.readouterr().err == f"{error}\n"


def test_a_stop_over_a_link_that_is_stuck_is_given_up_soon():
    waits = []

    def answer(request):
        waits.append(request.extensions["timeout"]["read"])
        return httpx.Response(200, json={"stopped": True, "numbers": [1]})

    with RobotClient("http://robot", None, httpx.MockTransport(answer)) as robot:
        with CommandSender(robot) as sender:
            sender.send(heard(Stop()))
        robot.dock()
    assert waits[0] < 2.0 < waits[1]
