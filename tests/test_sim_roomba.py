"""The simulated Roomba: literal bytes in, its effect; its state, literal bytes out.

H and R are the vectors of the fact sheet of the manual, section 11.
"""

import os
import select
import threading

import pytest

from drivers.roomba_oi import Opcode
from drivers.roomba_packets import Packet
from drivers.serial_port import open_serial
from sim_stubs.body import Contacts
from sim_stubs.roomba import SimulatedRoomba, run_on_wall_clock
from vizbot.core.types import BaseMode


class PlacedBody:
    """A body that only moves when a test moves it."""

    def __init__(self):
        self.speeds = (0.0, 0.0)
        self.wheel_travel = (0.0, 0.0)
        self.contacts = Contacts()

    def set_wheel_speeds(self, left, right):
        self.speeds = (left, right)

    def advance(self, seconds):
        pass

    def roll_mm(self, left, right):
        self.wheel_travel = (
            self.wheel_travel[0] + left / 1000,
            self.wheel_travel[1] + right / 1000,
        )


class Host:
    """The other end of the line."""

    def __init__(self, encoder_counts=(0, 0)):
        self.body = PlacedBody()
        self.roomba = SimulatedRoomba(self.body, encoder_counts)
        self.port = self.roomba.lockstep_port(open_serial(self.roomba.path))

    def send(self, *sent):
        """Send bytes, let the base act on them, and return what it replies."""
        self.port.write(bytes(sent))
        self.roomba.advance(0.015)
        return list(self.port.read(self.port.in_waiting))

    def frame(self):
        self.roomba.publish()
        return list(self.port.read(self.port.in_waiting))

    def wheels_mm_s(self):
        return tuple(round(1000 * speed) for speed in self.body.speeds)


@pytest.fixture
def connect():
    hosts = []

    def connect(encoder_counts=(0, 0)):
        hosts.append(Host(encoder_counts))
        return hosts[-1]

    yield connect
    for host in hosts:
        host.port.close()
        host.roomba.close()


@pytest.fixture
def host(connect):
    return connect()


@pytest.fixture
def safe(host):
    host.send(128, 131)
    return host


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
        ("R10", 2, {17: 172, 18: 1, 19: -120, 20: 45}, [172, 1, 255, 136, 0, 45]),
        (
            "R11",
            3,
            {21: 2, 22: 16200, 23: 1234, 24: 25, 25: 2500, 26: 3000},
            [2, 63, 72, 4, 210, 25, 9, 196, 11, 184],
        ),
        (
            "R12",
            3,
            {21: 0, 22: 15200, 23: -1234, 24: -5, 25: 1800, 26: 2600},
            [0, 59, 96, 251, 46, 251, 7, 8, 10, 40],
        ),
        (
            "R13",
            106,
            {46: 10, 47: 200, 48: 4095, 49: 0, 50: 300, 51: 1234},
            [0, 10, 0, 200, 15, 255, 0, 0, 1, 44, 4, 210],
        ),
        (
            "R14",
            107,
            {54: 300, 55: -45, 56: 0, 57: 12, 58: 1},
            [1, 44, 255, 211, 0, 0, 0, 12, 1],
        ),
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


# fmt: off
R17 = [
    2, 0, 0, 0, 1, 0, 0, 8, 17, 0, 161, 4, 255, 221, 0, 12, 0, 59, 217, 251,
    93, 31, 6, 114, 10, 136, 0, 5, 4, 176, 5, 131, 0, 38, 5, 22, 0, 0, 0, 0,
    2, 1, 0, 0, 255, 56, 1, 244, 0, 250, 0, 150, 128, 8, 4, 210, 50, 0, 33, 1,
    146, 0, 19, 0, 0, 3, 9, 7, 255, 164, 168, 0, 215, 255, 58, 0, 0, 0, 64, 1,
]
# fmt: on


R17_SENSED = {
    14: 8, 15: 17, 17: 161, 22: 15321, 23: -1187, 24: 31, 25: 1650, 26: 2696, 27: 5,
    28: 1200, 29: 1411, 30: 38, 31: 1302, 45: 50, 46: 33, 47: 402, 48: 19, 50: 777,
    51: 2047, 52: 164, 53: 168, 54: 215, 55: -198, 57: 64, 58: 1,
}  # fmt: skip
R17_LIVED = {
    7: 2, 11: 1, 18: 4, 19: -35, 20: 12, 35: 2, 36: 1, 38: 0, 39: -200, 40: 500, 41: 250, 42: 150,
    43: -32760, 44: 1234,
}  # fmt: skip


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


