"""The Roomba driver and its simulated base in lockstep."""

import random
import time
from contextlib import contextmanager

import numpy as np

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.drive_command import STOP_WHEELS
from drivers.roomba.serial_port import open_serial
from drivers.roomba.service import LockstepLink
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.body import Contacts, FreeFloor
from vizbot.core.geometry import invert, yaw_of
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import STOP, Twist

CLOCK_GETTIME = time.clock_gettime
PERIOD = 0.015
DEADLINE = 30.0


ASKED_EVERY = 0.03
"""So often a robot answers whoever polls it [s]."""


def wait_for(condition, pause=0.0):
    """What happens on the wall clock happens in time; it is looked for with a `pause` [s]."""
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(pause)


def resting(floor):
    """Whether the wheels rest for some sensor frames."""
    before, end = floor.wheel_travel, time.monotonic() + 0.1
    while time.monotonic() < end:
        if floor.wheel_travel != before:
            return False
    return True


class Floor:
    """An empty floor that can be made to touch the robot."""

    def __init__(self, T_world_base=None):
        self.free = FreeFloor(T_world_base=T_world_base)
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

    @property
    def T_world_base(self):
        return self.free.T_world_base


class TimedFloor(Floor):
    """A floor that knows since when the wheels have been told to rest; None while they turn."""

    def __init__(self):
        super().__init__()
        self.rest_since = time.monotonic()

    def set_wheel_speeds(self, left, right):
        super().set_wheel_speeds(left, right)
        if any(self.speeds):
            self.rest_since = None
        elif self.rest_since is None:
            self.rest_since = time.monotonic()


def rested(floor, seconds):
    since = floor.rest_since
    return since is not None and time.monotonic() - since > seconds


class WrappedPort:
    """What a test does not change of a port is done by the port itself."""

    def __init__(self, port):
        self.port = port

    def __getattr__(self, name):
        return getattr(self.port, name)


class NoisyPort(WrappedPort):
    """A port on a line that now and then spoils, swallows or invents bytes."""

    def __init__(self, port, seed):
        super().__init__(port)
        self.random = random.Random(seed)

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


def open_lockstep(open_port, clock, **settings):
    config = RoombaConfig(**settings)
    return Roomba(LockstepLink(open_port, clock, config), clock, config)


class Rig:
    """A driver and its simulated base in lockstep."""

    def __init__(self, encoder_counts=(0, 0), noise=None, **settings):
        self.clock = SimulatedClock()
        self.floor = Floor()
        self.stub = self.stub_on(self.floor, encoder_counts)
        self.detach = self.clock.attach(self.stub)
        self.ports = []
        self.noise = noise
        self.settings = {"acceleration": 100.0, "deceleration": 100.0} | settings  # no ramps
        self.base = self.open_base()

    def stub_on(self, floor, encoder_counts):
        return SimulatedRoomba(floor, encoder_counts)

    def open_base(self):
        return open_lockstep(self.open_port, self.clock, **self.settings)

    def open_port(self):
        self.ports.append(open_serial(self.stub.path))
        port = self.stub.lockstep_port(self.ports[-1])
        return port if self.noise is None else NoisyPort(port, self.noise)

    def close(self):
        self.base.close()
        self.stub.close()

    def unplug(self):
        """Whoever gets the pseudo-terminal's number next is not this base."""
        self.detach()
        self.stub.close()
        self.stub.path = "/dev/pulled-out"

    @contextmanager
    def silence(self):
        """The base sends nothing meanwhile."""
        publish, self.stub.publish = self.stub.publish, lambda: None
        yield
        self.stub.publish = publish

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


class HangingAddress:
    """A port whose reader hangs, busy for ever, once the file `signal` is there."""

    def __init__(self, path, signal):
        self.path, self.signal = path, signal

    def open(self):
        port = open_serial(self.path)
        read = port.read

        def hanging(size):
            if self.signal.exists():
                self.signal.unlink()
                while True:
                    pass
            return read(size)

        port.read = hanging
        return port


class SleepyAddress:
    """A port on a machine that has been suspended for an hour once the file `signal` is there."""

    def __init__(self, path, signal):
        self.path, self.signal = path, signal

    def open(self):
        def clock_gettime(clock):
            asleep = 3600.0 if clock == time.CLOCK_BOOTTIME and self.signal.exists() else 0.0
            return CLOCK_GETTIME(clock) + asleep

        time.clock_gettime = clock_gettime
        return open_serial(self.path)


class BadLine(WrappedPort):
    """A port that does something to one byte of all that is written."""

    def __init__(self, port, number, spoil):
        super().__init__(port)
        self.number, self.spoil = number, spoil
        self.written = 0
        self.requests = []

    def write(self, sent):
        place, sent = self.number - self.written, bytearray(sent)
        if len(sent) > len(STOP_WHEELS):
            self.requests += range(self.written, self.written + len(sent))
        self.written += len(sent)
        if 0 <= place < len(sent):
            sent[place : place + 1] = self.spoil(sent[place])
        return self.port.write(bytes(sent))


class BadLineRig(Rig):
    def __init__(self, number, spoil):
        self.bad = (number, spoil)
        self.modes = []
        super().__init__()

    def open_port(self):
        self.line = BadLine(super().open_port(), *self.bad)
        return self.line


def since(then, now):
    return [after - before for before, after in zip(then, now, strict=True)]


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
