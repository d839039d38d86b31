"""What the doctor finds out about a base, on a simulated one; nothing moves."""

import itertools
from contextlib import contextmanager

import numpy as np
import pytest

from drivers.roomba.commands import Opcode
from drivers.roomba.examination import examine_base
from drivers.roomba.packets import Packet
from drivers.roomba.serial_port import open_serial
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.roomba.dock import SimulatedDock
from sim_stubs.world.body import FreeFloor
from tests.helpers.failing import raising
from tests.helpers.roomba_rig import NoisyPort
from vizbot import doctor
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import BaseMode, BaseState, Charging
from vizbot.doctor import Grade


@contextmanager
def base_on(floor, clock, change=lambda stub: None, wrap=lambda port: port, **settings):
    """A simulated base, changed by `change`, and what opens its port."""
    with SimulatedRoomba(floor, **settings) as stub:
        clock.attach(stub)
        change(stub)
        yield stub, lambda path: wrap(stub.lockstep_port(open_serial(path)))


def examined(**settings):
    """What is found out about a simulated base; `base_on` tells the arguments."""
    clock, floor = SimulatedClock(), FreeFloor()
    with base_on(floor, clock, **settings) as (stub, open_port):
        port = open_port(stub.path)
        found = examine_base(port, clock)
        clock.sleep(0.1)
        assert floor.wheel_travel == (0.0, 0.0)
        assert stub.mode in (BaseMode.OFF, BaseMode.PASSIVE)
        port.close()
    return found


def sensing(packet, value):
    return lambda stub: stub.overrides.update({packet: value})


def silent(stub):
    stub.publish = lambda: None


MODE_TOO_HIGH = sensing(Packet.OI_MODE, BaseMode.PASSIVE + 1)


def test_a_sound_base_is_described_and_never_moved():
    found = examined(charge=0.6)
    assert found.rate == pytest.approx(66.7, abs=1.0)
    assert found.spoilt == 0.0
    assert found.state.mode is BaseMode.PASSIVE
    assert found.state.battery == pytest.approx(0.6, abs=0.01)
    assert found.mode_offset == 0
    assert found.firmware == "release-3.8.2"


def test_a_line_that_spoils_bytes_is_measured():
    found = examined(wrap=lambda port: NoisyPort(port, seed=1))
    assert 0.1 < found.spoilt < 0.6
    assert 20.0 < found.rate < 60.0


def test_firmware_that_reports_its_mode_one_too_high_is_named():
    assert examined(change=MODE_TOO_HIGH).mode_offset == 1


def test_a_base_that_says_nothing_has_no_state():
    found = examined(change=silent)
    assert found.state is None and found.rate == 0.0 and found.firmware is None


def test_a_base_on_its_dock_is_not_reset():
    sent = []

    def listen(port):
        write = port.write
        port.write = lambda command: (sent.append(command), write(command))[1]
        return port

    found = examined(wrap=listen, dock=SimulatedDock(planar(0.15, 0.0, np.pi)), charge=0.5)
    assert found.state.docked and found.firmware is None
    assert bytes([Opcode.RESET]) not in sent


@pytest.fixture
def diagnosed(monkeypatch):
    """What the doctor says of a simulated base, by subject; `base_on` tells the arguments."""

    def run(**settings):
        clock = SimulatedClock()
        with base_on(FreeFloor(), clock, **settings) as (stub, open_port):
            monkeypatch.setattr("drivers.roomba.serial_port.open_serial", open_port)
            findings = list(doctor._base(Config(serial_port=stub.path), clock))
        assert clock.now() < doctor.TIMEOUT
        return {finding.subject: finding for finding in findings}

    return run


def one_frame_in_five_is_missing(stub):
    publish, turns = stub.publish, itertools.cycle([True, True, True, True, False])
    stub.publish = lambda: publish() if next(turns) else None


def chatter(port):
    """Bytes of no frame between the frames, none of which they spoil."""
    read = port.read
    port.read = lambda size: read(size) + b"\0\0"
    return port


