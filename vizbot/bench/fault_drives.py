"""Short drives without rendering in which something goes wrong: does the robot stop, and go on?

Driver, serial line, base and the robot's own loop are real; the room is bare, poses are those of
the wheels, and nothing is ever found, so that the robot explores until its time is over.
"""

from __future__ import annotations

import logging
import math
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import numpy as np

from drivers.roomba import Roomba
from drivers.roomba_service import LockstepLink
from drivers.serial_port import open_serial
from sim_stubs.box_room import BoxCamera
from sim_stubs.clock import SimulatedClock
from sim_stubs.faults import CATALOGUE, FaultSchedule, PlannedFault
from sim_stubs.faulty_base import FaultyRoomba
from sim_stubs.faulty_camera import FaultyCamera
from sim_stubs.faulty_encoder import FaultyEncoder
from sim_stubs.faulty_program import FaultyObserver
from sim_stubs.free_floor import FreeFloor
from vizbot.bench.bare_robot import Diary, GreyEncoder, WheelPoses, is_kept
from vizbot.bench.fault_watch import FaultStop, FaultWatch
from vizbot.config import Config
from vizbot.core.errors import VizbotError
from vizbot.core.geometry import planar
from vizbot.core.observation import Observer
from vizbot.core.types import SE3, STOP
from vizbot.pipeline import Pipeline, Task
from vizbot.rig import Devices

_SECONDS = 22.0
"""Of a drive."""
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
        stops: Of the faults for which the wheels must stop, and of those where they cannot.
        noticed_after: From the first observable effect to the first line for the user [s]; None
            where there was none.
        noticed: That line.
        moved_again: Whether the robot drove ahead after all faults were over.
        reported: Why the robot gave up; empty where it did not.
        crash: What ended the program; empty where nothing did.
        map_kept: Whether the map could be saved and loaded.
    """

    drive: FaultDrive
    stops: tuple[FaultStop, ...]
    noticed_after: float | None
    noticed: str
    moved_again: bool
    reported: str
    crash: str
    map_kept: bool


def run_drive(drive: FaultDrive) -> FaultDriveResult:
    """Drive for a while, whatever happens."""
    clock = SimulatedClock()
    config = _config()
    with ExitStack() as opened:
        body_here: list[FaultyRoomba] = []
        schedule = FaultSchedule(
            _planned(drive),
            clock.now,
            drive.seed,
            lambda: bool(body_here) and sum(body_here[0].body.asked) > 0.2,
        )
        diary = Diary(schedule, clock.now)
        opened.enter_context(_overheard(diary))
        floor = FreeFloor(T_world_base=_start(drive.seed))
        stub = opened.enter_context(FaultyRoomba(floor, schedule, drive.seed, floor.place))
        body_here.append(stub)
        clock.attach(stub)
        mount, rate = config.mount.T_base_cam, config.sim_camera.rate
        watch = FaultWatch(stub.body, schedule, clock, 1.0 / rate)
        clock.attach(watch)
        clock.slow_down(lambda: 10.0 if schedule.active("encoder-slow") else 1.0)
        link = LockstepLink(
            lambda: stub.lockstep_port(open_serial(stub.path)), clock, config.roomba
        )
        base = opened.enter_context(Roomba(link, clock, config.roomba))
        camera = FaultyCamera(BoxCamera(stub.body, clock, mount, rate), clock, schedule, drive.seed)
        devices = Devices(clock, camera, base, mount, False)
        encoder = FaultyEncoder(GreyEncoder(), schedule)
        observers: list[Observer] = [diary, FaultyObserver(Diary(schedule, clock.now), schedule)]
        pipeline = Pipeline(devices, encoder, config, observers, WheelPoses(mount))
        crash = reported = ""
        try:
            with _not_for_ever():
                reported = _explore(pipeline, devices, diary, watch)
        except VizbotError as error:
            reported = str(error)
        except Exception as error:
            crash = f"{type(error).__name__}: {error}"
        effect = min(watch.shown.values(), default=None)
        lines = sorted(diary.lines)
        first = next(((at, line) for at, line in lines if effect is None or at >= effect), None)
        return FaultDriveResult(
            drive,
            watch.stops(),
            None if first is None or effect is None else round(first[0] - effect, 3),
            "" if first is None else first[1],
            watch.moved_again,
            reported,
            crash,
            is_kept(pipeline),
        )


def _explore(pipeline: Pipeline, devices: Devices, diary: Diary, watch: FaultWatch) -> str:
    """Tick until the time is over; why the robot gave up, if it did."""
    assert devices.base is not None
    while devices.clock.now() < _SECONDS:
        step = pipeline.tick(Task.EXPLORE)
        if diary.killed:
            watch.program_ends()
            devices.clock.sleep(1.0)
            return "killed"
        if step is not None and step.ended is not None:
            devices.base.drive(STOP)
            devices.clock.sleep(0.5)
            return step.ended[1]
    return ""


def _start(seed: int) -> SE3:
    """Anywhere in the middle of the room."""
    x, y, share = np.random.default_rng((seed, 4)).uniform(-1.0, 1.0, 3)
    return planar(4.0 * x, 4.0 * y, math.pi * share)


def _planned(drive: FaultDrive) -> list[PlannedFault]:
    """The faults at times drawn by the seed; firmware is what it is from the start."""
    rng = np.random.default_rng((drive.seed, 5))
    first = rng.uniform(*_BEGINS)
    starts = [first, first + rng.uniform(0.0, 2.0)]
    planned = []
    for name, start in zip(drive.faults, starts, strict=False):
        fault = CATALOGUE[name]
        begins = 0.0 if name == "mode-off-by-one" else start
        lasts = fault.seconds if math.isinf(fault.seconds) else min(fault.seconds, _LONGEST)
        planned.append(PlannedFault(fault, begins, lasts))
    return planned


def _config() -> Config:
    """The robot of the README, that a person allows to obey again, and that sets out at once."""
    return Config.model_validate(
        {"roomba": {"resume_safe": True}, "objectnav": {"look_around": False}}
    )


@contextmanager
def _overheard(diary: Diary) -> Iterator[None]:
    """Write down the warnings as well."""

    class Listener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            diary.lines.append((diary.now(), record.getMessage()))

    listener, root = Listener(logging.WARNING), logging.getLogger()
    root.addHandler(listener)
    try:
        yield
    finally:
        root.removeHandler(listener)


@contextmanager
def _not_for_ever() -> Iterator[None]:
    """Raise where the program hangs."""

    def end(*_: object) -> None:
        raise TimeoutError(f"the drive hangs: not over after {_HUNG} s")

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(_HUNG)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
