"""`vizbot goal`, `explore`, `stop` and `status` against a robot that is running."""

import json
import os
import shutil
import subprocess
import sys
import threading
from dataclasses import replace

import httpx
import pytest
import typer

from tests.helpers.roomba_rig import wait_for
from tests.helpers.served import arrived, jobs_done, served, step
from vizbot.cli import remote as cli_remote
from vizbot.commands import remote
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.observer import Outcome
from vizbot.core.types import Tracking
from vizbot.operator.api import auth
from vizbot.operator.api.auth import token_path
from vizbot.operator.client.robot_client import RobotClient


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(remote, "_EVERY", 0.01)


def test_goals_are_asked_for_and_their_outcomes_waited_for(client, session, capsys):
    def robot():
        for outcome, place in ((Outcome.ARRIVED, (1.234, -3.0, 0.5)), (Outcome.GAVE_UP, None)):
            wait_for(lambda: session.queue.current() is not None)
            session.queue.finish(outcome, "so it is", place)

    running = threading.Thread(target=robot)
    running.start()
    assert remote.ask(client, ["sofa", "bed"], at_once=False, wait=True) is False
    running.join()
    assert capsys.readouterr().out.splitlines() == [
        "asked for: go to sofa, then bed",
        "Found the sofa: so it is at 1.23, -3.00 m",
        "Gave up on the bed: so it is",
    ]
    remote.status(client, as_json=False)
    assert "  1 Found the sofa: so it is at 1.23, -3.00 m" in capsys.readouterr().out.splitlines()


def test_a_verdict_is_said_from_a_terminal_and_the_outcome_told_in_words(client, session, capsys):
    arrived(session)
    remote.status(client, as_json=False)
    assert "  1 Found the sofa after 50 s, 12 m: sure" in capsys.readouterr().out.splitlines()
    with jobs_done(session) as refuted:
        said = ["that's not it, keep looking"]
        assert remote.ask(client, said, at_once=False, wait=False) is True
    assert refuted == [True] and session.queue.current().text == "sofa"
    assert capsys.readouterr().out == "not it: I search on for sofa\n"


def test_who_does_not_wait_is_told_what_was_asked_for_and_what_comes_before(
    client, session, capsys
):
    assert remote.ask(client, ["sofa"], at_once=True, wait=False) is True
    assert capsys.readouterr().out == "asked for: go to sofa, right now\n"
    assert remote.explore(client, at_once=False, wait=False) is True
    assert capsys.readouterr().out == "asked for: explore\n1 other task comes before\n"
    assert remote.ask(client, ["bed"], at_once=False, wait=False) is True
    assert capsys.readouterr().out == "asked for: go to bed\n2 other tasks come before\n"


def test_who_asks_at_once_comes_before_all_others(client, session, capsys):
    session.ask(["sofa", "bed"])
    assert remote.explore(client, at_once=True, wait=False) is True
    assert [task.text for task in session.queue.tasks()] == ["explore", "sofa", "bed"]
    assert capsys.readouterr().out == "asked for: explore, right now\n"


def test_an_exploration_is_asked_for_at_once_from_the_command_line(client, session):
    session.ask(["sofa"])
    with pytest.raises(typer.Exit):
        cli_remote.explore(now=True, url=client.url)
    assert [task.text for task in session.queue.tasks()] == ["explore", "sofa"]


def test_stop_and_status(client, session, tmp_path, capsys):
    session.on_step(replace(step(3, x=1.5), why="nothing is known yet"))
    session.robot.folder = tmp_path
    session.ask(["sofa", "bed"])
    remote.status(client, as_json=False)
    assert capsys.readouterr().out.splitlines() == [
        "exploring: nothing is known yet",
        "at 1.50, 0.00 m",
        "  1 sofa: running",
        "  2 bed: waiting",
        f"run {tmp_path}",
    ]
    session.take_lease("ann")
    remote.status(client, as_json=False)
    assert "  1 sofa: waiting" in capsys.readouterr().out.splitlines()
    remote.stop(client)
    remote.status(client, as_json=True)
    printed = capsys.readouterr().out.splitlines()
    assert printed[0] == "stopped"
    assert json.loads(printed[1])["stopped"] is True


def test_a_robot_that_has_no_pose_is_said_to_be_nowhere_known(client, session, capsys):
    remote.status(client, as_json=False)
    lost = step(0)
    lost = replace(lost, estimate=replace(lost.estimate, tracking=Tracking.LOST))
    session.on_step(lost)
    remote.status(client, as_json=False)
    unknown = "where it is, is not known"
    assert capsys.readouterr().out.splitlines() == ["starting", unknown, "exploring", unknown]


