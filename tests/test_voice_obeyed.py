"""What was understood reaches a robot that is running."""

import threading

import pytest

from tests.roomba_rig import DEADLINE
from tests.served import served, step
from vizbot.commands.voice import obey
from vizbot.core.errors import DeviceError
from vizbot.core.observation import Outcome
from vizbot.operator.answers import Answer, Place
from vizbot.operator.atlas import Atlas
from vizbot.operator.client import RobotClient
from vizbot.operator.desk import Desk
from vizbot.operator.grammar import All, ComeBack, Dock, GoTo, Stop, WhereIs
from vizbot.operator.hearing import Heard, Meaning
from vizbot.operator.map_words import MapWords

DOUBTFUL = Meaning("so far", "so far", "sofa")


@pytest.fixture
def desk():
    return Desk()


@pytest.fixture
def robot(desk):
    with served(desk) as server, RobotClient(server.url, None) as client:
        yield client


class NotingRobot:
    """Notes what it is told; `answers` is whether it is there."""

    def __init__(self, answers=True):
        self.told = []
        self.answers = answers

    def ask(self, texts):
        self.told.append(tuple(texts))

    def come_back(self):
        self.told.append("come back")

    def dock(self):
        self.told.append("dock")

    def doubt(self, question):
        self.told.append(question)

    def vocabulary(self):
        if not self.answers:
            raise DeviceError("no robot answers")
        return ["sofa", "lamp"]


def heard(command, *meanings):
    return Heard("as it was said", command, meanings)


def texts(desk):
    return [errand.text for errand in desk.agenda.errands()]


def test_goals_are_asked_for_and_stop_stops(robot, desk, capsys):
    obey(heard(GoTo(("kitchen", "sofa"))), robot)
    assert texts(desk) == ["kitchen", "sofa"]
    assert capsys.readouterr().out == "command: go to kitchen, then sofa\n"
    obey(heard(Stop()), robot)
    assert desk.stopped.is_set()


def test_of_all_things_the_first_one_is_gone_to_and_that_is_said(robot, desk, capsys):
    obey(heard(All("chair")), robot)
    assert texts(desk) == ["chair"]
    assert "goes to the one that it finds first" in capsys.readouterr().out


def test_where_something_is_is_looked_up(robot, desk, capsys, monkeypatch):
    place = Place((1.0, -2.0, 0.4), 0.5, 3, ())
    monkeypatch.setattr(
        Atlas, "places", lambda atlas, text: Answer(text, Outcome.LOCATED, 0.3, (place,))
    )
    desk.on_step(step(0))
    obey(heard(WhereIs("sofa")), robot)
    assert "sofa: 2.2 m ahead and to the right of the robot" in capsys.readouterr().out
    assert texts(desk) == []


def test_it_is_sent_back_and_to_its_dock(capsys):
    robot = NotingRobot()
    for command in (ComeBack(), Dock(), GoTo(("sofa", "bed"), Dock()), GoTo(("door",), ComeBack())):
        obey(heard(command), robot)
    assert robot.told == ["come back", "dock", ("sofa", "bed"), "dock", ("door",), "come back"]
    assert "learnt" not in capsys.readouterr().out


def test_in_doubt_it_only_tells_what_is_asked(capsys):
    robot = NotingRobot()
    obey(heard(GoTo(("sofa",)), DOUBTFUL), robot)
    assert robot.told == [DOUBTFUL.question]
    assert capsys.readouterr().out == f"{DOUBTFUL.question}\n"


def test_the_words_of_the_map_are_learnt_again_and_again():
    robot, learnt, enough = NotingRobot(), [], threading.Event()

    def learn(found):
        learnt.append(found)
        robot.answers = False
        if len(learnt) == 2:
            enough.set()

    with MapWords(robot.vocabulary, learn, period=0.0):
        assert enough.wait(DEADLINE)
    assert learnt[:2] == [("sofa", "lamp"), ()]


def test_not_understood_or_without_a_robot_nothing_is_done(robot, desk, capsys):
    obey(heard(None), robot)
    obey(heard(GoTo(("bed",))), None)
    assert texts(desk) == []
    assert "command: go to bed" in capsys.readouterr().out
