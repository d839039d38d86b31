"""What faults do to the simulated base and encoder, seen from the robot's side of them."""

from contextlib import closing

import numpy as np
import pytest

from drivers.roomba.commands import Opcode
from drivers.roomba.control import RoombaControl
from drivers.roomba.packets import Packet
from sim_stubs.faults.catalogue import FaultSchedule, parse_faults
from sim_stubs.faults.faulty_base import FaultyLine, FaultyRoomba
from sim_stubs.faults.faulty_body import FaultyBody
from sim_stubs.faults.faulty_program import FaultyEncoder
from sim_stubs.world.body import FreeFloor
from tests.helpers.roomba_rig import Rig
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.types import BaseMode, Twist

AHEAD = Twist(0.2, 0.0)


class FaultyRig(Rig):
    """A driver on a base to which something happens."""

    def __init__(self, faults, **settings):
        self.faults = faults
        self.looked_at = []
        super().__init__(**settings)

    def stub_on(self, floor, encoder_counts):
        schedule = FaultSchedule(parse_faults(self.faults), self.clock.now, 0)
        return FaultyRoomba(floor, schedule, 0, floor.free.place)

    def open_port(self):
        self.looked_at.append(self.clock.now())
        return super().open_port()


@pytest.fixture
def open_rig(opened):
    return lambda faults, **settings: opened.enter_context(closing(FaultyRig(faults, **settings)))


def x_of(rig):
    return float(rig.floor.T_world_base[0, 3])


@pytest.mark.parametrize("kind", ["corrupt-bytes", "lost-bytes", "duplicated-bytes"])
def test_a_bad_line_hits_one_byte_in_a_hundred(kind):
    schedule = FaultSchedule(parse_faults(kind), lambda: 0.0, 0)
    sent = bytes(range(256)) * 100
    for received in (FaultyLine(schedule, 3).to_host(sent), FaultyLine(schedule, 4).to_robot(sent)):
        change = len(received) - len(sent)
        if kind == "corrupt-bytes":
            spoilt = sum(a != b for a, b in zip(sent, received, strict=True))
            assert change == 0
        else:
            spoilt = change if kind == "duplicated-bytes" else -change
        assert spoilt == pytest.approx(256, abs=60)


def test_a_base_behind_glass_feels_it_and_gets_no_farther(open_rig):
    rig = open_rig("bump@2")
    rig.drive(AHEAD, 2.0)
    touched_from = x_of(rig)
    felt = []
    for _ in range(60):
        rig.drive(AHEAD, 0.015)
        felt.append(rig.base.read().bumped)
    assert any(felt)
    assert x_of(rig) - touched_from < 0.04
    rig.drive(Twist(-0.1, 0.0), 0.5)
    rig.base.read()  # of the time before
    rig.drive(Twist(0.0, 0.0), 0.1)
    assert not rig.base.read().bumped
    rig.drive(Twist(0.0, 1.0), 1.6)  # a pane has an end: it can be driven around
    rig.drive(AHEAD, 3.0)
    rig.drive(Twist(0.0, -1.0), 1.6)
    before = x_of(rig)
    rig.drive(AHEAD, 2.0)
    assert x_of(rig) - before > 0.3


def test_a_base_at_an_edge_stops_and_can_back_off(open_rig):
    rig = open_rig("cliff@1", resume_safe=True)
    rig.drive(AHEAD, 1.6)
    assert any(rig.base.read().cliffs)
    at_edge = x_of(rig)
    rig.drive(Twist(-0.1, 0.0), 1.5)
    assert x_of(rig) < at_edge - 0.05
    rig.base.read()  # of the time before
    rig.drive(Twist(0.0, 0.0), 0.1)
    assert not any(rig.base.read().cliffs)


def test_a_stuck_wheel_draws_too_much_and_does_not_turn(open_rig):
    rig = open_rig("stuck-wheel@1+2")
    rig.drive(AHEAD, 1.0)
    before = rig.floor.wheel_travel
    rig.drive(AHEAD, 0.3)
    assert rig.base.read().overcurrents == (True, False)
    assert rig.floor.wheel_travel[0] - before[0] < 0.005


def test_slipping_wheels_count_more_than_they_roll(open_rig):
    rig = open_rig("wheel-slip@1+2")
    rig.drive(AHEAD, 1.0)
    rolled, counted = x_of(rig), rig.base.read().T_odom_base[0, 3]
    rig.drive(AHEAD, 1.5)
    rolled, counted = x_of(rig) - rolled, rig.base.read().T_odom_base[0, 3] - counted
    assert counted / rolled == pytest.approx(1.4, abs=0.05)


def test_a_cable_that_is_out_is_found_again_and_the_base_stopped_first(open_rig):
    rig = open_rig("port-vanishes@1+1")
    rig.drive(AHEAD, 1.03)
    with pytest.raises(DeviceTimeoutError, match="plug its cable in again"):
        rig.base.read()
    assert sum(rig.floor.speeds) > 0.0
    rig.clock.sleep(1.5)
    assert sum(rig.floor.speeds) == 0.0
    rig.drive(AHEAD, 1.0)
    assert rig.base.read().mode is BaseMode.SAFE
    assert sum(rig.floor.speeds) > 0.0
    rig.settle()
    assert x_of(rig) > 0.5
    assert rig.error()[0] < 0.01  # how far it ran on meanwhile is known, too


