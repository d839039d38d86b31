"""Opening the Roomba driver on ports that have none, or one that will not serve."""

import functools
import itertools
import os
import random
import tty
from pathlib import Path
from types import SimpleNamespace

import pytest
import serial

from drivers.roomba.commands import Opcode, encode
from drivers.roomba.packets import Packet
from drivers.roomba.serial_port import open_serial
from drivers.roomba.state import STREAMED
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.body import FreeFloor
from tests.helpers.failing import raising
from tests.helpers.roomba_rig import open_lockstep
from vizbot.core.errors import DeviceError
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import BaseMode

PERIOD = 0.015


def open_files():
    return len(list(Path("/proc/self/fd").iterdir()))


class OneTooHigh:
    """A lockstep base whose firmware reports every mode as the next one."""

    def __init__(self, stub):
        self.stub = stub
        self.advance = stub.advance

    def publish(self):
        self.stub.overrides[Packet.OI_MODE] = min(3, self.stub.mode + 1)
        self.stub.publish()


@pytest.mark.parametrize("mode_offset", [None, 1])
def test_firmware_that_reports_its_mode_one_too_high_is_found_out(mode_offset):
    clock = SimulatedClock()
    with SimulatedRoomba(FreeFloor()) as stub:
        clock.attach(OneTooHigh(stub))
        port = stub.lockstep_port(open_serial(stub.path))
        with open_lockstep(lambda: port, clock, mode_offset=mode_offset) as base:
            assert base.read().mode is BaseMode.SAFE
            assert stub.mode is BaseMode.SAFE


@pytest.mark.parametrize("left_in", [128, 131, 132])
def test_a_base_that_another_program_left_speaking_is_not_taken_for_such_firmware(left_in):
    clock = SimulatedClock()
    with SimulatedRoomba(FreeFloor()) as stub:
        clock.attach(stub)
        port = stub.lockstep_port(open_serial(stub.path))
        port.write(bytes([128, left_in]) + encode(Opcode.STREAM, *STREAMED))
        clock.sleep(10 * PERIOD)
        with open_lockstep(lambda: port, clock) as base:
            clock.sleep(1.0)
            assert base.read().mode is stub.mode is BaseMode.SAFE


@pytest.mark.parametrize("source", [2, 1])
def test_a_base_that_cannot_enter_safe_mode_is_an_error(source):
    with SimulatedRoomba(FreeFloor()) as stub:
        clock = SimulatedClock()
        clock.attach(stub)
        stub.overrides[Packet.CHARGING_SOURCES] = source
        before = open_files()
        with pytest.raises(DeviceError, match="stays in Passive mode; take it off its charger"):
            open_lockstep(
                lambda: stub.lockstep_port(open_serial(stub.path)), clock, start_timeout=0.3
            )
        assert open_files() == before


class Terminal:
    """A pseudo-terminal that is not a Roomba; a lockstep device that says what it is given."""

    def __init__(self, sayings):
        self.robot, host = os.openpty()
        tty.setraw(host)
        self.path = os.ttyname(host)
        self.host = host
        self.sayings = sayings

    def publish(self):
        os.write(self.robot, next(self.sayings))

    def advance(self, seconds):
        pass

    def close(self):
        os.close(self.robot)
        os.close(self.host)


@pytest.mark.parametrize(
    "sayings",
    [
        itertools.repeat(b""),
        itertools.repeat(b"U-Boot 2024.01 login: \x13\x0a\x07\x13"),
        map(random.Random(0).randbytes, itertools.repeat(40)),
    ],
    ids=["silence", "text", "random bytes"],
)
def test_a_port_that_is_not_a_roomba_is_one_line_with_nothing_left_open(sayings):
    clock, terminal = SimulatedClock(), Terminal(sayings)
    clock.attach(terminal)
    before = open_files()
    try:
        with pytest.raises(DeviceError, match="is not a Roomba or is asleep") as caught:
            open_lockstep(functools.partial(open_serial, terminal.path), clock, start_timeout=0.15)
        assert terminal.path in str(caught.value)
        assert "\n" not in str(caught.value)
        assert "press Clean" in str(caught.value)
        assert open_files() == before
        clock.sleep(PERIOD)  # Nothing of it runs on.
    finally:
        terminal.close()


def test_a_port_that_fails_while_starting_is_closed():
    closed, clock = [], SimulatedClock()
    port = SimpleNamespace(
        name="/dev/broken",
        in_waiting=0,
        read=raising(serial.SerialException("device reports readiness but returned no data")),
        write=raising(serial.SerialException("write failed")),
        close=lambda: closed.append(True),
    )
    with pytest.raises(DeviceError, match="/dev/broken: the base is gone"):
        open_lockstep(lambda: port, clock, reconnect_timeout=0)
    assert closed == [True]