def test_a_robot_is_stopped_without_a_token_that_can_be_read(session, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    token_path().parent.mkdir(parents=True)
    token_path().write_text("short")
    with served(session) as server:
        cli_remote.stop(server.url)
    assert session.stopped.is_set()


def test_the_kept_token_is_sent_to_this_machine_and_to_no_other(session, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with served(session, host="0.0.0.0") as server:
        cli_remote.status(url=server.url)
        with pytest.raises(DeviceError, match=r"launch shows; no token was sent: give --token"):
            monkeypatch.setattr(auth, "_is_here", lambda host: False)
            cli_remote.status(url=server.url)
        cli_remote.status(url=server.url, token=server.token)


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl to make a certificate")
def test_a_certificate_of_ones_own_is_trusted_when_it_is_named(session, tmp_path, monkeypatch):
    certificate, key = tmp_path / "robot.pem", tmp_path / "robot.key"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
         "-nodes", "-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1",
         "-out", certificate, "-keyout", key],
        check=True, capture_output=True,
    )  # fmt: skip
    with served(session, certificate=certificate, key=key) as server:
        with (
            RobotClient(server.url, None) as client,
            pytest.raises(DeviceError, match=r"certificate verify failed.*SSL_CERT_FILE"),
        ):
            client.state()
        monkeypatch.setenv("SSL_CERT_FILE", str(certificate))
        with RobotClient(server.url, None) as client:
            client.stop("ann")
            with client.open_websocket("/live") as link:
                assert json.loads(link.recv())["stopped"]
        session.stopped.clear()
        cli_remote.stop(server.url)
        assert session.stopped.is_set()


def test_an_empty_goal_is_one_line(client):
    with pytest.raises(ConfigError, match="is empty"):
        remote.ask(client, ["sofa", " "], at_once=False, wait=False)


def test_what_the_robot_refuses_is_one_line(client):
    with pytest.raises(
        DeviceError, match=r"refuses: the goal .* holds characters that are no text"
    ):
        client.ask(["so\x07fa"])
    with pytest.raises(DeviceError, match=r"refuses: texts.0: it must have at most 200 letters"):
        client.ask(["a" * 300])


STATE = {
    "stopped": False, "wheel": None, "goals": [], "steps_per_second": 1.0, "base": None, "log": [],
    "step": None, "activity": "", "map_view": None,
}  # fmt: skip
ANSWERS = {
    "no object": b"[]",
    "a number": b"5",
    "null": b"null",
    "nothing of a robot": b"{}",
    "half a state": json.dumps(STATE | {"goals": [{"number": 1}]}).encode(),
    "another type": json.dumps(STATE | {"base": 5}).encode(),
    "numbers that are none": b'{"numbers": ["x"]}',
    "HTML": b"<html>",
    "no text": b"\xff\xfe\x00",
    "an abyss": b"[" * 100_000,
    "NaN": b"NaN",
}
ASKED = {
    "goal": lambda client: remote.ask(client, ["sofa"], at_once=False, wait=True),
    "explore": lambda client: remote.explore(client, at_once=False, wait=True),
    "stop": remote.stop,
    "status": lambda client: remote.status(client, as_json=False),
}


@pytest.mark.sampled
@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("status", [200, 404])
@pytest.mark.parametrize("answer", ANSWERS)
def test_a_server_that_is_no_vizbot_is_an_error_in_one_line(asked, answer, status):
    transport = httpx.MockTransport(lambda _: httpx.Response(status, content=ANSWERS[answer]))
    with (
        RobotClient("http://printer", None, transport) as client,
        pytest.raises(DeviceError, match="http://printer") as refusal,
    ):
        ASKED[asked](client)
    assert len(str(refusal.value).splitlines()) == 1


def test_a_stop_is_sent_before_anything_but_the_standard_library_is_loaded(session):
    script = (
        "import atexit, sys\n"
        "atexit.register(lambda: print(*sys.modules, file=sys.stderr))\n"
        "from vizbot.cli.process import run\n"
        "run()\n"
    )
    with served(session) as server:
        command = [sys.executable, "-c", script, "stop", "--token", "any", f"--url={server.url}"]
        ended = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ended.stdout == "stopped\n" and session.stopped.is_set()
    loaded = {name.partition(".")[0] for name in ended.stderr.split()}
    ours = {"vizbot", "_editable_impl_vizbot", "_distutils_hack", "__main__"}
    assert loaded - ours - set(sys.stdlib_module_names) <= {"sitecustomize", "usercustomize"}
    assert "ssl" not in loaded and "vizbot" in loaded


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--url", "robot:8787"), ("--url 'robot:8787' is no address", "http://robot:8787")),
        (("--url", "http://robot:port"), ("--url http://robot:port", "give one like")),
        (("--url=http://127.0.0.1:9",), ("no robot answers at http://127.0.0.1:9", "Connection")),
        (("--speed", "9"), ("No such option: --speed", "vizbot stop --help")),
        (("now",), ("unexpected extra argument(s) (now)", "vizbot stop --help")),
    ],
)
def test_a_stop_that_cannot_be_sent_is_one_line(arguments, words):
    command = [sys.executable, "-m", "vizbot", "stop", *arguments]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr.count("\n")) == (1, "", 1)
    assert all(word in ended.stderr for word in words), ended.stderr


def test_a_stop_goes_where_the_environment_says_and_has_a_help(session):
    command = [sys.executable, "-m", "vizbot", "stop"]
    with served(session) as server:
        environment = os.environ | {"VIZBOT_URL": server.url}
        subprocess.run(command, env=environment, capture_output=True, check=True)
    assert session.stopped.is_set()
    shown = subprocess.run([*command, "--help"], capture_output=True, text=True, check=True)
    assert "Stop a running robot" in shown.stdout and "--url" in shown.stdout
