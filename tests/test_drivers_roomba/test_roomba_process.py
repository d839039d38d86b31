"""The process that owns the port of the base."""

import logging
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.channel import Outbox, open_channel
from drivers.roomba.reflex_process.process_link import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from drivers.roomba.service import Drive, Trouble
from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from sim_stubs.roomba.dock import SimulatedDock
from sim_stubs.world.body import FreeFloor
from tests.helpers.roomba_rig import (
    DEADLINE,
    HangingAddress,
    SleepyAddress,
    TimedFloor,
    resting,
    wait_for,
)
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.geometry import planar
from vizbot.core.types import STOP, BaseMode, BaseState, Twist

pytestmark = pytest.mark.alone
CLOCK = WallClock()
PROGRAM = """
import sys
from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.process_link import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from vizbot.core.clock import WallClock
from vizbot.core.types import Twist

clock, config = WallClock(), RoombaConfig()
base = Roomba(ProcessLink(SerialAddress(sys.argv[1]).open, config), clock, config)
while True:
    base.drive(Twist(0.2, 0.0))
    clock.sleep(0.02)
"""
DOCKING = PROGRAM.replace("while True:", "base.dock()\nwhile True:")


class RestingFloor(FreeFloor):
    """An empty floor that counts how often the wheels were stopped."""

    def __init__(self):
        super().__init__()
        self.speeds, self.stops = (0.0, 0.0), 0

    def set_wheel_speeds(self, left, right):
        self.stops += (left, right) == (0.0, 0.0) != self.speeds
        self.speeds = left, right
        super().set_wheel_speeds(left, right)


@pytest.fixture
def floor():
    return RestingFloor()


@pytest.fixture
def stub(floor):
    with on_wall_clock(SimulatedRoomba(floor)) as stub:
        yield stub


@contextmanager
def served(address, **settings):
    """A base whose port a process of its own serves, and the link to that."""
    config = RoombaConfig(**settings)
    link = ProcessLink(address.open, config)
    with Roomba(link, CLOCK, config) as base:
        yield base, link


@pytest.fixture
def driving(stub, floor):
    """A program that drives until it is killed."""
    program = subprocess.Popen([sys.executable, "-c", PROGRAM, stub.path])
    wait_for(lambda: floor.wheel_travel[0] > 0.02)
    yield program
    program.kill()
    program.wait()
    # Who stops the wheels for it must not find the next stub, which may get the same path.
    wait_for(lambda: stub.mode is BaseMode.PASSIVE)


def test_killing_the_program_leaves_somebody_to_stop_the_wheels(stub, floor, driving):
    driving.kill()
    wait_for(lambda: stub.mode is BaseMode.PASSIVE)
    assert resting(floor)


def test_a_program_that_hangs_does_not_keep_the_wheels_turning(stub, floor, driving):
    driving.send_signal(signal.SIGSTOP)
    wait_for(lambda: resting(floor))
    assert stub.mode is BaseMode.SAFE
    driving.send_signal(signal.SIGCONT)
    wait_for(lambda: not resting(floor))


def state(stamp, **felt):
    floor = (False,) * 4, (False,) * 2
    return BaseState(stamp, np.eye(4), False, False, *floor, 1.0, BaseMode.SAFE, **felt)


@pytest.fixture
def pipe():
    ours, theirs = open_channel()
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


def test_the_end_of_the_watchdog_is_an_error_and_the_wheels_are_stopped(stub, floor):
    with served(SerialAddress(stub.path)) as (base, link):
        assert os.getsid(link.pid) == link.pid  # Ctrl-Z at the terminal does not reach it
        link.send(Drive(Twist(0.2, 0.0), CLOCK.now()))
        wait_for(lambda: not resting(floor))
        os.kill(link.pid, signal.SIGKILL)
        with pytest.raises(DeviceError, match="the process of the base ended"):
            wait_for(lambda: base.read() is None)
        for call in (base.read, lambda: base.drive(Twist(0.1, 0.0))):
            with pytest.raises(DeviceError, match="the process of the base ended"):
                call()
        wait_for(lambda: resting(floor))
        wait_for(lambda: stub.mode is BaseMode.PASSIVE)


def service_of(link):
    """The process that owns the port, the only child of its watchdog; None while it is replaced."""
    return next(iter(children_of(link.pid)), None)


def drive_until(base, condition):
    def driven():
        base.drive(Twist(0.2, 0.0))
        return condition()

    wait_for(driven, pause=0.01)


