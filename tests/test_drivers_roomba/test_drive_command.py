"""Wheel commands that lose a byte."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.roomba.commands import CommandParser, Opcode
from drivers.roomba.drive_command import STOP_WHEELS, CommandedSpeeds, drive_command, harmless

speeds = st.integers(-500, 500)


@given(speeds)
def test_no_data_byte_of_a_speed_is_an_opcode(speed):
    assert not {int(opcode) for opcode in Opcode} & set(
        harmless(speed).to_bytes(2, "big", signed=True)
    )


@given(speeds)
def test_a_harmless_speed_is_near_of_the_same_sign_and_stays(speed):
    near = harmless(speed)
    assert abs(near - speed) <= 10
    assert near * speed > 0 or near == speed == 0
    assert harmless(near) == near


@given(speeds, st.integers(0, 500))
def test_no_harmless_speed_is_beyond_what_is_allowed(speed, most):
    within = max(-most, min(most, speed))
    near = harmless(within, most)
    assert abs(near) <= most
    assert near * within > 0 or near == within == 0


@given(speeds)
def test_both_ways_are_alike_up_to_the_gaps(speed):
    assert abs(harmless(speed) + harmless(-speed)) <= 20


@given(speeds, speeds, st.integers(0, 8))
def test_whatever_byte_is_lost_the_next_command_is_obeyed_and_no_other_one_appears(
    right, left, lost
):
    parser, command = CommandParser(), drive_command(harmless(right), harmless(left))
    obeyed = list(parser.feed(command[:lost] + command[lost + 1 :] + command))
    assert {command.opcode for command in obeyed} == {Opcode.DRIVE_DIRECT}
    assert obeyed[-1].arguments == (harmless(right), harmless(left))
    assert list(parser.feed(STOP_WHEELS))[-1].arguments == (0, 0)


def test_reported_speeds_are_explained_by_recent_commands():
    commanded = CommandedSpeeds(memory=0.1)
    assert commanded.explains((100, 100), 0)
    commanded.add((0, 0), 0.0)
    commanded.add((100, 100), 1.0)
    assert commanded.explains((0, 0), 0)
    assert commanded.explains((100, 100), 0)
    assert not commanded.explains((100, 0), 0)
    commanded.add((100, 100), 1.2)
    assert not commanded.explains((0, 0), 0)
    assert commanded.explains((100, 100), 0)


def test_what_firmware_rounds_is_explained_and_what_a_spoilt_byte_makes_is_not():
    commanded = CommandedSpeeds(memory=0.1)
    commanded.add((100, -100), 0.0)
    assert commanded.explains((92, -109), 10)
    assert not commanded.explains((100, -111), 10)
    assert not commanded.explains((100 + 256, -100), 10)


def test_speeds_that_change_all_the_time_are_remembered_no_longer_than_that():
    commanded = CommandedSpeeds(memory=0.1)
    for n in range(100):
        commanded.add((n, n), 0.015 * n)
    assert [n for n in range(100) if commanded.explains((n, n), 0)] == pytest.approx(range(92, 100))
    commanded.clear()
    assert commanded.latest is None
