"""The Roomba driver against the simulated base."""

import functools
import logging
import math
import random
import threading

import numpy as np
import pytest

from drivers.roomba import Roomba, RoombaConfig, open_serial
from sim_stubs.body import Contacts
from sim_stubs.clock import SimulatedClock
from sim_stubs.free_floor import FreeFloor
from sim_stubs.roomba import SimulatedRoomba, run_on_wall_clock
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.geometry import invert, planar, yaw_of
from vizbot.core.types import STOP, BaseMode, Twist

PERIOD = 0.015


class Floor:
    """An empty floor that can be made to touch the robot."""

    def __init__(self):
        self.free = FreeFloor()
        self.contacts = Contacts()
        self.speeds = (0.0, 0.0)

    def set_wheel_speeds(self, left, right):
        self.speeds = (left, right)
        self.free.set_wheel_speeds(left, right)

    def advance(self, seconds):
        self.free.advance(seconds)

    @property
    def wheel_travel(self):
        return self.free.wheel_travel


class NoisyPort:
    """A port on a line that now and then spoils, swallows or invents bytes."""

    def __init__(self, port, seed):
        self.port = port
        self.random = random.Random(seed)
        self.name = port.name
        self.write = port.write
        self.close = port.close

    @property
    def in_waiting(self):
        return self.port.in_waiting

    def read(self, size):
        received = bytearray(self.port.read(size))
        if received and self.random.random() < 0.3:
            place = self.random.randrange(len(received))
            match self.random.randrange(3):
                case 0:
                    received[place] ^= 1 << self.random.randrange(8)
                case 1:
                    del received[place]
                case 2:
                    received[place:place] = self.random.choice([b"\x13", b"\x13\xff", b"noise"])
        return bytes(received)


class Rig:
    """A driver and its simulated base in lockstep."""

    def __init__(self, encoder_counts=(0, 0), noise=None, **settings):
        self.clock = SimulatedClock()
        self.floor = Floor()
        self.stub = SimulatedRoomba(self.floor, encoder_counts)
        self.detach = self.clock.attach(self.stub)
        self.ports = []
        self.noise = noise
        self.base = Roomba(self.open_port, self.clock, RoombaConfig(**settings))

    def open_port(self):
        self.ports.append(open_serial(self.stub.path))
        port = self.stub.lockstep_port(self.ports[-1])
        return port if self.noise is None else NoisyPort(port, self.noise)

    def drive(self, twist, seconds):
        end = self.clock.now() + seconds - 1e-9
        while self.clock.now() < end:
            self.base.drive(twist)
            self.clock.sleep(PERIOD)

    def settle(self):
        """Stop, and let the last motion reach the driver."""
        self.drive(STOP, 3 * PERIOD)

    def error(self):
        """Translation [m] and heading [rad] between odometry and truth."""
        T_true_odometry = invert(self.floor.free.T_world_base) @ self.base.read().T_odom_base
        return float(np.hypot(*T_true_odometry[:2, 3])), abs(yaw_of(T_true_odometry))


@pytest.fixture
def open_rig():
    rigs = []

    def open_rig(**settings):
        rigs.append(Rig(**settings))
        return rigs[-1]

    yield open_rig
    for rig in rigs:
        rig.base.close()
        rig.stub.close()


@pytest.fixture
def rig(open_rig):
    return open_rig()


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
    rig.drive(Twist(0.2, 0.5), 2 * PERIOD)
    left, right = rig.floor.speeds
    assert (left, right) == pytest.approx((0.2 - 0.5 * 0.1175, 0.2 + 0.5 * 0.1175), abs=0.6e-3)


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


def test_odometry_after_one_metre(rig):
    rig.drive(Twist(0.25, 0.0), 4.0)
    rig.settle()
    assert rig.base.read().T_odom_base[0, 3] == pytest.approx(1.0, abs=0.01)
    distance, heading = rig.error()
    assert distance < 0.001
    assert heading < 0.004


@pytest.mark.parametrize("direction", [1, -1])
def test_odometry_after_a_full_turn(rig, direction):
    rig.drive(Twist(0.0, direction * 1.0), 2 * math.pi)
    rig.settle()
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


