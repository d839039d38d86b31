"""Sensor packets against literal bytes: vectors R10 to R17 of the fact sheet."""

import pytest

from drivers.roomba.packets import (
    GROUPS,
    SIZES,
    BumpsAndWheelDrops,
    Buttons,
    ChargingState,
    DockBeam,
    LightBumper,
    Overcurrents,
    Packet,
    encode_packets,
    out_of_range,
    singles,
)
from tests.helpers.roomba_host import R17, R17_LIVED, R17_SENSED
from tests.helpers.roomba_reply import REPLIES, decode_packets, dock_beams

R17_VALUES = dict.fromkeys(range(7, 59), 0) | R17_SENSED | R17_LIVED


def test_every_packet_has_the_size_and_every_group_the_sum_of_the_manual():
    two_bytes = {19, 20, 22, 23, 25, 26, 27, 28, 29, 30, 31, 33, *range(39, 45), *range(46, 52)}
    two_bytes |= {54, 55, 56, 57}
    assert {number: SIZES[number] for number in range(7, 59)} == {
        number: 2 if number in two_bytes else 1 for number in range(7, 59)
    }
    assert {group: SIZES[group] for group in GROUPS} == {
        0: 26, 1: 10, 2: 6, 3: 10, 4: 14, 5: 12, 6: 52, 100: 80, 101: 28, 106: 12, 107: 9,
    }  # fmt: skip


def test_only_the_signed_packets_of_the_manual_are_signed():
    signed = {p for p in Packet if decode_packets([p], b"\xff" * SIZES[p])[p] < 0}
    assert signed == {19, 20, 23, 24, 39, 40, 41, 42, 43, 44, 54, 55, 56, 57}


def test_groups_that_were_never_defined_are_refused():
    with pytest.raises(ValueError, match="102"):
        singles([102])


@pytest.mark.parametrize("vector", REPLIES)
def test_replies_decode_and_encode(vector):
    group, reply, values = REPLIES[vector]
    assert decode_packets([group], bytes(reply)) == values
    assert list(encode_packets([group], values)) == reply


def test_a_reply_to_a_query_list_comes_in_the_order_that_was_asked():
    assert decode_packets([44, 7], bytes([0, 5, 3])) == {44: 5, 7: 3}


def test_a_reply_of_another_length_is_refused():
    with pytest.raises(ValueError, match="80"):
        decode_packets([100], bytes(79))


@pytest.mark.parametrize("packet", list(Packet))
def test_values_that_a_packet_cannot_have_are_refused(packet):
    with pytest.raises(ValueError, match=str(packet)):
        encode_packets([packet], {packet: 65536})


def test_the_full_reply_of_the_manual_decodes_and_encodes():
    assert decode_packets([100], bytes(R17)) == R17_VALUES
    assert list(encode_packets([100], R17_VALUES)) == R17
    assert out_of_range(R17_VALUES) == ()


def test_a_full_reply_that_is_shifted_by_one_byte_shows_in_its_voltage():
    shifted = decode_packets([100], bytes([*R17[1:], 0]))
    assert shifted[Packet.VOLTAGE] == 55803
    assert decode_packets([100], bytes([0, *R17[:-1]]))[Packet.VOLTAGE] == 59


@pytest.mark.parametrize(
    ("packet", "byte", "value"),
    [
        (14, 29, Overcurrents(1 | 4 | 8 | 16)),
        (14, 24, Overcurrents.LEFT_WHEEL | Overcurrents.RIGHT_WHEEL),
        (45, 33, LightBumper.LEFT | LightBumper.RIGHT),
        (17, 169, 169),
        (17, 27, 27),
    ],
)
def test_single_bytes_decode_and_encode(packet, byte, value):
    assert decode_packets([packet], bytes([byte])) == {packet: value}
    assert encode_packets([packet], {Packet(packet): value}) == bytes([byte])


def test_bit_fields_name_the_bits_of_the_manual():
    assert Overcurrents(29) == (
        Overcurrents.LEFT_WHEEL
        | Overcurrents.RIGHT_WHEEL
        | Overcurrents.MAIN_BRUSH
        | Overcurrents.SIDE_BRUSH
    )
    assert Overcurrents(24) == Overcurrents.LEFT_WHEEL | Overcurrents.RIGHT_WHEEL
    assert LightBumper(33) == LightBumper.LEFT | LightBumper.RIGHT
    assert LightBumper(50) == (LightBumper.FRONT_LEFT | LightBumper.FRONT_RIGHT | LightBumper.RIGHT)
    assert BumpsAndWheelDrops(2) == BumpsAndWheelDrops.BUMP_LEFT
    assert BumpsAndWheelDrops(12) == (
        BumpsAndWheelDrops.WHEEL_DROP_LEFT | BumpsAndWheelDrops.WHEEL_DROP_RIGHT
    )
    assert ChargingState(2) is ChargingState.FULL_CHARGING
    assert Buttons(5) == Buttons.CLEAN | Buttons.DOCK


def test_infrared_characters_are_decoded_to_the_beams_of_docks():
    assert dock_beams(169) == DockBeam.RED | DockBeam.FORCE_FIELD
    assert dock_beams(172) == DockBeam.RED | DockBeam.GREEN
    assert dock_beams(161) == DockBeam.FORCE_FIELD
    assert dock_beams(246) == DockBeam.GREEN | DockBeam.FORCE_FIELD
    assert dock_beams(254) == DockBeam.RED | DockBeam.GREEN | DockBeam.FORCE_FIELD
    assert dock_beams(0) is dock_beams(162) is dock_beams(129) is dock_beams(27) is None
