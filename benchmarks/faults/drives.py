"""Short drives with faults and without rendering: does the robot stop, and does it drive on?

Driver, serial line, base and the robot's own loop are the real ones. The room is bare, poses are
those of the wheels, and nothing is ever found, so that the robot explores until its time is over.
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import numpy as np

from benchmarks.faults.minimal_robot import GreyEncoder, LogObserver, WheelPoses, map_survives
from benchmarks.faults.monitor import FaultMonitor, FaultStop
from benchmarks.faults.run import limit_wall_time, plan_faults, run_to_end
from drivers.roomba.base import Roomba
from drivers.roomba.serial_port import open_serial
from drivers.roomba.service import LockstepLink
from sim_stubs.faults.catalogue import CATALOGUE, FaultSchedule
from sim_stubs.faults.faulty_base import FaultyRoomba
from sim_stubs.faults.faulty_camera import FaultyCamera
from sim_stubs.faults.faulty_program import FaultyEncoder, FaultyObserver
from sim_stubs.world.body import FreeFloor
from sim_stubs.world.box_room import BoxCamera
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.interfaces import Devices
from vizbot.core.observer import Observer
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import SE3
from vizbot.objectnav.tasks import Task
from vizbot.perception.interfaces import PerceptionParts
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.config import RehearsalConfig

_RATE = 10.0
"""Rate of the camera [1/s], low so that its faults do not look like those of a slow program."""
_ENOUGH, _SECONDS = 12.0, 40.0
"""Earliest end of a drive, once the robot has driven on, and latest end [s]."""
_BEGINS = (5.0, 11.0)
"""Earliest and latest time at which the first fault is due [s]."""
_LONGEST = 5.0
"""Longest duration of a fault that passes [s]."""
_HUNG = 120
"""Wall time after which a drive counts as hung [s]."""


@dataclass(frozen=True, slots=True)
class FaultDrive:
    """A drive with faults.

    Attributes:
        faults: Names of the faults; two of them begin at most 2 s apart.
        seed: Seed of their times and of all noise.
        by_default: Whether the base has the product's settings, by which an edge or a lift may end
            the search; else it resumes Safe mode by itself, and every second one is in Full mode.
    """

    faults: tuple[str, ...]
    seed: int
    by_default: bool = False


@dataclass(frozen=True, slots=True)
class FaultDriveResult:
    """How a drive ended.

    Attributes:
        drive: The drive.
        stops: How the wheels stopped for the faults that demand it.
        noticed_after: Time from the first observable effect of a fault to the first line about it
            for the user [s]; None where there was none.
        noticed: That line.
        happened: Whether all faults showed.
        drove_on: Whether the robot drove ahead after that.
        astray: Farthest that a wheel turned in one go beyond its commands [m].
        reported: Why the robot gave up; empty where it did not.
        crash: The error that ended the program; empty without one.
        map_kept: Whether the map could be saved and loaded; None where that is not tried.
    """

    drive: FaultDrive
    stops: tuple[FaultStop, ...]
    noticed_after: float | None
    noticed: str
    happened: bool
    drove_on: bool
    astray: float
    reported: str
    crash: str
    map_kept: bool | None


def run_drive(drive: FaultDrive) -> FaultDriveResult:
    """Run a drive with its faults."""
    clock = SimulatedClock()
    config = _config(drive)
    rng = np.random.default_rng((drive.seed, 5))
    planned = plan_faults(drive.faults, _BEGINS, _LONGEST, rng)
    with ExitStack() as opened:
        schedule = FaultSchedule(planned, clock.now, drive.seed)
        observer = LogObserver(schedule, clock.now)
        opened.enter_context(_log_warnings_to(observer))
        floor = FreeFloor(T_world_base=_start(drive.seed))
        stub = opened.enter_context(FaultyRoomba(floor, schedule, drive.seed, floor.place))
        clock.attach(stub)
        mount, rate = config.mount.T_base_cam, RehearsalConfig.read(config).sim_camera.rate
        monitor = FaultMonitor(stub, schedule, clock, 1.0 / rate)
        clock.attach(monitor)
        clock.slow_down(schedule.slowness)
        link = LockstepLink(
            lambda: stub.lockstep_port(open_serial(stub.path)), clock, config.roomba
        )
        base = opened.enter_context(Roomba(link, clock, config.roomba))
        camera = FaultyCamera(BoxCamera(stub.body, clock, mount, rate), clock, schedule, drive.seed)
        devices = Devices(clock, camera, base, mount, False)
        encoder = FaultyEncoder(GreyEncoder(), schedule)
        observers: list[Observer] = [
            observer,
            FaultyObserver(LogObserver(schedule, clock.now), schedule),
        ]
        parts = PerceptionParts(slam=WheelPoses(mount), every_pose=True)
        pipeline = Pipeline(devices, encoder, config, observers, parts)
        with limit_wall_time(_HUNG):
            _, reported, crash = run_to_end(
                pipeline,
                devices,
                Task.EXPLORE,
                observer,
                monitor,
                lambda: clock.now() > (_ENOUGH if monitor.drove_on else _SECONDS),
            )
        after, line = _first_about(observer, monitor, schedule)
        return FaultDriveResult(
            drive,
            monitor.stops(),
            after,
            line,
            monitor.happened,
            monitor.drove_on,
            round(monitor.astray, 4),
            reported,
            crash,
            map_survives(pipeline, observer),
        )


def _first_about(
    observer: LogObserver, monitor: FaultMonitor, schedule: FaultSchedule
) -> tuple[float | None, str]:
    """The first line about a fault, and the time since the fault's first effect [s]."""
    said = []
    for name, shown in monitor.shown.items():
        fault, began = CATALOGUE[name], schedule.began(name)
        # A cable that is out shows at once, although nothing can stop the wheels until it is back.
        effect = shown if fault.reaches_wheels or began is None else began
        for stamp, line in observer.lines:
            if (
                fault.report_pattern
                and stamp >= effect - 1e-9
                and re.search(fault.report_pattern, line)
            ):
                said.append((stamp - effect, line))
    after, line = min(said, default=(None, ""))
    return None if after is None else round(after, 3), line


def _start(seed: int) -> SE3:
    """A random pose in the middle of the room."""
    x, y, share = np.random.default_rng((seed, 4)).uniform(-1.0, 1.0, 3)
    return planar(4.0 * x, 4.0 * y, math.pi * share)


def _config(drive: FaultDrive) -> Config:
    """Settings of a robot that sets out at once.

    Unless they are the product's it resumes Safe mode by itself, and every second base is in Full
    mode, in which the driver has to stop it at an edge.
    """
    unattended = {"resume_safe": True, "full_mode": drive.seed % 2 == 1}
    return Config.model_validate(
        {
            "roomba": {} if drive.by_default else unattended,
            "objectnav": {"look_around": False},
            "sim_camera": {"rate": _RATE},
        }
    )


@contextmanager
def _log_warnings_to(observer: LogObserver) -> Iterator[None]:
    """Log warnings of the program to an observer, too."""

    class LogListener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            observer.lines.append((observer.now(), record.getMessage()))

    listener, root = LogListener(logging.WARNING), logging.getLogger()
    root.addHandler(listener)
    try:
        yield
    finally:
        root.removeHandler(listener)