def test_the_wheels_stop_when_commands_stop_and_start_again(rig, caplog):
    rig.drive(Twist(0.2, 0.0), 0.5)
    last_command = rig.clock.now() - PERIOD
    while rig.floor.speeds != (0.0, 0.0):
        rig.clock.sleep(PERIOD)
        assert rig.clock.now() - last_command < 1.0
    # The stop is written at the first frame that is 0.3 s late, and holds from there on.
    assert rig.clock.now() - last_command == pytest.approx(0.3 + PERIOD, abs=1e-6)
    assert "no command for 0.3 s" in caplog.text
    rig.clock.sleep(1.0)
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(0.2, 0.0), 2 * PERIOD)
    assert rig.floor.speeds == (0.2, 0.2)


def test_commands_just_in_time_keep_the_wheels_turning(rig):
    for _ in range(5):
        rig.base.drive(Twist(0.2, 0.0))
        rig.clock.sleep(19 * PERIOD)
        assert rig.floor.speeds == (0.2, 0.2)


def test_a_base_that_falls_silent_is_reported_and_still_told_to_stop(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.stub.publish = lambda: None
    rig.drive(Twist(0.2, 0.0), 0.45)
    assert rig.base.read().mode is BaseMode.SAFE
    rig.drive(Twist(0.2, 0.0), 0.15)
    with pytest.raises(DeviceTimeoutError, match=r"no answer from the base for 0.5 s; check"):
        rig.base.read()
    assert rig.floor.speeds == (0.0, 0.0)


def test_a_base_that_speaks_again_is_read_again(rig):
    publish = rig.stub.publish
    rig.stub.publish = lambda: None
    rig.clock.sleep(1.0)
    rig.stub.publish = publish
    rig.clock.sleep(2 * PERIOD)
    assert rig.base.read().stamp == pytest.approx(rig.clock.now() - PERIOD)


@pytest.mark.parametrize(
    ("contacts", "left", "right"),
    [(Contacts(bump_left=True), True, False), (Contacts(bump_right=True), False, True)],
)
def test_a_bump_stops_forward_motion_and_lets_the_base_back_off(rig, contacts, left, right):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.floor.contacts = contacts
    rig.clock.sleep(PERIOD)
    assert rig.floor.speeds == (0.0, 0.0)
    state = rig.base.read()
    assert (state.bump_left, state.bump_right, state.bumped) == (left, right, True)
    assert state.mode is BaseMode.SAFE
    rig.drive(Twist(0.2, 1.0), 2 * PERIOD)
    assert rig.floor.speeds == pytest.approx((-0.1175, 0.1175), abs=1e-3)
    rig.drive(Twist(-0.1, 0.0), 2 * PERIOD)
    assert rig.floor.speeds == (-0.1, -0.1)


@pytest.mark.parametrize("sensor", range(4))
def test_a_cliff_ends_safe_mode_and_driving_has_no_effect_until_resumed(rig, caplog, sensor):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.floor.contacts = Contacts(cliffs=tuple(n == sensor for n in range(4)))
    rig.drive(Twist(0.2, 0.0), 0.3)
    assert rig.floor.speeds == (0.0, 0.0)
    state = rig.base.read()
    assert state.mode is BaseMode.PASSIVE
    assert [n for n in range(4) if state.cliffs[n]] == [sensor]
    assert "left Safe mode (cliff)" in caplog.text
    rig.base.resume()
    rig.clock.sleep(3 * PERIOD)
    assert rig.base.read().mode is BaseMode.SAFE
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(0.2, 0.0), 0.15)
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(-0.1, 0.0), 0.15)
    assert rig.floor.speeds == (-0.1, -0.1)


def test_resuming_does_not_bring_the_last_twist_back(rig):
    rig.floor.contacts = Contacts(wheel_drops=(True, True))
    rig.clock.sleep(0.15)
    rig.floor.contacts = Contacts()
    rig.base.drive(Twist(0.2, 0.0))
    rig.base.resume()
    rig.clock.sleep(4 * PERIOD)
    assert rig.base.read().mode is BaseMode.SAFE
    assert rig.floor.speeds == (0.0, 0.0)


@pytest.mark.parametrize("drops", [(True, False), (False, True)])
def test_a_wheel_drop_stops_the_base(rig, drops):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.floor.contacts = Contacts(wheel_drops=drops)
    rig.drive(Twist(-0.2, 0.0), 0.15)
    assert rig.floor.speeds == (0.0, 0.0)
    assert rig.base.read().wheel_drops == drops
    assert rig.base.read().mode is BaseMode.PASSIVE


