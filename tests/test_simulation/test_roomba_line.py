"""A line to the base that loses or spoils a byte: what the base then does, and for how long."""

from contextlib import contextmanager

import pytest

from drivers.roomba.commands import Opcode
from sim_stubs.roomba.serial_line import SerialLine
from sim_stubs.world.body import Contacts
from tests.helpers.failing import raising
from tests.helpers.roomba_rig import PERIOD, BadLineRig, since
from vizbot.core.errors import DeviceError
from vizbot.core.types import STOP, BaseMode, Feedback, Twist

JOURNEY = (Twist(0.25, 0.0), Twist(0.1, 1.5), Twist(-0.25, 0.0), Twist(0.0, -1.0), Twist(0.0, 0.0))
FASTEST = 0.28
LEG = 4 * PERIOD


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


@pytest.mark.slow
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


def errands(number):
    """Show, look for the dock, obey again, fall silent, with byte `number` lost."""
    rig = BadLineRig(number, lambda byte: b"")
    ahead, rolled = Twist(0.25, 0.0), []

    def leg(seconds, twist=None):
        before = rig.floor.wheel_travel
        rig.drive(twist, seconds) if twist else rig.clock.sleep(seconds)
        rolled.append(max(map(abs, since(before, rig.floor.wheel_travel))))

    with rig.stub, rig.base:
        leg(LEG, ahead)
        rig.base.show(Feedback.FOUND)
        leg(LEG, ahead)
        rig.base.dock()
        leg(0.6, STOP)
        rig.modes.append(rig.stub.mode)
        rig.base.resume()
        leg(0.6)
        rig.modes.append(rig.stub.mode)
        leg(LEG, ahead)
        with rig.silence():
            leg(0.75, ahead)
        leg(0.1)
        leg(LEG, ahead)
        rig.base.close()
        rig.clock.sleep(2 * PERIOD)
        return rig, rolled


@pytest.mark.parametrize(
    "stride", [23, pytest.param(7, marks=pytest.mark.slow), pytest.param(1, marks=pytest.mark.long)]
)
def test_no_byte_that_is_lost_of_any_command_rolls_it_farther_or_costs_what_was_asked_for(stride):
    sound, expected = errands(-1)
    assert sound.stub.mode is BaseMode.PASSIVE
    assert sound.modes == [BaseMode.PASSIVE, BaseMode.SAFE]
    assert min(expected[0], expected[4], expected[7]) > 0.01
    for number in list(sound.line.requests)[::stride]:
        rig, rolled = errands(number)
        assert rig.modes == sound.modes, number
        assert rig.floor.speeds == (0.0, 0.0), number
        assert rig.stub.settings.keys() <= {Opcode.LEDS}, number
        for there, wanted in zip(rolled, expected, strict=True):
            assert there < wanted + 2 * FASTEST * PERIOD, number


@contextmanager
def spoiling(bit):
    """A rig that drives, on a line that can spoil a bit."""
    rig = BadLineRig(-1, lambda byte: bytes([byte ^ 1 << bit]))
    with rig.stub, rig.base:
        rig.drive(Twist(0.25, 0.0), 0.3)
        yield rig


@pytest.mark.sampled
@pytest.mark.parametrize("place", [5, 6, 7, 8])
@pytest.mark.parametrize("bit", range(8))
def test_a_speed_that_is_spoilt_on_the_way_stops_the_base_within_two_periods(place, bit):
    with spoiling(bit) as rig:
        before, rig.line.number = rig.floor.wheel_travel, rig.line.written + place
        rig.drive(Twist(0.25, 0.0), 2 * PERIOD)
        assert rig.floor.speeds == (0.0, 0.0)
        assert all(abs(way) < 0.51 * PERIOD for way in since(before, rig.floor.wheel_travel))
        rig.drive(Twist(0.25, 0.0), 0.3)
        assert rig.floor.speeds == (0.25, 0.25)


@pytest.mark.sampled
@pytest.mark.parametrize("place", range(9))
@pytest.mark.parametrize("bit", range(8))
def test_whatever_bit_is_spoilt_the_base_can_be_stopped(place, bit):
    with spoiling(bit) as rig:
        rig.line.number = rig.line.written + place
        rig.drive(Twist(0.25, 0.0), 2 * PERIOD)
        rig.drive(Twist(0.0, 0.0), 1.0)
        assert rig.floor.speeds == (0.0, 0.0)
        assert rig.stub.mode is BaseMode.SAFE


def test_a_byte_that_ends_the_obedience_is_noticed_and_taken_back(rig, caplog):
    rig.drive(Twist(0.25, 0.0), 1.0)
    rig.ports[0].write(bytes([128]))
    rig.drive(Twist(0.25, 0.0), 2 * PERIOD)
    assert "nothing it feels explains that" in caplog.text
    rig.drive(Twist(0.0, 0.0), 4 * PERIOD)
    assert rig.stub.mode is BaseMode.SAFE
    assert rig.floor.speeds == (0.0, 0.0)


