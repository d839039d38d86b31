"""A base that falls silent: when it is woken and stopped, and when it obeys again."""

import pytest

from drivers.roomba.commands import Command, Opcode
from drivers.roomba.packets import Packet
from tests.helpers.roomba_rig import PERIOD, BadLineRig
from vizbot.core.types import BaseMode, Twist


def test_a_base_that_falls_silent_while_it_rolls_rests_and_obeys_half_a_second_more(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.stub.publish = lambda: None
    rig.drive(Twist(0.2, 0.0), 0.45)
    assert rig.stub.mode is BaseMode.SAFE
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(0.2, 0.0), 0.6)
    assert rig.stub.mode is BaseMode.PASSIVE


def test_a_base_that_falls_silent_at_rest_is_not_woken_for_half_a_second(rig):
    rig.clock.sleep(0.3)
    rig.stub.publish = lambda: None
    rig.clock.sleep(0.45)
    assert rig.stub.mode is BaseMode.SAFE
    rig.clock.sleep(0.15)
    assert rig.stub.mode is BaseMode.PASSIVE


def test_what_it_rolls_in_silence_counts_though_its_encoders_have_counted_little(rig):
    rig.drive(Twist(0.05, 0.0), 0.2)
    rig.stub.publish = lambda: None
    before = rig.floor.wheel_travel[0]
    rig.drive(Twist(0.05, 0.0), 0.3)
    del rig.stub.publish
    rig.settle()
    assert before + 0.005 < rig.floor.wheel_travel[0] < 0.04  # 100 counts are 0.044 m
    assert rig.error()[0] < 0.001


def ended(number):
    """End all while it rolls, with byte `number` lost; the rig, and how long it rolls on."""
    rig = BadLineRig(number, lambda byte: b"")
    with rig.stub, rig.base:
        rig.drive(Twist(0.5, 0.0), 0.3)
        rig.line.requests, began = [], rig.clock.now()
        rig.stub._obey(Command(Opcode.STOP))
        while rig.floor.speeds != (0.0, 0.0):
            rig.drive(Twist(0.5, 0.0), PERIOD)
            assert rig.clock.now() < began + 0.3, number
        rolled = rig.clock.now() - began
        rig.drive(Twist(0.5, 0.0), 0.6)
        assert rig.floor.speeds == (0.5, 0.5), number
        return rig, rolled


@pytest.mark.parametrize("stride", [5, pytest.param(1, marks=pytest.mark.long)])
def test_where_a_spoilt_byte_ends_all_it_soon_rests_and_obeys_whatever_byte_is_lost_next(stride):
    sound, rolled = ended(-1)
    assert rolled < 0.18 + 2 * PERIOD
    assert sound.line.requests
    for number in list(sound.line.requests)[::stride]:
        assert ended(number)[1] < rolled + 3 * PERIOD, number


def test_a_frame_from_before_it_was_woken_does_not_end_the_asking(rig):
    rig.clock.sleep(0.3)
    publish, said = rig.stub.publish, rig.stub._line.send
    rig.stub.publish = lambda: None
    rig.clock.sleep(0.5 + 3 * PERIOD)
    assert rig.stub.mode is BaseMode.PASSIVE  # woken
    rig.stub.overrides[Packet.OI_MODE] = BaseMode.SAFE
    publish()  # late
    del rig.stub.overrides[Packet.OI_MODE]
    rig.stub.publish, rig.stub._line.send = publish, said
    rig.clock.sleep(1.0)
    assert rig.base.read().mode is BaseMode.SAFE
