"""How soon the wheels rest on the wall clock: by reflexes, and by the program where these hang.

For the reflexes three processes take part, as on the robot. This one drives and holds its
interpreter's lock for long stretches, as GTSAM and the camera SDK do. The second one owns the port.
The third one simulates the base, presses its bumper and waits until the wheels are commanded to
rest. Once watchdog and reflexes both hang, the program alone is left to notice. It has the
product's settings, and drives straight ahead.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection
from statistics import median

import numpy as np

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.process_link import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from drivers.roomba.stream import PERIOD
from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from sim_stubs.world.body import Contacts, FreeFloor
from vizbot.core.clock import WallClock
from vizbot.core.types import Twist

BUMPS, HANGS = 200, 5
_HELD = 0.2
"""Time for which the lock is held at a time [s]; commands older than 0.3 s are void."""
_FREE = 0.002
_LONGEST = 30.0
"""Longest time until the base obeys [s]."""
_PATIENCE, _HANG_PATIENCE = 1.0, 5.0
"""Time after which a base counts as not stopped, by reflexes and by the program [s]."""
_PERIOD = 0.01


@dataclass(frozen=True, slots=True)
class ReflexLatency:
    """Time from the sensor frame with a bump to the command that stops the wheels.

    Attributes:
        bumps: Number of bumps.
        stopped: Number of bumps after which the wheels were stopped at all.
        median_ms: Median time of those.
        p99_ms: 99th percentile.
        max_ms: Longest time.
        held_ms: Time for which the program held its lock at a time.
    """

    bumps: int
    stopped: int
    median_ms: float
    p99_ms: float
    max_ms: float
    held_ms: float

    def summary(self) -> str:
        """The result as a paragraph."""
        return (
            f"Reflexes on the wall clock, while the program holds its interpreter's lock for"
            f" {self.held_ms:.0f} ms at a time: {self.stopped} of {self.bumps} bumps stopped the"
            f" wheels, median {self.median_ms:.1f} ms, 99th percentile {self.p99_ms:.1f} ms,"
            f" maximum {self.max_ms:.1f} ms after the frame that reported it."
        )


def measure_reflexes(bumps: int = BUMPS) -> ReflexLatency:
    """Drive ahead until the bumper has been pressed `bumps` times.

    Raises:
        DeviceError: the simulated base does not answer.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve_base, args=(theirs, bumps), daemon=True)
    process.start()
    theirs.close()
    # Through PyDLL the interpreter's lock is held, as by a library that does not give it up.
    hold = ctypes.PyDLL(None).usleep
    try:
        path: str = ours.recv()
        config, clock = RoombaConfig(), WallClock()
        with Roomba(ProcessLink(SerialAddress(path).open, config), clock, config) as base:
            while not ours.poll():
                base.drive(Twist(0.2, 0.0))
                hold(round(1e6 * _HELD))
                time.sleep(_FREE)
            delays = np.array(ours.recv(), np.float64)
    finally:
        ours.close()
        process.join(5.0)
        process.kill()
    stopped = 1000 * delays[np.isfinite(delays)]
    if not len(stopped):
        return ReflexLatency(bumps, 0, np.inf, np.inf, np.inf, 1000 * _HELD)
    return ReflexLatency(
        bumps,
        len(stopped),
        round(float(np.median(stopped)), 2),
        round(float(np.percentile(stopped, 99)), 2),
        round(float(stopped.max()), 2),
        1000 * _HELD,
    )


class _Bumper(FreeFloor):
    """A body with a bumper that the benchmark presses."""

    def __init__(self) -> None:
        super().__init__()
        self.pressed = False
        self.speeds = (0.0, 0.0)

    def set_wheel_speeds(self, left: float, right: float) -> None:
        super().set_wheel_speeds(left, right)
        self.speeds = left, right

    @property
    def contacts(self) -> Contacts:
        return Contacts(self.pressed, self.pressed)