def test_a_cable_that_is_out_is_looked_for_soon_and_then_less_often(open_rig):
    rig = open_rig("port-vanishes@1+2,port-vanishes@5+0.5")
    rig.clock.sleep(8.0)
    began, *looks = rig.looked_at
    once, again = [1.1, 1.3, 1.7, 2.1, 2.5, 2.9, 3.3], [5.1, 5.3, 5.7]
    assert began == 0.0
    assert looks == pytest.approx(once + again, abs=0.05)  # each waits for its period


def test_a_base_that_fell_asleep_obeys_again_once_somebody_pressed_clean_and_says_so(open_rig):
    rig = open_rig("base-asleep@1+2")
    rig.drive(AHEAD, 2.0)
    with pytest.raises(DeviceTimeoutError, match="press Clean"):
        rig.base.read()
    rig.drive(AHEAD, 3.0)
    assert rig.base.read().maybe_moved  # it slept for longer than a second
    rig.base.resume()
    rig.drive(AHEAD, 0.2)
    assert rig.base.read().mode is BaseMode.SAFE
    assert sum(rig.floor.speeds) > 0.0


@pytest.mark.parametrize(("full_mode", "reported"), [(False, 3), (True, 4)])
def test_firmware_with_the_mode_one_too_high_calls_safe_3_and_full_4(
    open_rig, monkeypatch, full_mode, reported
):
    seen = []

    def listen(control, values, now, observe=RoombaControl._observe):
        seen.append(values[Packet.OI_MODE])
        observe(control, values, now)

    monkeypatch.setattr(RoombaControl, "_observe", listen)
    rig = open_rig("mode-off-by-one", full_mode=full_mode)
    rig.drive(AHEAD, 1.0)
    assert seen[0] == 2
    assert seen[-1] == reported
    assert rig.base.read().mode is (BaseMode.FULL if full_mode else BaseMode.SAFE)
    assert sum(rig.floor.speeds) > 0.0


@pytest.mark.parametrize(
    ("fault", "felt", "mode"),
    [
        ("virtual-wall", "blocked", BaseMode.SAFE),
        ("charger-plugged", "plugged_in", BaseMode.PASSIVE),
    ],
)
def test_a_virtual_wall_and_a_charger_stop_it_while_they_last(open_rig, fault, felt, mode):
    rig = open_rig(f"{fault}@1+1", resume_safe=fault == "charger-plugged")
    rig.drive(AHEAD, 1.1)
    state = rig.base.read()
    assert getattr(state, felt)
    assert state.mode is mode
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(AHEAD, 1.0)
    rig.base.read()  # of the time before
    rig.drive(AHEAD, 1.0)
    assert not getattr(rig.base.read(), felt)
    assert sum(rig.floor.speeds) > 0.0


def test_what_the_program_says_is_overheard_before_the_line_spoils_it(open_rig):
    rig = open_rig("lost-bytes")
    rig.drive(AHEAD, 1.0)
    told = [c for c in rig.stub.sent if c.opcode is Opcode.DRIVE_DIRECT]
    assert told[-1].arguments == (200, 200)


def test_a_port_is_held_from_when_it_is_opened_until_its_cable_is_out(open_rig):
    rig = open_rig("port-vanishes@1+1")
    assert rig.stub.connected
    rig.clock.sleep(1.1)
    assert not rig.stub.connected
    rig.clock.sleep(1.5)
    assert rig.stub.connected


def test_an_empty_battery_is_told(open_rig):
    rig = open_rig("battery-low@1")
    assert rig.base.read().battery > 0.9
    rig.clock.sleep(1.5)
    assert rig.base.read().battery == pytest.approx(0.05)


def test_a_robot_is_carried_back_to_where_it_has_been(open_rig):
    rig = open_rig("kidnapped@10")
    rig.drive(AHEAD, 9.5)
    farthest = x_of(rig)
    rig.drive(AHEAD, 1.0)
    x, y = rig.floor.T_world_base[:2, 3]
    assert 0.0 <= x <= farthest - 1.0
    assert abs(y) < 0.05
    assert rig.base.read().wheel_drops == (True, True)


def test_glass_appears_each_time_anew(open_rig):
    rig = open_rig("bump@1+1,bump@5+1")
    felt = []
    for _ in range(14):
        rig.drive(AHEAD, 0.5)
        felt.append(rig.base.read().bumped)
    assert any(felt[2:5])
    assert not any(felt[6:10])
    assert any(felt[10:13])


def test_an_encoder_without_memory_says_so(mean_colours):
    schedule = FaultSchedule(parse_faults("encoder-out-of-memory"), lambda: 0.0, 0)
    encoder = FaultyEncoder(mean_colours, schedule)
    with pytest.raises(DeviceError, match="out of memory"):
        encoder.embed_images([np.zeros((8, 8, 3), np.uint8)])
    assert encoder.embed_texts(["sofa"]).shape == (1, mean_colours.dimension)


def test_a_body_in_somebodys_hands_does_not_roll():
    floor = FreeFloor()
    schedule = FaultSchedule(parse_faults("wheel-drop"), lambda: 0.0, 0)
    body = FaultyBody(floor, schedule, 0, floor.place)
    body.set_wheel_speeds(0.2, 0.2)
    body.advance(1.0)
    assert body.contacts.wheel_drops == (True, True)
    assert floor.T_world_base[0, 3] == 0.0
