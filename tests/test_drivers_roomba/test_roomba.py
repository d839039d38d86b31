"""The Roomba driver against the simulated base."""

import logging
import math

import numpy as np
import pytest

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.packets import Packet
from drivers.roomba.reflex_process.process_link import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from sim_stubs.world.body import FreeFloor
from tests.helpers.roomba_rig import PERIOD, journey
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.geometry import planar
from vizbot.core.types import STOP, BaseMode, Twist


def test_it_opens_in_safe_mode_at_the_origin(rig):
    state = rig.base.read()
    assert state.mode is BaseMode.SAFE
    assert np.array_equal(state.T_odom_base, np.eye(4))
    assert not state.bumped
    assert state.cliffs == (False, False, False, False)
    assert state.wheel_drops == (False, False)
    assert state.battery == pytest.approx(1.0, abs=1e-3)
    assert rig.clock.now() < 0.1


def test_the_right_wheel_is_the_faster_one_in_a_left_turn(rig):
    rig.drive(Twist(0.3, 0.5), 2 * PERIOD)
    left, right = rig.floor.speeds
    assert (left, right) == pytest.approx((0.3 - 0.5 * 0.1175, 0.3 + 0.5 * 0.1175), abs=0.6e-3)


def test_a_twist_that_is_too_fast_keeps_its_curvature(rig):
    rig.drive(Twist(1.0, 2.0), 2 * PERIOD)
    left, right = rig.floor.speeds
    assert right == pytest.approx(0.5, abs=1e-3)
    assert (right - left) / 0.235 / ((right + left) / 2) == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize("twist", [Twist(math.nan, 0.0), Twist(0.0, math.inf)])
def test_a_twist_that_is_no_number_is_refused(rig, twist):
    with pytest.raises(ValueError, match="finite"):
        rig.base.drive(twist)
    rig.clock.sleep(PERIOD)
    assert rig.base.read().mode is BaseMode.SAFE


@pytest.mark.parametrize(
    ("twist", "seconds", "moved"),
    [
        (Twist(0.25, 0.0), 4.0, planar(1.0, 0.0, 0.0)),
        (Twist(0.0, 0.5), 1.0, planar(0.0, 0.0, 0.5)),
        (Twist(0.0, 1.0), 2 * math.pi, None),
        (Twist(0.0, -1.0), 2 * math.pi, None),
    ],
)
def test_odometry_is_the_way_that_was_asked_for_and_driven(rig, twist, seconds, moved):
    rig.drive(twist, seconds)
    rig.settle()
    assert moved is None or rig.base.read().T_odom_base == pytest.approx(moved, abs=0.01)
    distance, heading = rig.error()
    assert distance < 0.001
    # Each wheel is known to half a count, 0.11 degrees of heading for both.
    assert heading < 0.004


def test_odometry_along_arcs(rig):
    for twist in (Twist(0.3, 0.8), Twist(-0.2, 0.3), Twist(0.1, -1.5)):
        rig.drive(twist, 3.0)
    rig.settle()
    distance, heading = rig.error()
    assert distance < 0.01
    assert heading < 0.01


@pytest.mark.parametrize("speed", [0.4, -0.4])
@pytest.mark.parametrize("encoder_counts", [(32500, 32700), (-32700, -32500), (300, -300)])
def test_encoders_roll_over_both_ways(open_rig, encoder_counts, speed):
    rig = open_rig(encoder_counts=encoder_counts)
    rig.drive(Twist(speed, 0.0), 2.5)
    rig.settle()
    assert rig.base.read().T_odom_base[0, 3] == pytest.approx(2.5 * speed, abs=0.01)
    assert rig.error()[0] < 0.001


def test_odometry_starts_at_the_origin_wherever_the_encoders_stand(open_rig):
    rig = open_rig(encoder_counts=(12345, -6789))
    assert np.array_equal(rig.base.read().T_odom_base, np.eye(4))


def test_calibration_scales_odometry_and_commands_alike(open_rig):
    rig = open_rig(wheel_scale=1.02)
    rig.drive(Twist(0.25, 0.0), 2.0)
    rig.settle()
    # The simulated wheels are the manual's: they roll less than this driver believes.
    assert rig.floor.free.T_world_base[0, 3] == pytest.approx(0.5 / 1.02, abs=0.005)
    assert rig.base.read().T_odom_base[0, 3] == pytest.approx(0.5, abs=0.005)


@pytest.mark.parametrize("seed", range(3))
def test_noise_on_the_line_costs_only_frames(open_rig, seed):
    rig = open_rig(noise=seed)
    for twist in (Twist(0.25, 0.0), Twist(0.1, 1.0), Twist(-0.2, -0.3)):
        rig.drive(twist, 2.0)
    rig.settle()
    rig.drive(STOP, 0.3)
    distance, heading = rig.error()
    assert rig.base.read().mode is BaseMode.SAFE
    # Frames that are lost in a turn are bridged by one arc.
    assert distance < 0.01
    assert heading < 0.01


def test_two_runs_in_lockstep_are_the_same_to_the_byte():
    assert journey((32000, -32000)) == journey((32000, -32000))


