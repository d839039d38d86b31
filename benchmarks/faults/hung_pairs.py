"""How soon the wheels rest on the wall clock once watchdog and reflexes both hang.

The program alone is left to notice. It has the product's settings, and drives straight ahead.
"""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from statistics import median

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.process_link import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.roomba.wall_clock import on_wall_clock
from sim_stubs.world.free_floor import FreeFloor
from vizbot.core.clock import WallClock
from vizbot.core.types import Twist

HANGS = 5
_PATIENCE = 5.0
"""Time after which the wheels count as not stopped [s]."""
_LONGEST = 30.0
"""Longest time until the base drives [s]."""
_PERIOD = 0.01


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
    floor, config, clock = _TimedFloor(), RoombaConfig(), WallClock()
    with on_wall_clock(SimulatedRoomba(floor)) as stub:
        link = ProcessLink(SerialAddress(stub.path).open, config)
        with Roomba(link, clock, config) as base:
            end = time.monotonic() + _LONGEST
            while floor.rest_since is not None and time.monotonic() < end:
                base.drive(Twist(0.2, 0.0))
                time.sleep(_PERIOD)
            os.killpg(link.pid, signal.SIGSTOP)
            hung = time.monotonic()
            while floor.rest_since is None and time.monotonic() - hung < _PATIENCE:
                base.drive(Twist(0.2, 0.0))
                time.sleep(_PERIOD)
            return None if floor.rest_since is None else floor.rest_since - hung
