"""Short drives without rendering in which something goes wrong: does the robot stop, and go on?

Driver, serial line, base and the robot's own loop are real; the room is bare, poses are those of
the wheels, and nothing is ever found, so that the robot explores until its time is over.
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import numpy as np

from drivers.roomba.base import Roomba
from drivers.roomba.serial_port import open_serial
from drivers.roomba.service import LockstepLink
from sim_stubs.clock import SimulatedClock
from sim_stubs.faults.catalogue import CATALOGUE, FaultSchedule
from sim_stubs.faults.faulty_base import FaultyRoomba
from sim_stubs.faults.faulty_camera import FaultyCamera
from sim_stubs.faults.faulty_encoder import FaultyEncoder
from sim_stubs.faults.faulty_program import FaultyObserver
from sim_stubs.world.box_room import BoxCamera
from sim_stubs.world.free_floor import FreeFloor
from vizbot.bench.faults.minimal_robot import GreyEncoder, LogObserver, WheelPoses, is_kept
from vizbot.bench.faults.monitor import FaultMonitor, FaultStop
from vizbot.bench.faults.run import not_for_ever, plan_faults, run_to_end
from vizbot.config import Config
from vizbot.core.devices import Devices
from vizbot.core.geometry import planar
from vizbot.core.observer import Observer
from vizbot.core.types import SE3
from vizbot.objectnav.tasks import Task
from vizbot.pipeline import Pipeline

_RATE = 10.0
"""Of the camera [1/s]: its faults must not look like those of a slow program."""
_ENOUGH, _SECONDS = 12.0, 40.0
"""A drive ends once the robot has driven on, at the earliest and at the latest [s]."""
_BEGINS = (5.0, 11.0)
"""When the first fault is due [s]."""
_LONGEST = 5.0
"""Faults that pass do so within [s]."""
_HUNG = 120
"""A drive that takes longer on this machine hangs [s]."""


@dataclass(frozen=True, slots=True)
class FaultDrive:
    """What happens in a drive.

    Attributes:
        faults: Names; two of them begin at most 2 s apart.
        seed: Of their times and all noise.
    """

    faults: tuple[str, ...]
    seed: int


@dataclass(frozen=True, slots=True)
class FaultDriveResult:
    """What became of it.

    Attributes:
        drive: What happened.
        stops: Of the faults for which the wheels must stop.
        noticed_after: From the first observable effect of a fault to the first line about it for
            the user [s]; None where there was none.
        noticed: That line.
        happened: Whether all faults showed.
        drove_on: Whether the robot drove ahead after that.
        astray: Farthest that a wheel turned in one go beyond what it had been told [m].
        reported: Why the robot gave up; empty where it did not.
        crash: What ended the program; empty where nothing did.
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
    """Drive for a while, whatever happens."""
    clock = SimulatedClock()
    config = _config(drive)
    rng = np.random.default_rng((drive.seed, 5))
    planned = plan_faults(drive.faults, _BEGINS, _LONGEST, rng)
    with ExitStack() as opened:
        schedule = FaultSchedule(planned, clock.now, drive.seed)
        diary = LogObserver(schedule, clock.now)
        opened.enter_context(_overheard(diary))
        floor = FreeFloor(T_world_base=_start(drive.seed))
        stub = opened.enter_context(FaultyRoomba(floor, schedule, drive.seed, floor.place))
        clock.attach(stub)
        mount, rate = config.mount.T_base_cam, config.sim_camera.rate
        watch = FaultMonitor(stub, schedule, clock, 1.0 / rate)
        clock.attach(watch)
        clock.slow_down(schedule.slowness)
        link = LockstepLink(
            lambda: stub.lockstep_port(open_serial(stub.path)), clock, config.roomba
        )
        base = opened.enter_context(Roomba(link, clock, config.roomba))
        camera = FaultyCamera(BoxCamera(stub.body, clock, mount, rate), clock, schedule, drive.seed)
        devices = Devices(clock, camera, base, mount, False)
        encoder = FaultyEncoder(GreyEncoder(), schedule)
        observers: list[Observer] = [
            diary,
            FaultyObserver(LogObserver(schedule, clock.now), schedule),
        ]
        pipeline = Pipeline(devices, encoder, config, observers, WheelPoses(mount))
        with not_for_ever(_HUNG):
            _, reported, crash = run_to_end(
                pipeline,
                devices,
                Task.EXPLORE,
                diary,
                watch,
                lambda: clock.now() > (_ENOUGH if watch.drove_on else _SECONDS),
            )
        after, line = _first_about(diary, watch, schedule)
        return FaultDriveResult(
            drive,
            watch.stops(),
            after,
            line,
            watch.happened,
            watch.drove_on,
            round(watch.astray, 4),
            reported,
            crash,
            is_kept(pipeline, diary),
        )


def _first_about(
    diary: LogObserver, watch: FaultMonitor, schedule: FaultSchedule
) -> tuple[float | None, str]:
    """The first line about a fault, and how long after its first effect [s] it was said."""
    said = []
    for name, shown in watch.shown.items():
        fault, began = CATALOGUE[name], schedule.began(name)
        # A cable that is out shows at once, although nothing can stop the wheels until it is back.
        effect = shown if fault.reaches_wheels or began is None else began
        for at, line in diary.lines:
            if fault.says and at >= effect - 1e-9 and re.search(fault.says, line):
                said.append((at - effect, line))
    after, line = min(said, default=(None, ""))
    return None if after is None else round(after, 3), line


def _start(seed: int) -> SE3:
    """Anywhere in the middle of the room."""
    x, y, share = np.random.default_rng((seed, 4)).uniform(-1.0, 1.0, 3)
    return planar(4.0 * x, 4.0 * y, math.pi * share)


def _config(drive: FaultDrive) -> Config:
    """The robot of the README, that a person allows to obey again, and that sets out at once.

    Every second base is in Full mode, where it leaves it to the driver to stop at an edge.
    """
    full_mode = drive.seed % 2 == 1
    return Config.model_validate(
        {
            "roomba": {"resume_safe": True, "full_mode": full_mode},
            "objectnav": {"look_around": False},
            "sim_camera": {"rate": _RATE},
        }
    )


@contextmanager
def _overheard(diary: LogObserver) -> Iterator[None]:
    """Write down the warnings as well."""

    class LogListener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            diary.lines.append((diary.now(), record.getMessage()))

    listener, root = LogListener(logging.WARNING), logging.getLogger()
    root.addHandler(listener)
    try:
        yield
    finally:
        root.removeHandler(listener)