HARMS = {
    "killed": lambda link, hang: os.kill(service_of(link), signal.SIGKILL),
    "stopped by a signal": lambda link, hang: os.kill(service_of(link), signal.SIGSTOP),
    "busy for ever": lambda link, hang: hang.touch(),
}


@pytest.mark.parametrize("harm", HARMS)
def test_a_service_that_fails_is_replaced_and_the_wheels_rest_before(
    harm, stub, floor, tmp_path, caplog
):
    hang = tmp_path / "hang"
    with served(HangingAddress(stub.path, hang)) as (base, link):
        drive_until(base, lambda: floor.speeds[0] > 0.15)
        before, stops = service_of(link), floor.stops
        HARMS[harm](link, hang)
        drive_until(base, lambda: floor.stops > stops)
        drive_until(base, lambda: floor.speeds[0] > 0.15)
        assert service_of(link) != before
        assert "stopping the wheels" in caplog.text
        wait_for(lambda: resting(floor))
        wait_for(lambda: abs(base.read().T_odom_base[0, 3] - floor.T_world_base[0, 3]) < 1e-3)


def test_a_base_on_its_way_to_the_dock_is_left_to_it_by_the_next_service(stub, floor):
    with served(SerialAddress(stub.path)) as (base, link):
        base.dock()
        wait_for(lambda: not base.read().mode.obeys)
        before = service_of(link)
        os.kill(before, signal.SIGKILL)
        wait_for(lambda: service_of(link) not in (before, None))
        killed = CLOCK.now()
        while CLOCK.now() < killed + 1.0:
            base.drive(STOP)
            with suppress(DeviceTimeoutError):
                assert not base.read().mode.obeys
            assert stub.mode is BaseMode.PASSIVE
        assert base.read().stamp > killed
        base.resume()
        wait_for(lambda: base.read().mode is BaseMode.SAFE)


def test_a_service_that_fails_again_and_again_is_given_up(stub, floor):
    with served(SerialAddress(stub.path)) as (base, link):
        for _ in range(4):
            wait_for(lambda: service_of(link))
            before = service_of(link)
            os.kill(before, signal.SIGKILL)
            wait_for(lambda: service_of(link) != before)  # noqa: B023
        with pytest.raises(DeviceError, match="the process of the base ended"):
            wait_for(lambda: base.read() is None)
        assert resting(floor)


def test_a_program_that_dies_beside_a_service_that_hangs_leaves_wheels_at_rest(
    stub, floor, driving
):
    watchdog, service = pair_of(driving)
    os.kill(service, signal.SIGSTOP)
    driving.kill()
    wait_for(lambda: stub.mode is BaseMode.PASSIVE)
    assert resting(floor)
    wait_for(lambda: not Path(f"/proc/{watchdog}").exists())


