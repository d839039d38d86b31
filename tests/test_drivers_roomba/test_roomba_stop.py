"""The wheels stop, whatever happens to the line, the program or its close()."""

import pytest
import serial

from drivers.roomba.commands import CommandParser, Opcode
from drivers.roomba.drive_command import SURE_STOP
from drivers.roomba.serial_port import open_serial
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.body import FreeFloor
from tests.helpers.roomba_rig import WrappedPort, open_lockstep
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import BaseMode, Twist


class FaultyPort(WrappedPort):
    """A serial port whose next writes go wrong as told: each entry is what is sent before it."""

    def __init__(self, port):
        super().__init__(port)
        self.faults = []
        self.error = serial.SerialTimeoutException("Write timeout")

    def write(self, sent):
        if self.faults:
            self.port.write(sent[: self.faults.pop(0)])
            raise self.error
        return self.port.write(sent)


@pytest.fixture
def driving():
    """A base that drives at 0.2 m/s over a line that can be made to fail."""
    clock, floor = SimulatedClock(), FreeFloor()
    with SimulatedRoomba(floor) as stub:
        clock.attach(stub)
        ports = []

        def open_port():
            ports.append(FaultyPort(stub.lockstep_port(open_serial(stub.path))))
            return ports[-1]

        base = open_lockstep(open_port, clock)
        for _ in range(20):
            base.drive(Twist(0.2, 0.0))
            clock.sleep(0.03)
        assert speed(floor, clock) == pytest.approx(0.2, abs=0.02)
        yield base, ports[0], floor, clock
        base.close()


def speed(floor, clock):
    before = floor.wheel_travel
    clock.sleep(0.15)
    return max(abs(now - then) for now, then in zip(floor.wheel_travel, before, strict=True)) / 0.15


@pytest.mark.parametrize("cut", range(10))
def test_a_write_that_fails_after_any_byte_costs_that_write_alone(driving, cut):
    base, port, floor, clock = driving
    port.faults = [cut]
    base.drive(Twist(0.2, 0.0))
    assert speed(floor, clock) == pytest.approx(0.2, abs=0.02)
    assert port.faults == []
    clock.sleep(0.3)
    assert speed(floor, clock) == 0.0


def test_the_stop_is_repeated_until_the_line_takes_it(driving):
    _, port, floor, clock = driving
    port.faults = [0] * 30
    clock.sleep(0.5)
    assert speed(floor, clock) == 0.0
    assert port.faults == []


@pytest.mark.parametrize("faults", [[0], [3], [0, 2]])
def test_close_says_stop_again_when_the_line_is_stuck(driving, faults):
    base, port, floor, clock = driving
    port.faults = faults
    base.close()
    clock.sleep(0.1)
    assert speed(floor, clock) == 0.0


def test_an_interrupt_while_closing_still_stops_the_wheels(driving):
    base, _, floor, clock = driving
    end_steps = base._link._stop_steps

    def interrupted():
        end_steps()
        raise KeyboardInterrupt

    base._link._stop_steps = interrupted
    with pytest.raises(KeyboardInterrupt):
        base.close()
    clock.sleep(0.1)
    assert speed(floor, clock) == 0.0


def test_a_port_that_fails_is_opened_again_and_stopping_comes_first(driving):
    base, port, floor, clock = driving
    port.error = serial.SerialException("device disconnected")
    port.faults = [0] * 50
    clock.sleep(0.03)
    with pytest.raises(DeviceTimeoutError, match="gone"):
        base.read()
    assert len(port.faults) == 48
    base.drive(Twist(0.2, 0.0))
    clock.sleep(0.15)
    assert speed(floor, clock) == 0.0
    assert base.read().mode is BaseMode.SAFE


@pytest.mark.parametrize("missing", range(1, 13))
def test_the_bytes_of_a_sure_stop_survive_any_cut_command(missing):
    parser = CommandParser()
    begun = bytes([Opcode.STREAM, missing]) if missing > 4 else bytes([145, 0, 200, 255, 56])
    cut = begun if missing > 4 else begun[:-missing]
    commands = list(parser.feed(cut + SURE_STOP + bytes([Opcode.START])))
    assert commands[-1].opcode is Opcode.START
    assert (commands[-2].opcode, commands[-2].arguments) == (Opcode.DRIVE_DIRECT, (0, 0))