class DeafAtFirst:
    """A line on which the base hears nothing of the first periods; `to_host` says what we hear."""

    def __init__(self, periods, to_host=bytes):
        self.periods = periods
        self.to_host = to_host

    def to_robot(self, sent):
        self.periods -= 1
        return b"" if self.periods >= 0 else sent


def test_a_request_to_obey_that_is_lost_is_made_again_at_once(rig):
    rig.drive(Twist(0.25, 0.0), 1.0)
    rig.stub.mode = BaseMode.PASSIVE
    rig.stub._line._noise = DeafAtFirst(periods=2)
    rig.drive(Twist(0.25, 0.0), 4 * PERIOD)
    assert rig.stub.mode is BaseMode.SAFE


def test_a_stop_that_is_lost_is_told_again_though_no_frame_can_be_made_out(rig):
    rig.drive(Twist(0.25, 0.0), 1.0)
    rig.stub._line._noise = DeafAtFirst(periods=1, to_host=lambda sent: sent[:-1] + b"\0")
    rig.drive(Twist(0.0, 0.0), 4 * PERIOD)
    assert rig.floor.speeds == (0.0, 0.0)


def test_a_reason_that_is_felt_late_ends_the_asking(rig):
    rig.drive(Twist(0.25, 0.0), 1.0)
    rig.stub.mode = BaseMode.PASSIVE
    rig.stub._wheels.stop()
    line = rig.stub._line._noise = DeafAtFirst(periods=6)
    rig.drive(Twist(0.25, 0.0), PERIOD)
    rig.floor.contacts = Contacts(wheel_drops=(True, True))
    rig.drive(Twist(0.25, 0.0), 2 * PERIOD)
    rig.floor.contacts = Contacts()
    rig.drive(Twist(0.25, 0.0), 1.0)
    assert line.periods < 0
    assert rig.stub.mode is BaseMode.PASSIVE
    assert rig.floor.speeds == (0.0, 0.0)


def test_who_ends_the_obedience_again_and_again_is_obeyed(rig, caplog):
    for _ in range(4):
        rig.drive(Twist(0.25, 0.0), 0.6)
        assert rig.stub.mode is BaseMode.SAFE
        rig.stub.mode = BaseMode.PASSIVE
    rig.drive(Twist(0.25, 0.0), 1.0)
    assert rig.stub.mode is BaseMode.PASSIVE
    assert caplog.text.count("nothing it feels explains that") == 3


@pytest.mark.parametrize("contacts", [Contacts(bump_left=True), Contacts(bump_right=True)])
def test_a_bump_while_the_wheels_slow_down_stops_them_at_once(open_rig, contacts):
    rig = open_rig(acceleration=2.0, deceleration=1.0)
    rig.drive(Twist(0.3, 0.0), 0.5)
    rig.drive(Twist(-0.1, 0.0), 2 * PERIOD)
    assert rig.floor.speeds[0] > 0.2
    rig.floor.contacts = contacts
    rig.clock.sleep(PERIOD)
    assert max(rig.floor.speeds) <= 0.001  # a wheel that rolls is not told to turn back yet


@pytest.mark.parametrize("lost", range(1, 4))
def test_a_request_to_obey_after_docking_is_made_four_times(rig, lost):
    rig.base.dock()
    rig.clock.sleep(0.1)
    assert rig.stub.mode is BaseMode.PASSIVE
    obey, requests = rig.stub._obey, []

    def hear(command):
        if command.opcode is Opcode.SAFE:
            requests.append(rig.clock.now())
        if command.opcode is not Opcode.SAFE or len(requests) > lost:
            obey(command)

    rig.stub._obey = hear
    rig.base.resume()
    rig.clock.sleep(3.0)
    assert rig.stub.mode is BaseMode.SAFE
    assert len(requests) == lost + 1


def test_a_base_that_is_lifted_meanwhile_is_not_asked_any_more(rig):
    rig.base.dock()
    rig.clock.sleep(0.1)
    obey = rig.stub._obey
    rig.stub._obey = lambda command: command.opcode is Opcode.SAFE or obey(command)
    rig.base.resume()
    rig.clock.sleep(0.1)
    rig.stub._obey = obey
    rig.floor.contacts = Contacts(wheel_drops=(True, True))
    rig.clock.sleep(0.1)
    rig.floor.contacts = Contacts()
    rig.clock.sleep(3.0)
    assert rig.stub.mode is BaseMode.PASSIVE


def test_a_system_without_pseudo_terminals_is_told_in_a_line(monkeypatch):
    monkeypatch.setattr("os.openpty", raising(OSError(19, "No such device")))
    with pytest.raises(DeviceError, match=r"pseudo-terminal.*No such device; .* mount /dev/pts"):
        SerialLine()