def test_r17_the_same_values_in_a_stream_frame(host):
    values = R17_SENSED | R17_LIVED
    host.roomba.overrides |= {Packet(number): value for number, value in values.items()}
    host.send(128, 148, 1, 100)
    assert host.frame() == [19, 81, 100, *R17, 179]


@pytest.mark.parametrize(
    ("start", "counts", "before", "after"),
    [
        (32765, 5, [127, 253], [128, 2]),
        (-32766, -5, [128, 2], [127, 253]),
        (65530 - 65536, 11, [255, 250], [0, 5]),
        (5, -11, [0, 5], [255, 250]),
    ],
)
def test_encoders_roll_over_both_ways(connect, start, counts, before, after):
    host = connect(encoder_counts=(start, 0))
    host.send(128, 131, 145, *(0, 100, 0, 100) if counts > 0 else (255, 156, 255, 156))
    assert host.send(142, 43) == before
    host.body.roll_mm(counts * 0.4446, 0)
    host.roomba.advance(0.015)
    assert host.send(142, 43) == after


def test_encoders_see_no_direction_but_that_of_the_command(safe):
    safe.body.roll_mm(-0.9, -0.9)
    safe.roomba.advance(0.015)
    assert safe.send(149, 2, 43, 44) == [0, 2, 0, 2]
    safe.send(145, 255, 156, 255, 156)
    safe.body.roll_mm(0.9, 0.9)
    safe.roomba.advance(0.015)
    assert safe.send(149, 2, 43, 44) == [0, 0, 0, 0]


def test_distance_and_angle_begin_again_when_they_are_read(safe):
    safe.send(145, 0, 100, 0, 100)
    safe.body.roll_mm(30, 50)
    safe.roomba.advance(0.015)
    assert safe.send(142, 2) == [0, 0, 0, 40, 0, 5]
    assert safe.send(142, 2) == [0, 0, 0, 0, 0, 0]


def test_requested_velocities_are_those_of_the_last_commands(safe):
    safe.send(145, 0, 250, 255, 106, 137, 255, 56, 1, 244)
    assert safe.send(149, 4, 39, 40, 41, 42) == [255, 56, 1, 244, 0, 250, 255, 106]


@pytest.mark.parametrize(
    ("sent", "mode"),
    [
        ([128], BaseMode.PASSIVE),
        ([128, 130], BaseMode.SAFE),
        ([128, 131], BaseMode.SAFE),
        ([128, 132], BaseMode.FULL),
        ([128, 132, 131], BaseMode.SAFE),
        ([128, 131, 128], BaseMode.PASSIVE),
        ([128, 131, 133], BaseMode.PASSIVE),
        ([128, 131, 134], BaseMode.PASSIVE),
        ([128, 131, 135], BaseMode.PASSIVE),
        ([128, 131, 136], BaseMode.PASSIVE),
        ([128, 131, 143], BaseMode.PASSIVE),
        ([128, 131, 173], BaseMode.OFF),
        ([128, 131, 7], BaseMode.OFF),
        ([131], BaseMode.OFF),
        ([148, 1, 35], BaseMode.OFF),
    ],
)
def test_mode_commands(host, sent, mode):
    host.send(*sent)
    assert host.roomba.mode is mode


def test_a_reset_prints_a_banner_and_ends_the_stream(safe):
    safe.send(148, 1, 35)
    assert bytes(safe.send(7)).startswith(b"\r\nr3_robot/tags/release-")
    safe.send(128)
    assert safe.frame() == []


def test_passive_mode_ignores_actuators_but_answers(host):
    host.send(128, 145, 0, 100, 0, 100, 139, 4, 0, 128, 141, 0)
    assert host.wheels_mm_s() == (0, 0)
    assert Opcode.LEDS not in host.roomba.settings
    assert host.send(142, 35) == [1]


def test_entering_safe_mode_turns_the_leds_off(safe):
    safe.send(139, 4, 0, 128)
    safe.send(131)
    assert Opcode.LEDS not in safe.roomba.settings


def test_a_command_outside_the_manual_is_ignored(safe):
    safe.send(145, 2, 88, 2, 88, 142, 102, 255)
    assert safe.wheels_mm_s() == (0, 0)
    assert safe.send(142, 35) == [2]


@pytest.mark.parametrize("opcode", [128, 173])
def test_the_last_drive_runs_on_when_the_line_is_silent_and_through_start_and_stop(safe, opcode):
    safe.send(145, 0, 100, 0, 100)
    for _ in range(200):
        safe.roomba.advance(0.015)
    assert safe.wheels_mm_s() == (100, 100)
    safe.send(opcode)
    assert safe.wheels_mm_s() == (100, 100)


