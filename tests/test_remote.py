"""`vizbot goal`, `explore`, `stop` and `status` against a robot that is running."""

import json
import threading

import pytest

from tests.served import served, step, wait_for
from vizbot.commands import remote
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.observation import Outcome
from vizbot.operator.client import RobotClient
from vizbot.operator.desk import Desk


@pytest.fixture
def desk():
    return Desk()


@pytest.fixture
def client(desk):
    with served(desk) as server, RobotClient(server.url, None) as client:
        yield client


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(remote, "_EVERY", 0.01)


def test_goals_are_asked_for_and_their_outcomes_waited_for(client, desk, capsys):
    def robot():
        for outcome in (Outcome.ARRIVED, Outcome.GAVE_UP):
            wait_for(lambda: desk.agenda.current() is not None)
            desk.agenda.finish(outcome, "so it is")

    running = threading.Thread(target=robot)
    running.start()
    assert remote.ask(client, ["sofa", "bed"], at_once=False, wait=True) is False
    running.join()
    assert capsys.readouterr().out.splitlines() == [
        "sofa: arrived (so it is)",
        "bed: gave_up (so it is)",
    ]


def test_who_does_not_wait_is_told_nothing(client, desk, capsys):
    assert remote.ask(client, ["sofa"], at_once=True, wait=False) is True
    assert remote.explore(client, wait=False) is True
    assert [errand.text for errand in desk.agenda.errands()] == ["sofa", "explore"]
    assert capsys.readouterr().out == ""


def test_stop_and_status(client, desk, capsys):
    desk.on_step(step(3))
    remote.ask(client, ["sofa"], at_once=False, wait=False)
    remote.status(client, as_json=False)
    assert capsys.readouterr().out.splitlines() == ["exploring", "  1 sofa: to be done"]
    remote.stop(client)
    remote.status(client, as_json=True)
    told = capsys.readouterr().out.splitlines()
    assert told[0] == "stopped"
    assert json.loads(told[1])["stopped"] is True


def test_an_empty_goal_is_one_line(client):
    with pytest.raises(ConfigError, match="is empty"):
        remote.ask(client, ["sofa", " "], at_once=False, wait=False)


def test_what_the_robot_refuses_is_one_line(client):
    with pytest.raises(DeviceError, match=r"refuses: the goal .* holds what is no text"):
        client.ask(["so\x07fa"])
    with pytest.raises(DeviceError, match=r"refuses: texts.0: String should have at most 200"):
        client.ask(["a" * 300])


@pytest.mark.parametrize("url", ["http://127.0.0.1:9", "robot"])
def test_where_no_robot_answers_one_line_says_so(url):
    with (
        pytest.raises(DeviceError, match=f"no robot answers at {url}.*vizbot launch"),
        RobotClient(url, None) as client,
    ):
        client.state()
