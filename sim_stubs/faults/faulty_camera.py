"""A camera with faults: it freezes, vanishes, loses depth and falsifies stamps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivers.realsense.timestamps import Accepted, FrameStamps
from sim_stubs.faults.catalogue import FaultSchedule
from vizbot.core.closeable import Closeable
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.interfaces import Camera, Clock
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

_SLICE = 0.015
"""Interval of checks whether frames come again [s]."""
_JUMP = 100.0
_PERIOD = 1 / 30
"""Frame interval of a real camera [s]."""
_SINGLE = 0.5
"""Share of the colour images that come without their depth."""
_HOLES = 0.6
_HOLE_SIZE = 16
"""Edge of the blocks that holes are made of [px]."""


class FaultyCamera(Closeable):
    """A `Camera` with faults around another one, simulated or real.

    Stamps are checked as in the driver of the real camera.
    """

    def __init__(
        self,
        camera: Camera,
        clock: Clock,
        schedule: FaultSchedule,
        seed: int,
        *,
        recorded: bool = False,
    ) -> None:
        """Wrap an open camera.

        Args:
            camera: The camera, which is closed with this one.
            clock: Clock of the run.
            schedule: Schedule of the faults.
            seed: Seed of all draws.
            recorded: Whether the camera is a recording, which has no time of its own.
        """
        self._camera = camera
        self._clock = clock
        self._schedule = schedule
        self._recorded = recorded
        self._rng = np.random.default_rng((seed, 8))
        self._stamps = FrameStamps("the camera")
        self._first: float | None = None
        self._elapsed = 0.0

    @property
    def intrinsics(self) -> Intrinsics:
        """Do as the camera."""
        return self._camera.intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """The next frame with the active faults.

        Raises:
            DeviceTimeoutError: no frame came within `timeout` [s].
            DeviceError: the camera is unplugged or closed.
        """
        end, gone = self._clock.now() + timeout - 1e-9, False
        while not self._recorded and (what := self._gone()) is not None:
            gone = True
            if self._clock.now() >= end:
                raise DeviceTimeoutError(f"the camera {what}; check its cable")
            self._clock.sleep(_SLICE)
        if gone:
            self._next(timeout)  # with it the inertial samples of the gap are lost
        missed: list[ImuSamples] = []
        while (frame := self._next(timeout)) is not None:
            if self._recorded and self._gone() is not None:
                missed.clear()
                continue
            taken = None
            if not (self._schedule.active("half-rate") and not missed):
                taken = self._accepted(frame)
            if taken is not None:
                return self._spoilt(self._stamped(frame, missed, taken))
            missed.append(frame.imu)
        return None

    @property
    def elapsed(self) -> float:
        """Time from the first frame to the newest [s], the time of a recording."""
        return self._elapsed

    def _next(self, timeout: float) -> RGBDFrame | None:
        frame = self._camera.read(timeout)
        if frame is not None:
            self._first = frame.stamp if self._first is None else self._first
            self._elapsed = frame.stamp - self._first
        return frame

    def _accepted(self, frame: RGBDFrame) -> Accepted | None:
        """The driver's verdict on the stamps of the two images."""
        stamp = frame.stamp + self._ahead
        late = self._schedule.active("unpaired-frames") and self._rng.random() < _SINGLE
        now = None if self._recorded else self._clock.now()
        return self._stamps.judge(stamp, stamp - late * _PERIOD, _PERIOD, now)

    def _stamped(self, frame: RGBDFrame, missed: list[ImuSamples], accepted: Accepted) -> RGBDFrame:
        """The frame with its stamp and all inertial samples since the last frame."""
        later = accepted.stamp - frame.stamp
        parts = [] if accepted.jumped else [*missed, frame.imu]
        imu = ImuSamples(
            np.concatenate([np.zeros(0), *(part.gyro_stamps + later for part in parts)]),
            np.concatenate([np.zeros((0, 3)), *(part.gyro for part in parts)]),
            np.concatenate([np.zeros(0), *(part.accel_stamps + later for part in parts)]),
            np.concatenate([np.zeros((0, 3)), *(part.accel for part in parts)]),
        )
        return replace(frame, stamp=accepted.stamp, imu=imu)

    @property
    def _ahead(self) -> float:
        return _JUMP if self._schedule.active("stamps-jump") else 0.0

    def close(self) -> None:
        """Do as the camera."""
        self._camera.close()

    def _gone(self) -> str | None:
        if self._schedule.active("camera-vanishes"):
            return "is unplugged"
        return "sends no frames" if self._schedule.active("camera-frozen") else None

    def _spoilt(self, frame: RGBDFrame) -> RGBDFrame:
        schedule = self._schedule
        if schedule.active("imu-gap"):
            frame = replace(frame, imu=ImuSamples.none())
        if schedule.active("overexposed"):
            frame = replace(frame, rgb=np.full_like(frame.rgb, 255))
        if schedule.active("black-depth"):
            frame = replace(frame, depth=np.zeros_like(frame.depth))
        if schedule.active("depth-holes"):
            frame = replace(frame, depth=self._with_holes(frame.depth))
        return frame

    def _with_holes(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        rows, cols = depth.shape
        blocks = self._rng.random((-(-rows // _HOLE_SIZE), -(-cols // _HOLE_SIZE))) >= _HOLES
        kept = np.kron(blocks, np.ones((_HOLE_SIZE, _HOLE_SIZE), np.bool_))
        return np.where(kept[:rows, :cols], depth, np.float32(0.0))
