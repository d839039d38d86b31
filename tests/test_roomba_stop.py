"""The wheels stop, whatever happens to the line, the program or its close()."""

import pytest
import serial

from drivers.roomba import Roomba, RoombaConfig
from drivers.roomba_oi import CommandParser, Opcode
from drivers.serial_port import open_serial
from sim_stubs.clock import SimulatedClock
from sim_stubs.free_floor import FreeFloor
from sim_stubs.roomba import SimulatedRoomba
from vizbot.core.errors import DeviceError
from vizbot.core.types import Twist


class FaultyPort:
    """A serial port whose next writes go wrong as told: each entry is what is sent before it."""

    def __init__(self, port):
        self._port = port
        self.faults = []
        self.error = serial.SerialTimeoutException("Write timeout")

    def write(self, sent):
        if self.faults:
            self._port.write(sent[: self.faults.pop(0)])
            raise self.error
        return self._port.write(sent)

    def __getattr__(self, name):
        return getattr(self._port, name)


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

        base = Roomba(open_port, clock, RoombaConfig())
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


@pytest.mark.parametrize("cut", range(6))
def test_a_write_that_fails_after_any_byte_stops_the_wheels(driving, cut):
    base, port, floor, clock = driving
    port.faults = [cut]
    clock.sleep(0.1)
    assert speed(floor, clock) == 0.0
    with pytest.raises(DeviceError, match="gone"):
        base.read()


def test_the_stop_is_repeated_until_the_line_takes_it(driving):
    _, port, floor, clock = driving
    port.faults = [0] * 10
    clock.sleep(0.3)
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
    end_service = base._stop_service

    def interrupted():
        end_service()
        raise KeyboardInterrupt

    base._stop_service = interrupted
    with pytest.raises(KeyboardInterrupt):
        base.close()
    clock.sleep(0.1)
    assert speed(floor, clock) == 0.0


def test_a_line_that_is_gone_ends_the_service(driving):
    base, port, _, clock = driving
    port.error = serial.SerialException("device disconnected")
    port.faults = [0] * 50
    clock.sleep(0.3)
    assert len(port.faults) == 48
    with pytest.raises(DeviceError, match="gone"):
        base.drive(Twist(0.1, 0.0))


@pytest.mark.parametrize("missing", range(1, 13))
def test_the_bytes_of_a_sure_stop_survive_any_cut_command(missing):
    from drivers.roomba import SURE_STOP

    parser = CommandParser()
    begun = bytes([Opcode.STREAM, missing]) if missing > 4 else bytes([145, 0, 200, 255, 56])
    cut = begun if missing > 4 else begun[:-missing]
    commands = list(parser.feed(cut + SURE_STOP + bytes([Opcode.START])))
    assert commands[-1].opcode is Opcode.START
    assert (commands[-2].opcode, commands[-2].arguments) == (Opcode.DRIVE_DIRECT, (0, 0))