@pytest.mark.parametrize("opcode", [7, 133, 135])
def test_reset_power_and_clean_take_the_wheels_over(safe, opcode):
    safe.send(145, 0, 100, 0, 100)
    safe.send(opcode)
    assert safe.wheels_mm_s() == (0, 0)


CLIFF = Contacts(cliffs=(False, True, False, False))


@pytest.mark.parametrize(
    ("right", "left", "stops"),
    [
        ([0, 100], [0, 100], True),
        ([255, 156], [255, 156], False),
        ([255, 6], [255, 106], False),  # Back in a wide arc: -250, -150.
        ([255, 56], [0, 0], True),  # Back around the left wheel: -200, 0.
        ([0, 100], [255, 156], False),
    ],
)
def test_safe_mode_stops_for_a_cliff_ahead_and_in_tight_arcs_back(safe, right, left, stops):
    safe.send(145, *right, *left)
    safe.body.contacts = CLIFF
    safe.roomba.advance(0.015)
    assert (safe.wheels_mm_s() == (0, 0)) is stops
    assert safe.roomba.mode is (BaseMode.PASSIVE if stops else BaseMode.SAFE)
    assert safe.send(149, 4, 9, 10, 11, 12) == [0, 1, 0, 0]


@pytest.mark.parametrize("drops", [(True, False), (False, True)])
def test_safe_mode_stops_for_a_wheel_drop(safe, drops):
    safe.send(145, 255, 156, 255, 156)
    safe.body.contacts = Contacts(wheel_drops=drops)
    safe.roomba.advance(0.015)
    assert safe.wheels_mm_s() == (0, 0)
    assert safe.send(149, 2, 7, 35) == [8 if drops[0] else 4, 1]


def test_safe_mode_stops_for_the_charger(safe):
    safe.send(145, 0, 100, 0, 100)
    safe.roomba.overrides[Packet.CHARGING_SOURCES] = 1
    safe.roomba.advance(0.015)
    assert safe.wheels_mm_s() == (0, 0)
    assert safe.roomba.mode is BaseMode.PASSIVE


def test_safe_mode_does_not_stop_for_a_bump(safe):
    safe.send(145, 0, 100, 0, 100)
    safe.body.contacts = Contacts(bump_right=True)
    safe.roomba.advance(0.015)
    assert safe.wheels_mm_s() == (100, 100)
    assert safe.send(142, 7) == [1]


def test_full_mode_stops_for_nothing(safe):
    safe.send(132, 145, 0, 100, 0, 100)
    safe.body.contacts = Contacts(cliffs=(True,) * 4, wheel_drops=(True, True))
    safe.roomba.advance(0.015)
    assert safe.wheels_mm_s() == (100, 100)


def test_the_battery_drains_faster_while_driving(safe):
    def charge():
        high, low = safe.send(142, 25)
        return 256 * high + low

    full = charge()
    safe.roomba.advance(3600)
    idle = full - charge()
    safe.send(145, 0, 100, 0, 100)
    safe.roomba.advance(3600)
    assert 0 < idle < full - idle - charge()
    assert safe.send(142, 23)[0] == 255 - 3  # Less than -768 mA: it discharges.


def test_a_cut_command_waits_for_its_data(safe):
    safe.send(145, 0, 100)
    assert safe.wheels_mm_s() == (0, 0)
    safe.send(0, 100)
    assert safe.wheels_mm_s() == (100, 100)


def test_any_program_may_talk_to_it_on_the_wall_clock():
    stopped = threading.Event()
    with SimulatedRoomba(PlacedBody()) as roomba:
        thread = threading.Thread(target=run_on_wall_clock, args=(roomba, stopped))
        thread.start()
        terminal = os.open(roomba.path, os.O_RDWR | os.O_NOCTTY)
        try:
            os.write(terminal, bytes([128, 148, 1, 35]))
            received = b""
            while len(received) < 10 and select.select([terminal], [], [], 5.0)[0]:
                received += os.read(terminal, 10 - len(received))
        finally:
            os.close(terminal)
            stopped.set()
            thread.join()
    assert list(received) == [19, 2, 35, 1, 199] * 2


def test_frames_that_nobody_reads_are_lost_without_blocking_the_base(host):
    host.send(128, 148, 1, 100)
    for _ in range(1000):
        host.roomba.publish()
    assert host.roomba.mode is BaseMode.PASSIVE


def test_closing_twice_is_fine():
    roomba = SimulatedRoomba(PlacedBody())
    roomba.close()
    roomba.close()
