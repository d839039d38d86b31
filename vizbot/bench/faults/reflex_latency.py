"""How soon the reflexes stop the wheels on the wall clock while the program holds the interpreter.

Three processes, as on the robot: this one, which drives and holds its interpreter's lock for long
stretches, as GTSAM and the camera SDK do; the one that owns the port; and the base, simulated in a
process of its own, which presses its bumper and waits for the wheels to be told to rest.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection

import numpy as np

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.process import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from drivers.roomba.stream import PERIOD
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.body import Contacts
from sim_stubs.world.free_floor import FreeFloor
from vizbot.core.clock import WallClock
from vizbot.core.types import SE3, Twist

BUMPS = 200
_HELD = 0.2
"""The lock is held so long at a time [s]; commands that are older than 0.3 s are void."""
_FREE = 0.002
_LONGEST = 30.0
"""The base must obey after so long [s]."""
_PATIENCE = 1.0
"""A base that is not stopped in this time is not stopped [s]."""


@dataclass(frozen=True, slots=True)
class ReflexLatency:
    """From the sensor frame with the bump to the wheels told to rest.

    Attributes:
        bumps: How many.
        stopped: After how many the wheels were told to rest at all.
        median_ms: Of those.
        p99_ms: 99th percentile.
        max_ms: The slowest.
        held_ms: How long the program held its lock at a time.
    """

    bumps: int
    stopped: int
    median_ms: float
    p99_ms: float
    max_ms: float
    held_ms: float

    def told(self) -> str:
        """In one paragraph."""
        return (
            f"Reflexes on the wall clock, while the program holds its interpreter's lock for"
            f" {self.held_ms:.0f} ms at a time: {self.stopped} of {self.bumps} bumps stopped the"
            f" wheels, median {self.median_ms:.1f} ms, 99th percentile {self.p99_ms:.1f} ms,"
            f" maximum {self.max_ms:.1f} ms after the frame that told of it."
        )


def measure_reflexes(bumps: int = BUMPS) -> ReflexLatency:
    """Drive ahead into so many bumps.

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


class _Bumper:
    """A body whose bumper somebody presses."""

    def __init__(self) -> None:
        self._floor = FreeFloor()
        self.pressed = False
        self.speeds = (0.0, 0.0)

    def set_wheel_speeds(self, left: float, right: float) -> None:
        self.speeds = left, right
        self._floor.set_wheel_speeds(left, right)

    def advance(self, seconds: float) -> None:
        self._floor.advance(seconds)

    @property
    def wheel_travel(self) -> tuple[float, float]:
        return self._floor.wheel_travel

    @property
    def contacts(self) -> Contacts:
        return Contacts(self.pressed, self.pressed)

    @property
    def T_world_base(self) -> SE3:
        return self._floor.T_world_base


def _serve_base(connection: Connection, bumps: int) -> None:
    """Live on the wall clock; press the bumper at random times while the base rolls ahead."""
    body, rng = _Bumper(), np.random.default_rng(0)
    delays: list[float] = []
    with SimulatedRoomba(body) as roomba:
        connection.send(roomba.path)
        end = time.monotonic() + _LONGEST + 2.0 * bumps
        while len(delays) < bumps and time.monotonic() < end:
            _live(roomba, body, rng.uniform(0.3, 0.8))
            if sum(body.speeds) <= 0.0:
                continue
            body.pressed = True
            roomba.publish()
            told = time.monotonic()
            while sum(body.speeds) > 0.0 and time.monotonic() - told < _PATIENCE:
                roomba.advance(0.0)
            after = time.monotonic() - told
            delays.append(after if sum(body.speeds) <= 0.0 else float("inf"))
            _live(roomba, body, 0.1)
            body.pressed = False
        connection.send(delays)
        while not connection.poll():  # until the driver has let go of the port
            _live(roomba, body, 0.1)


def _live(roomba: SimulatedRoomba, body: _Bumper, seconds: float) -> None:
    end = time.monotonic() + seconds
    before = time.monotonic()
    while before < end:
        time.sleep(PERIOD)
        now = time.monotonic()
        roomba.advance(now - before)
        roomba.publish()
        before = now