def test_closing_stops_the_wheels_and_lets_the_base_charge(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.base.close()
    rig.clock.sleep(2 * PERIOD)
    assert rig.floor.speeds == (0.0, 0.0)
    assert rig.stub.mode is BaseMode.PASSIVE
    assert not rig.ports[0].is_open


def test_a_closed_base_refuses_everything_but_closing(rig):
    rig.base.close()
    rig.base.close()
    for call in (lambda: rig.base.drive(STOP), rig.base.read, rig.base.resume):
        with pytest.raises(DeviceError, match="closed"):
            call()


def test_leaving_the_with_block_closes(rig):
    with rig.base as base:
        base.drive(Twist(0.1, 0.0))
    with pytest.raises(DeviceError, match="closed"):
        base.read()


def test_a_base_can_be_opened_again(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.base.close()
    rig.clock.sleep(0.15)
    with rig.open_base() as base:
        assert base.read().mode is BaseMode.SAFE
        assert np.array_equal(base.read().T_odom_base, np.eye(4))


def test_a_base_left_driving_by_another_program_is_stopped(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.ports[0].close()  # The program dies: nobody tells the base to stop.
    end = rig.clock.now() + 0.3
    second = rig.open_base()
    assert rig.clock.now() < end
    assert rig.floor.speeds == (0.0, 0.0)
    second.close()


def test_a_cable_that_is_pulled_out_is_waited_for_and_at_last_an_error_that_stays(rig):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.unplug()
    rig.clock.sleep(PERIOD)
    assert not rig.ports[0].is_open
    with pytest.raises(DeviceTimeoutError, match=r"the base is gone .* plug its cable in again"):
        rig.base.read()
    rig.base.drive(Twist(0.2, 0.0))
    rig.clock.sleep(64.0)
    for call in (lambda: rig.base.drive(STOP), rig.base.read):
        with pytest.raises(DeviceError, match="then launch again"):
            call()
    rig.base.close()


def test_another_base_that_is_plugged_in_instead_is_stopped_and_the_odometry_goes_on(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.settle()
    T_odom_base = rig.base.read().T_odom_base
    rig.floor.set_wheel_speeds(0.2, 0.2)  # the base runs on
    rig.unplug()
    rig.drive(Twist(0.2, 0.0), 1.0)
    rig.stub = SimulatedRoomba(rig.floor, encoder_counts=(30000, -30000))
    rig.floor.set_wheel_speeds(0.2, 0.2)
    rig.stub.mode = BaseMode.SAFE
    rig.detach = rig.clock.attach(rig.stub)
    found = rig.clock.now()
    while rig.floor.speeds != (0.0, 0.0):
        rig.clock.sleep(PERIOD)
        assert rig.clock.now() - found < 2.1
    rig.clock.sleep(1.0)
    state = rig.base.read()
    assert state.maybe_moved
    assert np.array_equal(state.T_odom_base, T_odom_base)
    rig.base.resume()
    rig.clock.sleep(0.1)
    rig.drive(Twist(0.2, 0.0), 1.0)
    rig.settle()
    assert rig.base.read().T_odom_base[0, 3] == pytest.approx(T_odom_base[0, 3] + 0.2, abs=0.01)


def test_what_a_base_that_was_restarted_meanwhile_counts_is_no_motion(rig):
    rig.drive(Twist(0.2, 0.0), 1.0)
    rig.settle()
    T_odom_base = rig.base.read().T_odom_base
    rig.unplug()
    rig.clock.sleep(1.0)
    rig.stub = SimulatedRoomba(rig.floor)
    rig.detach = rig.clock.attach(rig.stub)
    rig.clock.sleep(1.0)
    state = rig.base.read()
    assert state.maybe_moved
    assert np.array_equal(state.T_odom_base, T_odom_base)


def test_encoders_that_jump_are_rejected(rig, caplog):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.stub.overrides[Packet.LEFT_ENCODER] = 20000
    rig.drive(Twist(0.2, 0.0), PERIOD)
    del rig.stub.overrides[Packet.LEFT_ENCODER]
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.settle()
    distance, heading = rig.error()
    assert "jumped" in caplog.text
    assert distance < 0.01
    assert heading < 0.01


def test_on_the_wall_clock_it_drives_and_stops_by_itself(caplog):
    caplog.set_level(logging.WARNING)
    clock, config = WallClock(), RoombaConfig(command_timeout=0.1, silence_timeout=0.5)
    with on_wall_clock(SimulatedRoomba(FreeFloor())) as stub:
        link = ProcessLink(SerialAddress(stub.path).open, config)
        with Roomba(link, clock, config) as base:
            deadline = clock.now() + 5.0
            while base.read().T_odom_base[0, 3] < 0.03 and clock.now() < deadline:
                base.drive(Twist(0.4, 0.0))
                clock.sleep(0.01)
            assert base.read().T_odom_base[0, 3] >= 0.03
            while "no command for 0.1 s" not in caplog.text and clock.now() < deadline:
                base.read()  # what the process of the base logs comes along
                clock.sleep(0.01)
            assert "no command for 0.1 s" in caplog.text
