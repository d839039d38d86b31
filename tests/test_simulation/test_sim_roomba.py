"""The simulated Roomba: literal bytes in, its effect; its state, literal bytes out.

H and R are the vectors of the fact sheet of the manual, section 11.
"""

import os
import select
from types import SimpleNamespace

import pytest

from drivers.roomba.commands import Opcode
from drivers.roomba.packets import Packet
from drivers.roomba.serial_port import WriteTimeout, open_serial
from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from sim_stubs.roomba.serial_line import SerialLine
from sim_stubs.world.body import Contacts
from tests.helpers.roomba_host import CLIFF, PlacedBody
from vizbot.core.types import BaseMode


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
    assert safe.send(142, 102, 141, 9, 255) == []
    assert safe.send(142, 35) == [2]


@pytest.mark.parametrize(
    ("command", "left", "right"),
    [
        ((145, 2, 88, 253, 168), -500, 500),
        ((146, 1, 0, 255, 0), -500, 500),
        ((137, 2, 88, 128, 0), 500, 500),
    ],
)
def test_speeds_beyond_the_fastest_are_taken_for_the_fastest(safe, command, left, right):
    safe.send(*command)
    assert safe.wheels_mm_s() == (left, right)


@pytest.mark.parametrize(("opcode", "speed"), [(128, 100), (173, 100), (7, 0), (133, 0), (135, 0)])
def test_the_last_drive_runs_on_in_silence_start_and_stop_but_not_reset_power_and_clean(
    safe, opcode, speed
):
    safe.send(145, 0, 100, 0, 100)
    for _ in range(200):
        safe.roomba.advance(0.015)
    assert safe.wheels_mm_s() == (100, 100)
    safe.send(opcode)
    assert safe.wheels_mm_s() == (speed, speed)


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


@pytest.mark.parametrize(
    ("drive", "contacts", "charger", "speed", "reply"),
    [
        ([145, 255, 156, 255, 156], Contacts(wheel_drops=(True, False)), 0, 0, [8, 1]),
        ([145, 255, 156, 255, 156], Contacts(wheel_drops=(False, True)), 0, 0, [4, 1]),
        ([145, 0, 100, 0, 100], Contacts(), 1, 0, [0, 1]),
        ([145, 0, 100, 0, 100], Contacts(bump_right=True), 0, 100, [1, 2]),
        (
            [132, 145, 0, 100, 0, 100],
            Contacts(cliffs=(True,) * 4, wheel_drops=(True, True)),
            0,
            100,
            [12, 3],
        ),
    ],
    ids=["left drop", "right drop", "charger", "bump", "Full mode"],
)
def test_safe_mode_stops_for_drops_and_the_charger_and_full_mode_for_nothing(
    safe, drive, contacts, charger, speed, reply
):
    safe.send(*drive)
    safe.body.contacts = contacts
    safe.roomba.overrides[Packet.CHARGING_SOURCES] = charger
    safe.roomba.advance(0.015)
    assert safe.wheels_mm_s() == (speed, speed)
    assert safe.send(149, 2, 7, 35) == reply


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
    with on_wall_clock(SimulatedRoomba(PlacedBody())) as roomba:
        terminal = os.open(roomba.path, os.O_RDWR | os.O_NOCTTY)
        try:
            os.write(terminal, bytes([128, 148, 1, 35]))
            received = b""
            while len(received) < 10 and select.select([terminal], [], [], 5.0)[0]:
                received += os.read(terminal, 10 - len(received))
        finally:
            os.close(terminal)
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


def test_in_lockstep_a_machine_that_is_slow_loses_no_command():
    line = SerialLine()
    real = open_serial(line.path)

    def write(sent):
        real.write(sent)
        raise WriteTimeout("Write timeout")  # as pyserial does when it comes back late

    slow = SimpleNamespace(name=real.name, write=write, close=real.close)
    port = line.lockstep_port(slow)
    try:
        assert port.write(b"\x80\x83") == 2
        assert line.receive() == b"\x80\x83"
    finally:
        port.close()
        line.close()
