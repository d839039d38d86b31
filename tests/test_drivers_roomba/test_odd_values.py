"""Bases whose frames are whole, with values that the manual does not allow."""

import logging
import random
from types import SimpleNamespace

import pytest

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.packets import LAYOUTS, Packet, nearest_allowed, out_of_range
from drivers.roomba.service import LockstepLink, RoombaService
from drivers.roomba.state import STREAMED
from drivers.roomba.stream import OddValues, encode_sensor_frame
from vizbot.core.errors import DeviceError
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import BaseMode, BaseState

REST = dict.fromkeys(Packet, 0) | {Packet.BATTERY_CHARGE: 2000, Packet.BATTERY_CAPACITY: 2600}
SAFE = REST | {Packet.OI_MODE: BaseMode.SAFE}
ODD = [
    (Packet.BUMPS_AND_WHEEL_DROPS, 16, 0),
    (Packet.BUMPS_AND_WHEEL_DROPS, 18, 2),
    (Packet.CHARGING_STATE, 6, 0),
    (Packet.STASIS, 4, 0),
    (Packet.LIGHT_BUMPER, 129, 1),
    (Packet.OVERCURRENTS, 32, 0),
    (Packet.CLIFF_LEFT, 2, 1),
    (Packet.REQUESTED_LEFT_VELOCITY, -600, -500),
]


def port_of(make):
    """A port on which a base sends the same in every period."""
    return SimpleNamespace(
        name="/dev/ttyUSB0", in_waiting=61,
        read=lambda size=1: make(), write=len, close=lambda: None,
    )  # fmt: skip


def frame(values, odd=None):
    return encode_sensor_frame(STREAMED, values, unlimited=odd)


def states_of(make, steps=40):
    clock = SimulatedClock(period=0.015)
    service = RoombaService(lambda: port_of(make), clock.now, RoombaConfig(mode_offset=0))
    for _ in range(steps):
        service.step()
        clock.sleep(0.015)
    return [report for report in service.reports() if isinstance(report, BaseState)]


@pytest.mark.parametrize(("packet", "value", "taken"), ODD)
def test_a_value_that_a_base_sends_in_every_frame_is_named_once_and_the_rest_used(
    caplog, packet, value, taken
):
    with caplog.at_level(logging.WARNING):
        states = states_of(lambda: frame(SAFE | {packet: value}, odd=packet))
    assert len(states) > 30
    assert {state.battery for state in states} == {2000 / 2600}
    assert nearest_allowed(packet, value) == taken
    named = [line for line in caplog.messages if f"packet {packet}" in line]
    assert len(named) == 1 and f"sends {value} as" in named[0]


def test_what_a_cliff_or_a_bump_beside_an_odd_bit_says_is_obeyed():
    bump = SAFE | {Packet.BUMPS_AND_WHEEL_DROPS: 16 + 2}
    assert all(
        state.bump_left
        for state in states_of(lambda: frame(bump, odd=Packet.BUMPS_AND_WHEEL_DROPS))
    )
    cliff = SAFE | {Packet.CLIFF_LEFT: 2}
    assert all(state.cliffs[0] for state in states_of(lambda: frame(cliff, odd=Packet.CLIFF_LEFT)))


@pytest.mark.parametrize(("packet", "value", "_"), ODD)
def test_a_single_frame_with_an_odd_value_is_dropped(packet, value, _):
    odd_values = OddValues("/dev/ttyUSB0")
    for _ in range(50):
        assert odd_values.corrected(SAFE) == SAFE
        assert odd_values.corrected(SAFE | {packet: value}) is None


def test_frames_by_chance_with_other_odd_values_each_time_are_dropped():
    rng, odd_values = random.Random(0), OddValues("/dev/ttyUSB0")
    packets = [each for each in STREAMED if LAYOUTS[each].high < 200]
    for _ in range(200):
        chosen = dict.fromkeys(rng.sample(packets, 3), 250)
        assert odd_values.corrected(SAFE | chosen) is None


def test_a_mode_that_no_base_has_is_never_taken():
    odd_values = OddValues("/dev/ttyUSB0")
    assert {odd_values.corrected(SAFE | {Packet.OI_MODE: 9}) is None for _ in range(50)} == {True}


@pytest.mark.parametrize("packet", STREAMED)
def test_what_is_taken_for_any_value_is_allowed(packet):
    for value in range(-40000, 70000, 7):
        assert out_of_range({packet: nearest_allowed(packet, value)}) == ()


def test_bytes_of_another_baud_rate_are_told_from_a_base_that_sleeps():
    rng = random.Random(0)
    for make, words in ((lambda: rng.randbytes(25), "another baud rate"), (bytes, "asleep")):
        clock = SimulatedClock(period=0.015)
        port = port_of(make)
        with pytest.raises(DeviceError, match=words):
            Roomba(
                LockstepLink(lambda port=port: port, clock, RoombaConfig()), clock, RoombaConfig()
            )