def _serve_base(connection: Connection, bumps: int) -> None:
    """Simulate the base on the wall clock and press its bumper at random times as it rolls."""
    body, rng = _Bumper(), np.random.default_rng(0)
    delays: list[float] = []
    with SimulatedRoomba(body) as roomba:
        connection.send(roomba.path)
        end = time.monotonic() + _LONGEST + 2.0 * bumps
        while len(delays) < bumps and time.monotonic() < end:
            _simulate(roomba, rng.uniform(0.3, 0.8))
            if sum(body.speeds) <= 0.0:
                continue
            body.pressed = True
            roomba.publish()
            reported = time.monotonic()
            while sum(body.speeds) > 0.0 and time.monotonic() - reported < _PATIENCE:
                roomba.advance(0.0)
            after = time.monotonic() - reported
            delays.append(after if sum(body.speeds) <= 0.0 else float("inf"))
            _simulate(roomba, 0.1)
            body.pressed = False
        connection.send(delays)
        while not connection.poll():  # until the driver has closed the port
            _simulate(roomba, 0.1)


def _simulate(roomba: SimulatedRoomba, seconds: float) -> None:
    end = time.monotonic() + seconds
    before = time.monotonic()
    while before < end:
        time.sleep(PERIOD)
        now = time.monotonic()
        roomba.advance(now - before)
        roomba.publish()
        before = now


@dataclass(frozen=True, slots=True)
class HungPairs:
    """Time from the last sign of life of watchdog and reflexes to the wheels at rest.

    Attributes:
        hangs: How often both were stopped by a signal while the wheels turned.
        stopped: How often the wheels came to rest.
        median_ms: Median time of those.
        max_ms: Longest time.
    """

    hangs: int
    stopped: int
    median_ms: float
    max_ms: float

    def summary(self) -> str:
        """The result as a paragraph."""
        return (
            f"Watchdog and reflexes both hang, on the wall clock: the program stopped the wheels"
            f" {self.stopped} of {self.hangs} times, median {self.median_ms:.0f} ms, maximum"
            f" {self.max_ms:.0f} ms after their last sign of life; 600 are allowed."
        )


class _TimedFloor(FreeFloor):
    """A floor that knows since when the wheels rest [s]; None while they turn."""

    def __init__(self) -> None:
        super().__init__()
        self.rest_since: float | None = time.monotonic()

    def set_wheel_speeds(self, left: float, right: float) -> None:
        super().set_wheel_speeds(left, right)
        if left != 0.0 or right != 0.0:
            self.rest_since = None
        elif self.rest_since is None:
            self.rest_since = time.monotonic()


def measure_hung_pairs(hangs: int = HANGS) -> HungPairs:
    """Stop both processes by a signal, again and again, each time with a new link.

    Raises:
        DeviceError: the simulated base does not answer.
    """
    after = [delay for delay in (_hang() for _ in range(hangs)) if delay is not None]
    if not after:
        return HungPairs(hangs, 0, float("inf"), float("inf"))
    longest = round(1000 * max(after), 1)
    return HungPairs(hangs, len(after), round(1000 * median(after), 1), longest)


def _hang() -> float | None:
    """Time from a hang to the wheels at rest [s]; None where they turn on."""
    floor, config, clock = _TimedFloor(), RoombaConfig(silence_timeout=0.5), WallClock()
    with on_wall_clock(SimulatedRoomba(floor)) as stub:
        link = ProcessLink(SerialAddress(stub.path).open, config)
        with Roomba(link, clock, config) as base:
            end = time.monotonic() + _LONGEST
            while floor.rest_since is not None and time.monotonic() < end:
                base.drive(Twist(0.2, 0.0))
                time.sleep(_PERIOD)
            os.killpg(link.pid, signal.SIGSTOP)
            hung = time.monotonic()
            while floor.rest_since is None and time.monotonic() - hung < _HANG_PATIENCE:
                base.drive(Twist(0.2, 0.0))
                time.sleep(_PERIOD)
            return None if floor.rest_since is None else floor.rest_since - hung
