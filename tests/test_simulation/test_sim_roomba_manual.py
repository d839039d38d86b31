"""The simulated Roomba against the literal bytes of the manual.

H and R are the vectors of the fact sheet of the manual, section 11.
"""

import pytest

from drivers.roomba.packets import Packet
from sim_stubs.world.body import Contacts
from tests.helpers.roomba_host import R17, R17_LIVED, R17_SENSED
from tests.helpers.roomba_reply import REPLIES


@pytest.mark.parametrize(
    ("vector", "sent", "left", "right"),
    [
        ("H1", [137, 255, 56, 1, 244], -153, -247),
        ("H2", [137, 1, 44, 128, 0], 300, 300),
        ("H3", [137, 1, 44, 127, 255], 300, 300),
        ("H4", [137, 0, 150, 255, 255], 150, -150),
        ("H5", [137, 0, 150, 0, 1], -150, 150),
        ("H6", [137, 1, 244, 248, 48], 500, 471),
        ("H7", [137, 254, 12, 7, 208], -471, -500),
        ("H8", [145, 0, 200, 255, 56], -200, 200),
        ("H9", [145, 254, 12, 1, 244], 500, -500),
        ("H10", [145, 0, 250, 0, 150], 150, 250),
        ("H11", [145, 0, 0, 0, 0], 0, 0),
        ("H12", [146, 0, 255, 255, 1], -500, 500),
    ],
)
def test_drive_commands_turn_the_wheels(safe, vector, sent, left, right):
    safe.send(145, 0, 100, 0, 100)
    safe.send(*sent)
    assert safe.wheels_mm_s() == (left, right)


@pytest.mark.parametrize(
    ("vector", "sent", "opcode", "arguments"),
    [
        ("H13", [144, 192, 32, 127], 144, (-64, 32, 127)),
        ("H14", [138, 13], 138, (13,)),
        ("H15", [139, 4, 0, 128], 139, (4, 0, 128)),
        ("H16", [139, 12, 255, 255], 139, (12, 255, 255)),
        (
            "H22",
            [167, 40, 0, 0, 0, 0, 0, 0, 15, 0, 0, 0, 10, 36, 0, 0],
            167,
            (40, 0, 0, 0, 0, 0, 0, 15, 0, 0, 0, 10, 36, 0, 0),
        ),
        ("H23 time", [168, 3, 15, 30], 168, (3, 15, 30)),
        ("H23 display", [164, 65, 66, 67, 68], 164, (65, 66, 67, 68)),
        ("H23 baud", [129, 7], 129, (7,)),
    ],
)
def test_settings_are_taken_over(safe, vector, sent, opcode, arguments):
    assert safe.send(*sent) == []
    assert safe.roomba.settings[opcode] == arguments


def test_h23_a_pushed_button_is_released_after_a_sixth_of_a_second(safe):
    safe.send(165, 4)
    assert safe.send(142, 18) == [4]
    safe.roomba.advance(0.14)
    assert safe.send(142, 18) == [0]


def test_h17_a_song_plays_as_long_as_its_notes(safe):
    assert safe.send(140, 0, 2, 69, 32, 72, 16, 141, 0) == []
    assert safe.roomba.songs.slots == {0: ((69, 32), (72, 16))}
    assert safe.send(149, 2, 36, 37) == [0, 1]
    safe.roomba.advance(0.70)
    assert safe.send(142, 37) == [1]
    safe.roomba.advance(0.05)
    assert safe.send(142, 37) == [0]


def test_h18_a_query_list_is_answered_with_bare_data_in_its_order(safe):
    safe.body.contacts = Contacts(bump_right=True)
    safe.roomba.overrides[Packet.VIRTUAL_WALL] = 1
    assert safe.send(149, 2, 7, 13) == [1, 1]
    assert safe.send(149, 2, 13, 7) == [1, 1]


def test_h19_both_encoders_are_answered_left_first(connect):
    host = connect(encoder_counts=(258, -2))
    host.send(128)
    assert host.send(149, 2, 43, 44) == [1, 2, 255, 254]


