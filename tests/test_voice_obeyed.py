"""What was understood reaches a robot that is running."""

import pytest

from tests.served import served
from vizbot.commands.voice import obey
from vizbot.core.observation import Outcome
from vizbot.operator.answers import Answer, Place
from vizbot.operator.atlas import Atlas
from vizbot.operator.client import RobotClient
from vizbot.operator.desk import Desk
from vizbot.operator.grammar import All, ComeBack, GoTo, Stop, WhereIs
from vizbot.operator.hearing import Heard, Meaning

DOUBTFUL = Meaning("so far", "so far", "sofa")


@pytest.fixture
def desk():
    return Desk()


@pytest.fixture
def robot(desk):
    with served(desk) as server, RobotClient(server.url, None) as client:
        yield client


def heard(command, *meanings):
    return Heard("as it was said", command, meanings)


def texts(desk):
    return [errand.text for errand in desk.agenda.errands()]


def test_goals_are_asked_for_and_stop_stops(robot, desk, capsys):
    obey(heard(GoTo(("kitchen", "sofa"), ComeBack())), robot)
    assert texts(desk) == ["kitchen", "sofa"]
    assert "come back afterwards it has not learnt yet" in capsys.readouterr().out
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
    obey(heard(WhereIs("sofa")), robot)
    assert "sofa: 1.0 m, -2.0 m from where it began" in capsys.readouterr().out
    assert texts(desk) == []


def test_in_doubt_and_without_a_robot_nothing_is_done(robot, desk, capsys):
    obey(heard(GoTo(("sofa",)), DOUBTFUL), robot)
    obey(heard(None), robot)
    obey(heard(GoTo(("bed",))), None)
    assert texts(desk) == []
    assert "command: go to bed" in capsys.readouterr().out
