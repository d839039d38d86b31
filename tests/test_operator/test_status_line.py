"""Plain words on what the base does and feels."""

from dataclasses import replace

import numpy as np
import pytest

from vizbot.core.types import STOP, BaseMode, BaseState, Charging, Twist
from vizbot.operator.teleop.status_line import StatusLine, contacts

RESTING = BaseState(0.0, np.eye(4), False, False, (False,) * 4, (False, False), 0.97, BaseMode.SAFE)


def state(mode=BaseMode.SAFE, **felt):
    return replace(RESTING, mode=mode, **felt)


def line(shown, twist=STOP, now=0.0):
    return StatusLine().text(shown, twist, 4, 0.2, now)


def test_the_line_tells_command_speed_battery_and_mode():
    shown = line(state(), Twist(0.2, 0.8))
    assert shown == "ahead left | speed 4 (0.20 m/s) | battery 97 % | Safe mode"
    assert "battery ?" in line(state(battery=None))
    assert line(state(), Twist(-0.1, -0.1)).startswith("back right | ")


@pytest.mark.parametrize(
    ("felt", "words"),
    [
        ({"bump_left": True}, ["bump left"]),
        ({"bump_right": True}, ["bump right"]),
        ({"bump_left": True, "bump_right": True}, ["bump ahead"]),
        ({"cliffs": (False, True, True, False)}, ["edge front left and front right"]),
        ({"wheel_drops": (True, False)}, ["lifted"]),
        ({"virtual_wall": True}, ["virtual wall"]),
        ({"overcurrents": (False, True)}, ["wheel stuck"]),
        ({"docked": True}, ["on charger: back off"]),
        ({"plugged_in": True}, ["on charger: pull its cable"]),
        ({"charging": Charging.TRICKLE}, ["on charger: back off"]),
        ({}, []),
    ],
)
def test_contacts_are_told_in_plain_words(felt, words):
    assert contacts(state(**felt)) == words


def test_a_base_that_does_not_obey_says_what_helps():
    passive = BaseMode.PASSIVE
    assert "press r" in line(state(passive))
    assert "back straight off" in line(state(passive, cliffs=(True, False, False, False)))
    assert "on the floor" in line(state(passive, wheel_drops=(True, True)))
    assert "unplug" in line(state(passive, plugged_in=True))


def test_a_contact_of_one_moment_can_be_read():
    lines = StatusLine()
    lines.text(state(bump_left=True), STOP, 4, 0.2, 0.0)
    assert "bump left" in lines.text(state(), STOP, 4, 0.2, 0.9)
    assert "bump" not in lines.text(state(), STOP, 4, 0.2, 1.1)
