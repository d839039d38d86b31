"""How long the camera SDK keeps other threads from running, and whether it needs its own process.

A thread wants to run every millisecond while the driver opens a software D435i and reads it at
30 frames a second. The delay of its turns shows how long the interpreter's lock was held. The same
measurement without a camera shows the delays of the machine itself, and a frame copied into shared
memory and out of it shows the cost of another process.
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
    """Delays of a thread that wants to run every millisecond.

    Attributes:
        median_ms: Median delay.
        p99_ms: 99th percentile.
        max_ms: Longest delay.
    """

    median_ms: float
    p99_ms: float
    max_ms: float

    def text(self) -> str:
        """Median, 99th percentile and maximum."""
        return f"{self.median_ms:.2f} / {self.p99_ms:.1f} / {self.max_ms:.1f} ms"


@dataclass(frozen=True, slots=True)
class CameraLock:
    """Delays that the camera causes in other threads.

    Attributes:
        without: Delays without a camera.
        opening: Delays while the driver opens the camera.
        reading: Delays while frames are read.
        frames: Number of frames that were read.
        copy_ms: Median time to copy a frame into shared memory and out of it.
    """

    without: LateTurns
    opening: LateTurns
    reading: LateTurns
    frames: int
    copy_ms: float

    def summary(self) -> str:
        """The result as a paragraph."""
        return (
            "The camera SDK and the interpreter's lock: a thread that wants to run every"
            f" millisecond is late by (median / 99th percentile / maximum) {self.without.text()}"
            f" without a camera, {self.opening.text()} while it is opened, {self.reading.text()}"
            f" while {self.frames} frames are read. In a process of its own each frame would cost"
            f" {self.copy_ms:.1f} ms of copying."
        )


def measure_camera_lock(seconds: float = 5.0) -> CameraLock:
    """Open a software camera and read it for `seconds`.

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
        _percentiles(without),
        _percentiles(opening),
        _percentiles(reading),
        frames,
        _copy_ms(newest),
    )


@contextmanager
def _late_turns() -> Iterator[list[float]]:
    """Collect the delays of the turns of another thread [s]."""
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
    """Push frames at the rate of the camera."""
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


def _percentiles(late: list[float]) -> LateTurns:
    late_ms = 1000 * np.array(late)
    return LateTurns(*(round(float(np.percentile(late_ms, q)), 3) for q in (50, 99, 100)))


def _copy_ms(frame: RGBDFrame) -> float:
    """Median time to copy a frame into shared memory and out of it [ms]."""
    size = frame.rgb.nbytes + frame.depth.nbytes
    shared = SharedMemory(create=True, size=size)
    try:
        taken = [_copy_seconds(frame, shared) for _ in range(_COPIES)]
    finally:
        shared.close()
        shared.unlink()
    return round(1000 * float(np.median(taken)), 2)


def _copy_seconds(frame: RGBDFrame, shared: SharedMemory) -> float:
    began = time.perf_counter()
    offset = 0
    for image in (frame.rgb, frame.depth):
        place: NDArray[np.generic] = np.ndarray(
            image.shape, image.dtype, buffer=shared.buf, offset=offset
        )
        place[...] = image
        place.copy()
        offset += image.nbytes
        del place  # else the memory cannot be closed
    return time.perf_counter() - began