def unplugged(port):
    port.write = raising(OSError("device disconnected"))
    return port


def test_a_sound_base_is_good_in_every_respect(diagnosed):
    findings = diagnosed(charge=0.6)
    assert list(findings) == ["serial port", "base", "base's stream", "battery"]
    assert {each.verdict for each in findings.values()} == {Grade.GOOD}
    assert findings["base"].found == "release-3.8.2, after Start it is in Passive mode"
    assert findings["base's stream"].found == "67 frames/s, 0.0 % of the bytes spoilt"
    assert "60 %" in findings["battery"].found


@pytest.mark.parametrize(
    ("faults", "subject", "verdict", "found", "remedy"),
    [
        ({"wrap": unplugged}, "base", Grade.BAD, "device disconnected", "its cable"),
        ({"change": silent}, "base", Grade.BAD, "no sensor frames", "press Clean"),
        ({"change": one_frame_in_five_is_missing},
         "base's stream", Grade.POOR, "54 frames/s, 0.0 %", "other programs"),
        ({"wrap": chatter}, "base's stream", Grade.POOR, "67 frames/s, 3.2 %", "shorter cable"),
        ({"wrap": lambda port: NoisyPort(port, seed=1)},
         "base's stream", Grade.POOR, "% of the bytes spoilt", "away from motors"),
        ({"charge": 0.05}, "battery", Grade.BAD, "5 %", "on its dock"),
        ({"change": sensing(Packet.CLIFF_LEFT, 1)},
         "wheels", Grade.POOR, "an edge", "open floor"),
        ({"change": sensing(Packet.BUMPS_AND_WHEEL_DROPS, 4)},
         "wheels", Grade.POOR, "a wheel hangs", "open floor"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_base_is_told_with_its_remedy(
    diagnosed, faults, subject, verdict, found, remedy
):
    finding = diagnosed(**faults)[subject]
    assert finding.verdict is verdict
    assert found in finding.found and remedy in finding.remedy


def test_firmware_is_told_as_it_was_found(diagnosed):
    shifted = diagnosed(change=MODE_TOO_HIGH)["base"]
    assert shifted.found.endswith("in Passive mode, reports its mode one too high")
    docked = diagnosed(dock=SimulatedDock(planar(0.15, 0.0, np.pi)))["base"]
    assert docked.found.startswith("firmware unknown")


@pytest.mark.parametrize(
    ("battery", "felt", "told"),
    [
        (0.9, {}, {"battery": (Grade.GOOD, "")}),
        (0.9, {"docked": True}, {"battery": (Grade.POOR, "off its charger")}),
        (0.15, {}, {"battery": (Grade.POOR, "on its dock")}),
        (0.15, {"docked": True}, {"battery": (Grade.POOR, "let it charge")}),
        (0.02, {}, {"battery": (Grade.BAD, "on its dock")}),
        (0.02, {"docked": True, "charging": Charging.FULL_CHARGING},
         {"battery": (Grade.BAD, "let it charge")}),
        (0.02, {"docked": True, "charging": Charging.FAULT},
         {"charger": (Grade.POOR, "contacts"), "battery": (Grade.BAD, "let it charge")}),
        (None, {}, {"battery": (Grade.POOR, "charge it once")}),
    ],
)  # fmt: skip
def test_a_battery_that_is_nearly_empty_is_bad_on_its_charger_too(battery, felt, told):
    floor = (False,) * 4, (False,) * 2
    state = BaseState(
        0.0, np.eye(4), False, False, *floor, battery, BaseMode.PASSIVE, voltage=14.2, **felt
    )
    findings = {each.subject: each for each in doctor._battery(state)}
    assert findings.keys() == told.keys()
    for subject, (verdict, remedy) in told.items():
        assert findings[subject].verdict is verdict
        assert remedy in findings[subject].remedy
        assert bool(remedy) == bool(findings[subject].remedy)
