"""How long the camera SDK keeps other threads from running: whether it needs its own process.

A thread asks for a turn every millisecond while the driver opens a software D435i and reads it at
30 frames a second; by how much its turns are late tells how long the interpreter's lock was held.
The same with no camera is what this machine does anyway. Beside it stands what another process
would cost: a frame copied into shared memory and out of it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.shared_memory import SharedMemory

import numpy as np
from numpy.typing import NDArray

from drivers.realsense.camera import RealSense
from drivers.realsense.config import RealSenseConfig
from sim_stubs.realsense.software_device import SoftwareD435i
from vizbot.core.clock import WallClock
from vizbot.core.types import RGBDFrame

_TURN = 0.001
_RATE = 30.0
_COPIES = 100


@dataclass(frozen=True, slots=True)
class LateTurns:
    """By how much a thread that wants to run every millisecond is late.

    Attributes:
        median_ms: Of its turns.
        p99_ms: 99th percentile.
        max_ms: The latest.
    """

    median_ms: float
    p99_ms: float
    max_ms: float

    def told(self) -> str:
        """In a few words."""
        return f"{self.median_ms:.2f} / {self.p99_ms:.1f} / {self.max_ms:.1f} ms"


@dataclass(frozen=True, slots=True)
class CameraLock:
    """What the camera does to other threads.

    Attributes:
        without: With no camera.
        opening: While the driver opens it.
        reading: While it is read.
        frames: So many were read then.
        copy_ms: A frame into shared memory and out of it, median.
    """

    without: LateTurns
    opening: LateTurns
    reading: LateTurns
    frames: int
    copy_ms: float

    def told(self) -> str:
        """In one paragraph."""
        return (
            "The camera SDK and the interpreter's lock: a thread that wants to run every"
            f" millisecond is late by (median / 99th percentile / maximum) {self.without.told()}"
            f" without a camera, {self.opening.told()} while it is opened, {self.reading.told()}"
            f" while {self.frames} frames are read. In a process of its own each frame would cost"
            f" {self.copy_ms:.1f} ms of copying."
        )


def measure_camera_lock(seconds: float = 5.0) -> CameraLock:
    """Open a software camera and read it for so long [s].

    Raises:
        DeviceError: the SDK does not stream.
    """
    with _late_turns() as without:
        time.sleep(seconds)
    device = SoftwareD435i()
    context = device.plug_in()
    with _streaming(device):
        with _late_turns() as opening:
            camera = RealSense(RealSenseConfig(imu=False), WallClock(), context)
        with camera:
            newest, frames = camera.read(), 0
            end = time.monotonic() + seconds
            with _late_turns() as reading:
                while time.monotonic() < end and (frame := camera.read()) is not None:
                    newest, frames = frame, frames + 1
    assert newest is not None
    return CameraLock(
        _summary(without), _summary(opening), _summary(reading), frames, _copying(newest)
    )


@contextmanager
def _late_turns() -> Iterator[list[float]]:
    """How late each turn of a thread beside this one is [s]."""
    late: list[float] = []
    over = threading.Event()

    def run() -> None:
        while not over.is_set():
            asked = time.perf_counter()
            time.sleep(_TURN)
            late.append(time.perf_counter() - asked - _TURN)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield late
    finally:
        over.set()
        thread.join()


@contextmanager
def _streaming(device: SoftwareD435i) -> Iterator[None]:
    """Push pictures as the camera would take them."""
    over = threading.Event()
    depth = np.full((480, 640), 1500, np.uint16)
    rgb = np.full((480, 640, 3), 90, np.uint8)

    def run() -> None:
        number = 0
        while not over.wait(1.0 / _RATE):
            device.push_frame(rgb, depth, 1.7e9 + number / _RATE)
            number += 1

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _summary(late: list[float]) -> LateTurns:
    late_ms = 1000 * np.array(late)
    return LateTurns(*(round(float(np.percentile(late_ms, q)), 3) for q in (50, 99, 100)))


def _copying(frame: RGBDFrame) -> float:
    """Into shared memory and out of it [ms]."""
    size = frame.rgb.nbytes + frame.depth.nbytes
    shared = SharedMemory(create=True, size=size)
    try:
        taken = [_copied(frame, shared) for _ in range(_COPIES)]
    finally:
        shared.close()
        shared.unlink()
    return round(1000 * float(np.median(taken)), 2)


def _copied(frame: RGBDFrame, shared: SharedMemory) -> float:
    began = time.perf_counter()
    at = 0
    for image in (frame.rgb, frame.depth):
        place: NDArray[np.generic] = np.ndarray(
            image.shape, image.dtype, buffer=shared.buf, offset=at
        )
        place[...] = image
        place.copy()
        at += image.nbytes
        del place  # else the memory cannot be closed
    return time.perf_counter() - began
