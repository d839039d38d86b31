"""A line to the base that loses or spoils a byte: what the base then does, and for how long."""

import pytest

from drivers.roomba_oi import Opcode
from tests.roomba_rig import PERIOD, Rig
from vizbot.core.types import BaseMode, Twist

JOURNEY = (Twist(0.25, 0.0), Twist(0.1, 1.5), Twist(-0.25, 0.0), Twist(0.0, -1.0), Twist(0.0, 0.0))
FASTEST = 0.28
LEG = 4 * PERIOD


class BadLine:
    """A port that does something to one byte of all that is written."""

    def __init__(self, port, number, spoil):
        self.port, self.number, self.spoil = port, number, spoil
        self.written = 0
        self.name, self.read, self.close = port.name, port.read, port.close

    @property
    def in_waiting(self):
        return self.port.in_waiting

    def write(self, sent):
        place, sent = self.number - self.written, bytearray(sent)
        self.written += len(sent)
        if 0 <= place < len(sent):
            sent[place : place + 1] = self.spoil(sent[place])
        return self.port.write(bytes(sent))


class BadLineRig(Rig):
    def __init__(self, number, spoil):
        self.bad = (number, spoil)
        self.modes = []
        super().__init__()

    def open_port(self):
        self.line = BadLine(super().open_port(), *self.bad)
        return self.line


def since(then, now):
    return [after - before for before, after in zip(then, now, strict=True)]


def journey(number):
    """Drive with byte `number` lost; the rig, and the travel of its wheels after each leg."""
    rig = BadLineRig(number, lambda byte: b"")
    with rig.stub, rig.base:
        start, travel = rig.floor.wheel_travel, []
        for twist in JOURNEY:
            for _ in range(round(LEG / PERIOD)):
                rig.drive(twist, PERIOD)
                rig.modes.append(rig.stub.mode)
            travel.append(since(start, rig.floor.wheel_travel))
        rig.base.close()
        rig.clock.sleep(2 * PERIOD)
        return rig, travel


def test_every_byte_that_is_lost_costs_one_period_of_one_command():
    sound, expected = journey(-1)
    assert sound.line.written > 250
    for number in range(sound.line.written):
        rig, travel = journey(number)
        assert set(rig.modes) == {BaseMode.SAFE}, number
        assert rig.stub.mode is BaseMode.PASSIVE, number
        assert rig.floor.speeds == (0.0, 0.0), number
        assert rig.stub.settings.keys() <= {Opcode.LEDS}, number
        for legs in zip(travel, expected, strict=True):
            for there, wanted in zip(*legs, strict=True):
                # It rolls on for one period, and turns round one period later.
                assert there == pytest.approx(wanted, abs=2 * FASTEST * PERIOD), number


@pytest.mark.parametrize("place", [5, 6, 7, 8])
@pytest.mark.parametrize("bit", range(8))
def test_a_speed_that_is_spoilt_on_the_way_stops_the_base_within_two_periods(place, bit):
    rig = BadLineRig(-1, lambda byte: bytes([byte ^ 1 << bit]))
    with rig.stub, rig.base:
        rig.drive(Twist(0.25, 0.0), 0.3)
        before, rig.line.number = rig.floor.wheel_travel, rig.line.written + place
        rig.drive(Twist(0.25, 0.0), 2 * PERIOD)
        assert rig.floor.speeds == (0.0, 0.0)
        assert all(abs(way) < 0.51 * PERIOD for way in since(before, rig.floor.wheel_travel))
        rig.drive(Twist(0.25, 0.0), 0.3)
        assert rig.floor.speeds == (0.25, 0.25)