def test_cliffs_and_drops_stop_the_wheels_even_if_the_base_would_not(rig):
    # A base in Full mode has its own cut-outs off.
    rig.stub.mode = BaseMode.FULL
    for contacts in (Contacts(cliffs=(True,) * 4), Contacts(wheel_drops=(True, False))):
        rig.floor.contacts = Contacts()
        rig.drive(Twist(0.2, 0.0), 0.15)
        assert rig.floor.speeds == (0.2, 0.2)
        rig.floor.contacts = contacts
        rig.clock.sleep(PERIOD)
        assert rig.floor.speeds == (0.0, 0.0)
        assert rig.base.read().mode is BaseMode.FULL


def test_safe_mode_comes_back_by_itself_only_if_the_configuration_says_so(open_rig, caplog):
    rig = open_rig(resume_safe=True)
    rig.clock.sleep(1.0)
    rig.floor.contacts = Contacts(wheel_drops=(True, True))
    rig.clock.sleep(2.0)
    assert rig.base.read().mode is BaseMode.PASSIVE
    rig.floor.contacts = Contacts()
    rig.clock.sleep(4 * PERIOD)
    assert rig.base.read().mode is BaseMode.SAFE
    assert "resume_safe" in caplog.text


def test_without_it_safe_mode_does_not_come_back(rig):
    rig.floor.contacts = Contacts(wheel_drops=(True, True))
    rig.clock.sleep(0.15)
    rig.floor.contacts = Contacts()
    rig.clock.sleep(5.0)
    assert rig.base.read().mode is BaseMode.PASSIVE


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


def journey(encoder_counts):
    """Odometry, truth and battery along one random drive, as bytes."""
    rig, steps = Rig(encoder_counts=encoder_counts, noise=5), random.Random(1)
    trace = []
    with rig.stub, rig.base:
        for _ in range(40):
            twist = Twist(steps.uniform(-0.3, 0.4), steps.uniform(-1.5, 1.5))
            rig.drive(twist, steps.uniform(0.05, 0.4))
            state = rig.base.read()
            trace += [state.T_odom_base.tobytes(), rig.floor.free.T_world_base.tobytes()]
            trace += [repr((state.stamp, state.battery, rig.clock.now())).encode()]
    return b"".join(trace)


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
    with Roomba(rig.open_port, rig.clock, RoombaConfig()) as base:
        assert base.read().mode is BaseMode.SAFE
        assert np.array_equal(base.read().T_odom_base, np.eye(4))


def test_a_base_left_driving_by_another_program_is_stopped(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.ports[0].close()  # The program dies: nobody tells the base to stop.
    end = rig.clock.now() + 0.3
    second = Roomba(rig.open_port, rig.clock, RoombaConfig())
    assert rig.clock.now() < end
    assert rig.floor.speeds == (0.0, 0.0)
    second.close()


def test_a_cable_that_is_pulled_out_is_an_error_that_stays(rig):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.detach()
    rig.stub.close()
    rig.clock.sleep(PERIOD)
    for call in (lambda: rig.base.drive(STOP), rig.base.read):
        with pytest.raises(DeviceError, match=r"the base is gone .* open it again"):
            call()
    rig.base.close()
    assert not rig.ports[0].is_open


def test_on_the_wall_clock_it_drives_and_stops_by_itself(caplog):
    caplog.set_level(logging.WARNING)
    stopped, floor, clock = threading.Event(), FreeFloor(), WallClock()
    with SimulatedRoomba(floor) as stub:
        world = threading.Thread(target=run_on_wall_clock, args=(stub, stopped))
        world.start()
        try:
            config = RoombaConfig(command_timeout=0.1)
            with Roomba(functools.partial(open_serial, stub.path), clock, config) as base:
                deadline = clock.now() + 5.0
                while base.read().T_odom_base[0, 3] < 0.03 and clock.now() < deadline:
                    base.drive(Twist(0.4, 0.0))
                    clock.sleep(0.01)
                assert base.read().T_odom_base[0, 3] >= 0.03
                while "no command for 0.1 s" not in caplog.text and clock.now() < deadline:
                    clock.sleep(0.01)
                assert "no command for 0.1 s" in caplog.text
        finally:
            stopped.set()
            world.join()


def test_odometry_turns_the_way_the_base_does(rig):
    rig.drive(Twist(0.0, 0.5), 1.0)
    rig.settle()
    expected = planar(0.0, 0.0, 0.5)
    assert rig.base.read().T_odom_base == pytest.approx(expected, abs=0.01)