def test_h20_a_stream_begins_pauses_and_resumes(safe):
    safe.roomba.overrides[Packet.CLIFF_FRONT_LEFT_SIGNAL] = 537
    assert safe.frame() == []
    safe.send(148, 2, 29, 13)
    assert safe.frame() == safe.frame() == [19, 5, 29, 2, 25, 13, 0, 163]  # R1
    safe.send(150, 0)
    assert safe.frame() == []
    safe.send(150, 1)
    assert safe.frame() == [19, 5, 29, 2, 25, 13, 0, 163]


def test_h21_a_stream_of_contacts_mode_and_encoders(connect):
    host = connect(encoder_counts=(32767, -32768))
    host.send(128, 131, 148, 4, 7, 35, 43, 44)
    host.body.contacts = Contacts(bump_left=True, bump_right=True)
    assert host.frame() == [19, 10, 7, 3, 35, 2, 43, 127, 255, 44, 128, 0, 95]  # R4
    # Left forward, right backward, by one count of 0.4446 mm.
    host.send(145, 255, 156, 0, 100)
    host.body.contacts = Contacts()
    host.body.roll_mm(0.4446, -0.4446)
    host.roomba.advance(0.015)
    assert host.frame() == [19, 10, 7, 0, 35, 2, 43, 128, 0, 44, 127, 255, 98]  # R5


@pytest.mark.parametrize(
    ("vector", "ids", "values", "frame"),
    [
        ("R2", [29, 13], {29: 549}, [19, 5, 29, 2, 37, 13, 0, 151]),
        ("R6", [22], {22: 4883}, [19, 3, 22, 19, 19, 174]),
        ("R9", [100], dict.fromkeys(range(7, 59), 0), [19, 81, 100, *[0] * 80, 56]),
        ("R15", [22], {22: 15002}, [19, 3, 22, 58, 154, 0]),
        ("R17", [100], R17_SENSED | R17_LIVED, [19, 81, 100, *R17, 179]),
    ],
)
def test_stream_frames_are_the_bytes_of_the_manual(host, vector, ids, values, frame):
    host.roomba.overrides |= {Packet(number): value for number, value in values.items()}
    host.send(128, 148, len(ids), *ids)
    assert host.frame() == frame


def test_r8_encoders_at_minus_one_and_zero(connect):
    host = connect(encoder_counts=(-1, 0))
    host.send(128, 148, 2, 43, 44)
    assert host.frame() == [19, 6, 43, 255, 255, 44, 0, 0, 146]


@pytest.mark.parametrize(
    ("vector", "asked", "values", "reply"),
    [
        *((vector, asked, values, reply) for vector, (asked, reply, values) in REPLIES.items()),
        ("R16", 14, {14: 29}, [29]),
        ("R16", 14, {14: 24}, [24]),
        ("R16", 45, {45: 33}, [33]),
        ("R16", 17, {17: 169}, [169]),
        ("R16", 17, {17: 27}, [27]),
    ],
)
def test_replies_are_the_bytes_of_the_manual(host, vector, asked, values, reply):
    host.roomba.overrides |= {Packet(number): value for number, value in values.items()}
    assert host.send(128, 142, asked) == reply


def test_r17_every_packet_of_a_base_that_backs_off_in_an_arc(connect):
    host = connect(encoder_counts=(-32760 + 134, 1234 + 23))
    host.roomba.overrides |= {Packet(number): value for number, value in R17_SENSED.items()}
    host.body.contacts = Contacts(bump_left=True, cliffs=(False, False, True, False))
    host.send(128, 131, 140, 1, 1, 60, 1, 141, 1)
    host.send(145, 0, 250, 0, 150, 137, 255, 56, 1, 244, 165, 4)
    # 35 mm back, 12 degrees to the left.
    host.body.roll_mm(-59.61, -10.39)
    host.roomba.advance(0.015)
    assert host.send(142, 100) == R17