def children_of(pid):
    return [int(n) for n in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def pair_of(program):
    """The watchdog of a driving program and its service."""
    watchdog = children_of(program.pid)[-1]
    return [watchdog, *children_of(watchdog)]


def test_a_machine_that_pauses_as_a_whole_is_no_hang(stub, floor, driving):
    pair = pair_of(driving)
    for number in (signal.SIGSTOP, signal.SIGCONT):
        for pid in (driving.pid, *pair):
            os.kill(pid, number)
        time.sleep(0.6)
    wait_for(lambda: not resting(floor))
    assert pair_of(driving) == pair


@pytest.fixture
def timed():
    floor = TimedFloor()
    with on_wall_clock(SimulatedRoomba(floor)) as stub:
        yield stub, floor


@pytest.mark.parametrize("both", [True, False])
def test_a_watchdog_that_hangs_is_killed_by_the_program_which_stops_the_wheels(timed, both, caplog):
    stub, floor = timed
    with served(SerialAddress(stub.path)) as (base, link):
        drive_until(base, lambda: floor.speeds[0] > 0.15)
        watchdog, service = link.pid, service_of(link)
        hung = time.monotonic()
        for pid in (service, watchdog) if both else (watchdog,):
            os.kill(pid, signal.SIGSTOP)
        drive_until(base, lambda: floor.rest_since is not None)
        assert floor.rest_since - hung < 0.6
        assert "gave no sign of life for 0.35 s: stopped the wheels" in caplog.text
        for pid in (service, watchdog):
            wait_for(lambda pid=pid: not Path(f"/proc/{pid}").exists())
        wait_for(lambda: link.pid != watchdog and service_of(link))
        assert floor.rest_since is not None  # until there is a new pair
        drive_until(base, lambda: moves_again(base, floor))
        wait_for(lambda: floor.speeds == (0.0, 0.0))
        wait_for(lambda: abs(base.read().T_odom_base[0, 3] - floor.T_world_base[0, 3]) < 1e-3)


def moves_again(base, floor):
    """Whether it drives; where that took longer than a moment somebody says to go on."""
    with suppress(DeviceTimeoutError):
        if base.read().maybe_moved:
            assert floor.speeds == (0.0, 0.0)
            base.resume()
    return floor.speeds[0] > 0.15


def test_a_pair_that_hangs_again_and_again_is_given_up(timed):
    stub, floor = timed
    with served(SerialAddress(stub.path)) as (base, link):
        for ends in range(1, 5):
            wait_for(lambda: service_of(link))
            watchdog = link.pid
            os.killpg(watchdog, signal.SIGSTOP)
            if ends < 4:
                wait_for(lambda: link.pid != watchdog)  # noqa: B023

        def given_up():
            try:
                base.read()
            except DeviceError as error:
                return "the process of the base ended" in str(error)

        wait_for(given_up)
        assert floor.speeds == (0.0, 0.0)


def test_a_pair_that_hangs_while_the_link_is_closed_leaves_wheels_at_rest(timed):
    stub, floor = timed
    with served(SerialAddress(stub.path)) as (base, link):
        drive_until(base, lambda: floor.speeds[0] > 0.15)
        os.killpg(link.pid, signal.SIGSTOP)
    assert not link._process.is_alive()
    wait_for(lambda: floor.speeds == (0.0, 0.0) and stub.mode is BaseMode.PASSIVE)


def test_a_program_that_hangs_while_the_base_seeks_its_dock_leaves_wheels_at_rest():
    floor = TimedFloor()
    dock = SimulatedDock(planar(2.0, 0.3, 3.14))
    with on_wall_clock(SimulatedRoomba(floor, dock=dock)) as stub:
        program = subprocess.Popen([sys.executable, "-c", DOCKING, stub.path])
        try:
            wait_for(lambda: stub.mode is BaseMode.PASSIVE and floor.wheel_travel[0] != 0.0)
            hung = time.monotonic()
            program.send_signal(signal.SIGSTOP)
            wait_for(lambda: floor.rest_since is not None and stub.mode is BaseMode.SAFE)
            assert floor.rest_since - hung < 0.6
            before = floor.wheel_travel
            time.sleep(1.0)
            assert floor.wheel_travel == before
        finally:
            program.kill()
            program.wait()
            wait_for(lambda: stub.mode is BaseMode.PASSIVE)


def test_a_machine_that_was_suspended_stops_the_wheels_before_it_drives_on(
    stub, floor, tmp_path, caplog
):
    suspended = tmp_path / "suspended"
    with served(SleepyAddress(stub.path, suspended)) as (base, link):
        drive_until(base, lambda: floor.speeds[0] > 0.15)
        service, stops = service_of(link), floor.stops
        suspended.touch()
        drive_until(base, lambda: floor.stops > stops)
        drive_until(base, lambda: floor.speeds[0] > 0.15)
        assert service_of(link) == service
        assert "this machine was suspended" in caplog.text


def test_a_port_that_cannot_be_opened_is_the_error_that_it_is():
    with pytest.raises(DeviceError, match=r"/dev/ttyNONE: no such port"):
        ProcessLink(SerialAddress("/dev/ttyNONE").open, RoombaConfig())


def test_what_the_process_logs_is_logged_here(stub, caplog):
    with served(SerialAddress(stub.path), full_mode=True):
        assert "Full mode" in caplog.text


def test_a_base_that_falls_silent_is_a_timeout(stub, monkeypatch):
    with served(SerialAddress(stub.path)) as (base, _):
        monkeypatch.setattr(stub, "publish", lambda: None)
        end = CLOCK.now() + DEADLINE
        with pytest.raises(DeviceTimeoutError, match=r"no answer from the base"):
            while CLOCK.now() < end:
                base.read()


def test_who_leaves_while_the_base_is_gone_hears_how_the_wheels_are_stopped(floor, caplog):
    clock, config = WallClock(), RoombaConfig(reconnect_timeout=3.0)
    with on_wall_clock(SimulatedRoomba(floor)) as stub:
        link = ProcessLink(SerialAddress(stub.path).open, config)
        base = Roomba(link, clock, config)
    base.close()
    assert f"{stub.path}: the wheels could not be stopped yet; plug the base's cable" in caplog.text
    assert "within 3 s of its loss" in caplog.text
    wait_for(lambda: not link._process.is_alive())
