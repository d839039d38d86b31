"""The process that owns the port of the base."""

import logging
import multiprocessing
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.process import Outbox, ProcessLink
from drivers.roomba.serial_port import SerialAddress
from drivers.roomba.service import Drive, Trouble
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.roomba.wall_clock import on_wall_clock
from sim_stubs.world.free_floor import FreeFloor
from tests.helpers.roomba_rig import DEADLINE, wait_for
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.types import BaseMode, BaseState, Twist

PROGRAM = """
import sys
from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.process import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from vizbot.core.clock import WallClock
from vizbot.core.types import Twist

clock, config = WallClock(), RoombaConfig()
base = Roomba(ProcessLink(SerialAddress(sys.argv[1]).open, config), clock, config)
while True:
    base.drive(Twist(0.2, 0.0))
    clock.sleep(0.02)
"""


@pytest.fixture
def floor():
    return FreeFloor()


@pytest.fixture
def stub(floor):
    with on_wall_clock(SimulatedRoomba(floor)) as stub:
        yield stub


@pytest.fixture
def driving(stub, floor):
    """A program that drives until it is killed."""
    program = subprocess.Popen([sys.executable, "-c", PROGRAM, stub.path])
    wait_for(lambda: floor.wheel_travel[0] > 0.02)
    yield program
    program.kill()
    program.wait()


def still(floor):
    """Whether the wheels rest for some sensor frames."""
    before, end = floor.wheel_travel, time.monotonic() + 0.1
    while time.monotonic() < end:
        if floor.wheel_travel != before:
            return False
    return True


def test_killing_the_program_leaves_somebody_to_stop_the_wheels(stub, floor, driving):
    driving.kill()
    wait_for(lambda: stub.mode is BaseMode.PASSIVE)
    assert still(floor)


def test_a_program_that_hangs_does_not_keep_the_wheels_turning(stub, floor, driving):
    driving.send_signal(signal.SIGSTOP)
    wait_for(lambda: still(floor))
    assert stub.mode is BaseMode.SAFE
    driving.send_signal(signal.SIGCONT)
    wait_for(lambda: not still(floor))


def state(stamp, **felt):
    floor = (False,) * 4, (False,) * 2
    return BaseState(stamp, np.eye(4), False, False, *floor, 1.0, BaseMode.SAFE, **felt)


@pytest.fixture
def pipe():
    ours, theirs = multiprocessing.Pipe()
    yield ours, Outbox(theirs)
    theirs.close()
    ours.close()


def received(ours, outbox):
    reports = []
    while ours.poll():
        reports.append(ours.recv())
        outbox.send([])
    return reports


def test_a_reader_that_does_not_read_is_not_waited_for(pipe):
    ours, outbox = pipe
    for number in range(5000):
        outbox.send([state(float(number))])
    stamps = [report.stamp for report in received(ours, outbox)]
    assert stamps[-1] == 4999.0
    assert stamps[:3] == [0.0, 1.0, 2.0]
    assert len(stamps) < 5000


def test_who_did_not_read_for_long_hears_of_every_trouble_and_contact_all_the_same(pipe, caplog):
    ours, outbox = pipe
    for number in range(3000):
        felt = {"virtual_wall": True} if number == 1500 else {}
        outbox.send([Trouble("gone")] if number == 1000 else [])
        outbox.send([Trouble("")] if number == 2000 else [])
        outbox.send([state(float(number), **felt)])
        outbox.emit(logging.makeLogRecord({"msg": f"line {number}"}))
    reports = received(ours, outbox)
    assert len(reports) < 3000
    assert [each.message for each in reports if isinstance(each, Trouble)] == ["gone", ""]
    states = [each for each in reports if isinstance(each, BaseState)]
    assert [each.virtual_wall for each in states].count(True) == 1
    assert states[-1].stamp == 2999.0
    assert reports[-1].msg == "line 2999"


def test_the_end_of_the_process_is_an_error_and_the_wheels_are_stopped(stub, floor):
    clock, config = WallClock(), RoombaConfig()
    link = ProcessLink(SerialAddress(stub.path).open, config)
    with Roomba(link, clock, config) as base:
        assert os.getsid(link.pid) == link.pid  # Ctrl-Z at the terminal does not reach it
        link.send(Drive(Twist(0.2, 0.0), clock.now()))
        wait_for(lambda: not still(floor))
        os.kill(link.pid, signal.SIGKILL)
        link._process.join()
        for call in (base.read, lambda: base.drive(Twist(0.1, 0.0))):
            with pytest.raises(DeviceError, match="the process of the base ended"):
                call()
        wait_for(lambda: still(floor))
        wait_for(lambda: stub.mode is BaseMode.PASSIVE)


def test_a_port_that_cannot_be_opened_is_the_error_that_it_is():
    with pytest.raises(DeviceError, match=r"/dev/ttyNONE: no such port"):
        ProcessLink(SerialAddress("/dev/ttyNONE").open, RoombaConfig())


def test_what_the_process_logs_is_logged_here(stub, caplog):
    clock, config = WallClock(), RoombaConfig(full_mode=True)
    with Roomba(ProcessLink(SerialAddress(stub.path).open, config), clock, config):
        assert "Full mode" in caplog.text


def test_a_base_that_falls_silent_is_a_timeout(stub, monkeypatch):
    clock, config = WallClock(), RoombaConfig()
    with Roomba(ProcessLink(SerialAddress(stub.path).open, config), clock, config) as base:
        monkeypatch.setattr(stub, "publish", lambda: None)
        end = clock.now() + DEADLINE
        with pytest.raises(DeviceTimeoutError, match=r"no answer from the base"):
            while clock.now() < end:
                base.read()
