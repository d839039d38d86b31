"""Driving a running robot by hand from another program."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from tests.helpers.roomba_rig import wait_for
from tests.helpers.served import served
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.types import STOP, BaseMode, BaseState, Charging, Twist
from vizbot.operator.client import remote_drive
from vizbot.operator.client.base_json import base_report, base_state_of
from vizbot.operator.client.remote_drive import RemoteDrive
from vizbot.operator.client.robot_client import RobotClient

AHEAD = Twist(0.2, 0.1)
STATE = BaseState(
    1.0, np.eye(4), True, False, (False, True, False, False), (False, True), 0.75,
    BaseMode.PASSIVE, True, (True, False), charging=Charging.FAULT, plugged_in=True,
)  # fmt: skip


@pytest.fixture
def session(session):
    session.robot.base_state = lambda: STATE
    return session


def test_what_the_base_says_comes_back_as_it_was():
    again = base_state_of(base_report(STATE), 1.0)
    assert base_report(again) == base_report(STATE)
    same = replace(again, T_odom_base=STATE.T_odom_base)
    assert all(
        getattr(same, name) is getattr(STATE, name) or getattr(same, name) == getattr(STATE, name)
        for name in BaseState.__slots__
    )


def test_the_wheel_is_taken_driven_and_let_go(client, session):
    resumed = []
    session.robot.resume_base = lambda: resumed.append(True)
    with RemoteDrive(client, "ann") as drive:
        wait_for(lambda: session.lease.holder == "ann")

        def rolls():
            drive.drive(AHEAD)
            return session.lease.twist() == AHEAD

        wait_for(rolls, pause=0.02)
        wait_for(lambda: session.lease.twist() == STOP)  # nothing more was told
        drive.resume()
        assert resumed == [True]
    wait_for(lambda: session.lease.holder is None)


def test_only_who_ends_as_they_should_gives_the_wheel_back(client, session):
    with RemoteDrive(client, "ann"):
        pass
    wait_for(lambda: session.lease.holder is None)
    assert not session.stopped.is_set()
    with pytest.raises(DeviceError, match="terminal"), RemoteDrive(client, "ann"):
        raise DeviceError("the terminal is gone")
    wait_for(lambda: session.lease.holder is None)
    assert session.stopped.is_set()


def test_the_state_of_the_base_is_told(client):
    with RemoteDrive(client, "ann") as drive:

        def told():
            try:
                return drive.read().mode is BaseMode.PASSIVE
            except DeviceTimeoutError:
                return False

        wait_for(told)


def test_where_somebody_else_drives_one_line_says_who(client, session):
    with RemoteDrive(client, "ann") as ann:
        with RemoteDrive(client, "bob") as bob:
            wait_for(lambda: _fails(bob), pause=0.02)
            with pytest.raises(DeviceError, match="ann drives; try --over"):
                bob.drive(AHEAD)
        with RemoteDrive(client, "bob", over=True):
            wait_for(lambda: session.lease.holder == "bob")
            wait_for(lambda: _fails(ann), pause=0.02)


def test_where_somebody_stops_the_robot_the_line_does_not_say_that_they_drive(client, session):
    with RemoteDrive(client, "ann") as ann:
        wait_for(lambda: session.lease.holder == "ann")
        for _ in range(3):
            ann.drive(AHEAD)
        session.stop("bob")
        wait_for(lambda: _fails(ann), pause=0.02)
        with pytest.raises(DeviceError, match="the robot was stopped"):
            ann.drive(AHEAD)


def test_why_the_link_ended_is_told_though_it_is_read_late(client, session, monkeypatch):
    with RemoteDrive(client, "ann") as ann:
        failed = threading.Event()
        send = ann._socket.send

        def send_at_last(text):
            try:
                send(text)
            except ConnectionClosed:
                failed.set()
                raise

        def read_late(holder):
            assert failed.wait(5.0)
            time.sleep(0.1)
            return f"{holder} drives"

        monkeypatch.setattr(ann._socket, "send", send_at_last)
        monkeypatch.setattr(remote_drive, "_refusal", read_late)
        wait_for(lambda: session.lease.holder == "ann" and ann._robot_time is not None)
        session.take_lease("bob", over=True)
        with pytest.raises(DeviceError, match="bob drives"):
            wait_for(lambda: ann.drive(AHEAD), pause=0.02)


def _fails(drive):
    try:
        drive.drive(STOP)
    except DeviceError:
        return True
    return False


def test_where_no_robot_is_one_line_says_so():
    with (
        RobotClient("http://127.0.0.1:9", None) as client,
        pytest.raises(DeviceError, match="cannot be driven"),
    ):
        RemoteDrive(client, "ann")


def test_where_a_token_was_asked_for_one_line_says_that_none_was_sent(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with served(host="0.0.0.0") as server:
        with (
            RobotClient(server.url, "") as client,
            pytest.raises(DeviceError, match=r"403; no token was sent: give --token"),
        ):
            RemoteDrive(client, "ann")
        with (
            RobotClient(server.url, "wrong" * 5) as client,
            pytest.raises(DeviceError, match=r"HTTP 403$"),
        ):
            RemoteDrive(client, "ann")
