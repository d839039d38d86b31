"""Dock, battery and sleep of the simulated base."""

import math
from contextlib import closing

import numpy as np
import pytest

from drivers.roomba.commands import Opcode, encode
from drivers.roomba.packets import Buttons, ChargingSources, ChargingState, DockBeam, Packet
from drivers.roomba.serial_port import open_serial
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.roomba.dock import SimulatedDock
from tests.helpers.roomba_reply import decode_packets, dock_beams
from tests.helpers.roomba_rig import PERIOD, Floor, open_lockstep
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import planar
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import BaseMode, Charging, Twist

DOCK = SimulatedDock(planar(1.5, 0.0, math.pi))
"""Straight ahead of a robot at the origin."""
ON_DOCK = (1.35, 0.0, 0.0)


class Docked:
    """A program at the other end of the line of a base with a dock."""

    def __init__(self, start=(0.0, 0.0, 0.0), charge=1.0, dock=DOCK):
        self.floor, self.clock = Floor(planar(*start)), SimulatedClock()
        self.stub = SimulatedRoomba(self.floor, dock=dock, charge=charge)
        self.clock.attach(self.stub)
        self.port = self.stub.lockstep_port(open_serial(self.stub.path))

    def close(self):
        self.port.close()
        self.stub.close()

    def send(self, *command):
        self.port.write(bytes(command))
        self.clock.sleep(PERIOD)

    def ask(self, *packets):
        self.port.read(self.port.in_waiting)
        self.send(149, len(packets), *packets)
        values = decode_packets(packets, self.port.read(self.port.in_waiting))
        return values[packets[0]] if len(packets) == 1 else values


@pytest.fixture
def program(opened):
    return lambda **settings: opened.enter_context(closing(Docked(**settings)))


@pytest.mark.parametrize(
    ("x", "y", "beams"),
    [
        (0.0, 0.0, DockBeam.RED | DockBeam.GREEN),
        (0.0, 0.4, DockBeam.GREEN),
        (0.0, -0.4, DockBeam.RED),
        (1.1, 0.0, DockBeam.RED | DockBeam.GREEN | DockBeam.FORCE_FIELD),
        (1.7, 0.0, None),
        (-3.0, 0.0, None),
    ],
)
def test_a_robot_that_faces_the_dock_sees_green_on_its_left_and_red_on_its_right(x, y, beams):
    # Seen from the side, the dock shows the beam of that side alone.
    assert dock_beams(DOCK.infrared(planar(x, y, 0.0))[0]) == beams


def test_each_receiver_looks_to_its_side():
    ahead = DOCK.infrared(planar(0.0, 0.0, 0.0))
    assert ahead[0] == ahead[1] == ahead[2] != 0
    omni, left, right = DOCK.infrared(planar(0.0, 0.0, math.radians(-40.0)))
    assert left == omni != 0 and right == 0
    omni, left, right = DOCK.infrared(planar(0.0, 0.0, math.radians(40.0)))
    assert right == omni != 0 and left == 0
    assert DOCK.infrared(planar(0.0, 0.0, math.pi))[1:] == (0, 0)


@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0), (0.2, 0.4, 2.0), (-0.3, -0.6, -1.0)])
def test_a_base_that_seeks_its_dock_charges_there(program, start):
    program = program(start=start, charge=0.5)
    program.send(128, 143)
    for _ in range(4000):
        program.clock.sleep(PERIOD)
        if program.floor.speeds == (0.0, 0.0):
            break
    assert DOCK.touches(program.floor.T_world_base)
    assert program.stub.mode is BaseMode.PASSIVE
    assert program.ask(Packet.CHARGING_SOURCES) == ChargingSources.HOME_BASE
    assert program.ask(Packet.CHARGING_STATE) == ChargingState.FULL_CHARGING
    before = program.ask(Packet.BATTERY_CHARGE)
    program.clock.sleep(60.0)
    assert program.ask(Packet.BATTERY_CHARGE) > before
    assert program.ask(Packet.CURRENT) > 0


def test_a_dock_that_is_not_there_is_not_sought_for_ever(program):
    program = program(dock=None)
    program.send(128, 143)
    program.clock.sleep(0.1)
    assert program.floor.speeds == (0.0, 0.0)


def test_safe_mode_ends_the_charging_and_the_base_can_leave(program):
    program = program(start=ON_DOCK, charge=0.5)
    program.send(128)
    assert program.ask(Packet.CHARGING_STATE) == ChargingState.FULL_CHARGING
    program.send(131)
    assert program.ask(Packet.CHARGING_STATE) == ChargingState.NOT_CHARGING
    program.send(*encode(Opcode.DRIVE_DIRECT, -100, -100))
    program.clock.sleep(2.0)
    assert program.stub.mode is BaseMode.SAFE
    assert program.ask(Packet.CHARGING_SOURCES) == 0


def test_a_full_battery_is_charged_no_more(program):
    program = program(start=ON_DOCK)
    program.send(128)
    assert program.ask(Packet.CHARGING_STATE) == ChargingState.WAITING
    assert program.ask(Packet.CURRENT) == 0


def test_an_empty_battery_ends_everything(program):
    program = program(charge=1e-4)
    program.send(128, 131)
    program.send(*encode(Opcode.DRIVE_DIRECT, 100, 100))
    program.clock.sleep(30.0)
    assert program.stub.asleep
    assert program.floor.speeds == (0.0, 0.0)
    program.stub.press(Buttons.CLEAN)
    assert program.stub.asleep


@pytest.mark.slow
def test_a_base_falls_asleep_in_passive_mode_alone_and_a_button_wakes_it(program):
    program = program()
    program.send(128, 131)
    program.clock.sleep(400.0)
    assert not program.stub.asleep
    program.send(128)
    program.clock.sleep(299.0)
    assert program.ask(Packet.OI_MODE) == BaseMode.PASSIVE
    program.clock.sleep(301.0)
    program.send(128)
    program.send(142, 35)
    assert program.stub.asleep
    assert program.port.in_waiting == 0
    program.stub.press(Buttons.CLEAN)
    program.send(128)
    assert program.ask(Packet.OI_MODE) == BaseMode.PASSIVE


def test_the_driver_says_what_to_do_about_a_sleeping_base_and_about_one_on_its_dock(program):
    program = program(charge=0.5)
    program.send(128)
    program.clock.sleep(301.0)
    with pytest.raises(DeviceError, match=r"is asleep.* press Clean"):
        open_lockstep(lambda: program.port, program.clock, start_timeout=0.6)


def test_the_driver_reads_dock_and_charger(program):
    program = program(start=ON_DOCK, charge=0.5)
    with open_lockstep(lambda: program.port, program.clock) as base:
        state = base.read()
        assert state.docked and state.charging is Charging.NOT_CHARGING
        assert state.battery == pytest.approx(0.5, abs=0.01)
        assert state.current < 0.0 < state.voltage
        assert dock_beams(state.infrared[0]) & DockBeam.FORCE_FIELD
        for _ in range(100):
            base.drive(Twist(-0.1, 0.0))
            program.clock.sleep(PERIOD)
        assert not base.read().docked
        np.testing.assert_allclose(base.read().T_odom_base[0, 3], -0.14, atol=0.02)
