"""`vizbot launch` on a software D435i and a simulated Roomba that live on the wall clock."""

import os
import signal
import socket
import sys
import tempfile
import threading
import time
from contextlib import contextmanager

import httpx
import numpy as np
import pytest
from rerun.chunk import RrdReader

from drivers.realsense.sdk import rs
from mapping import map_bundle
from sim_stubs.realsense.software_device import SoftwareD435i
from tests.helpers.filmed_room import RATE, filmed, settings
from tests.helpers.roomba_rig import ASKED_EVERY, DEADLINE, wait_for
from tests.helpers.served import arrived
from vizbot.commands import launch
from vizbot.core.geometry import yaw_of
from vizbot.operator.language.dialogue import Dialogue


@pytest.fixture
def robot_toml(floor, stub, tmp_path, monkeypatch):
    """Settings of a robot whose devices are plugged in."""
    camera = SoftwareD435i(fps=RATE)
    context = camera.plug_in()
    monkeypatch.setattr(rs, "context", lambda: context)
    toml = tmp_path / "robot.toml"
    toml.write_text(settings(stub.path))
    with filmed(camera, floor):
        yield toml


@contextmanager
def typing(monkeypatch):
    """Somebody at the keyboard."""
    reader, writer = os.pipe()
    with os.fdopen(reader) as typed, os.fdopen(writer, "w", buffering=1) as keyboard:
        monkeypatch.setattr(sys, "stdin", typed)
        yield keyboard


def attend(url, keyboard, floor, end):
    """Ask at the keyboard, stop over the network, end."""
    try:
        with httpx.Client(base_url=url) as robot:
            wait_for(lambda: answers(robot) and robot.get("/state").json()["step"], ASKED_EVERY)
            before, began = yaw_of(floor.T_world_base), robot.get("/state").json()["step"]
            keyboard.write("red lamp\n")
            wait_for(lambda: abs(yaw_of(floor.T_world_base) - before) > 0.5)
            wait_for(lambda: robot.get("/state").json()["step"] > began + 3, ASKED_EVERY)
            (goal,) = robot.get("/state").json()["goals"]
            assert (goal["text"], goal["outcome"]) == ("red lamp", None)
            robot.post("/stop")
            wait_for(lambda: rests(floor))
            assert robot.get("/state").json()["stopped"]
    finally:
        end(keyboard)


def answers(robot):
    try:
        return robot.get("/state").is_success
    except httpx.ConnectError:
        return False


def rests(floor):
    before = floor.T_world_base
    time.sleep(0.3)
    return np.array_equal(before, floor.T_world_base)


ENDS = {
    "an empty line": lambda keyboard: keyboard.write("\n"),
    "Ctrl-C": lambda keyboard: os.kill(os.getpid(), signal.SIGINT),
}


@pytest.mark.slow
@pytest.mark.parametrize("end", ENDS)
def test_a_robot_is_launched_asked_stopped_and_ended(
    end, robot_toml, floor, tmp_path, signals, monkeypatch, command_line
):
    run = tmp_path / "run"
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    command = ["launch", "--force", "--clip", "embedded", "--config", robot_toml, "--out", run]
    command += ["--port", port, "--rerun"]
    with typing(monkeypatch) as keyboard:
        url = f"http://127.0.0.1:{port}"
        person = threading.Thread(target=attend, args=(url, keyboard, floor, ENDS[end]))
        person.start()
        code, out, err = command_line(*command)
        person.join()
    assert not code and "interrupted" not in err, err
    assert out.strip() == str(run / "report.html") and (run / "report.html").exists()
    assert len(map_bundle.load(run / "map").elements.keyframes) > 0
    log = (run / "vizbot.log").read_text()
    for event in (
        "camera realsense, base roomba",
        f":{port}",
        "map saved",
        "ended: error None, steps",
    ):
        assert event in log
    commands = np.loadtxt(run / "commands.csv", delimiter=",", skiprows=1, usecols=range(3))
    assert np.abs(commands[:, 2]).max() > 0.0
    recorded = {chunk.entity_path for chunk in RrdReader(run / "run.rrd").stream()}
    assert {"/map/robot", "/plots/battery"} <= recorded


def type_in(monkeypatch, typed, session):
    """All that is typed into a running robot, as bytes."""
    with tempfile.TemporaryFile() as file:
        file.write(typed)
        file.seek(0)
        monkeypatch.setattr(sys, "stdin", file)
        launch._take_dictation(session)


def test_a_stop_waits_for_no_verdict(session, monkeypatch):
    stopped = []
    arrived(session)

    def judge(confirmed, who):
        stopped.append(session.stopped.wait(DEADLINE))
        return []

    monkeypatch.setattr(session, "judge", judge)
    type_in(monkeypatch, b"no\nstop\n", session)
    wait_for(lambda: stopped)
    assert stopped == [True]


@pytest.mark.parametrize("line", [b"caf\xe9", 10_000_000 * b"?"], ids=["no text", "no end"])
def test_a_stop_is_obeyed_after_an_odd_line(session, monkeypatch, line):
    type_in(monkeypatch, line + b"\nstop\n", session)
    assert session.stopped.is_set() and not session.closed.is_set()


def test_a_stop_is_obeyed_after_a_line_that_fails(session, monkeypatch, capsys):
    typed = Dialogue.typed

    def fail_or_obey(sentences, text, who):
        if text == "sofa":
            raise RuntimeError("of all\nthings")
        return typed(sentences, text, who)

    monkeypatch.setattr(Dialogue, "typed", fail_or_obey)
    type_in(monkeypatch, b"sofa\nstop\n", session)
    assert session.stopped.is_set()
    assert capsys.readouterr().err == "of all things\nstopped\n"
