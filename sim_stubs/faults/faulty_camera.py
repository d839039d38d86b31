"""A camera that freezes, vanishes, goes blind and lies about the time; real ones may be wrapped."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivers.realsense.timestamps import Accepted, FrameStamps
from sim_stubs.faults.catalogue import FaultSchedule
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.interfaces import Camera, Clock
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

_SLICE = 0.015
"""It is looked so often whether frames come again [s]."""
_JUMP = 100.0
_PERIOD = 1 / 30
"""Between the frames of a real camera [s]."""
_SINGLE = 0.5
"""Of the colour images come without their depth."""
_HOLES = 0.6
_HOLE_SIZE = 16
"""Edge of the blocks that holes are made of [px]."""


class FaultyCamera:
    """A `Camera` with faults, whose stamps are judged as the driver of the real one does it."""

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
            camera: Closed with this one.
            clock: Of the run.
            schedule: What is wrong.
            seed: Of what is drawn.
            recorded: Whether it is a recording, which comes at no time of its own.
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
        """As the camera."""
        return self._camera.intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """The next frame, or what is left of it.

        Raises:
            DeviceTimeoutError: none came within `timeout` [s].
            DeviceError: the camera is gone or closed.
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
        """From the first frame to the newest [s]: the time of a recording."""
        return self._elapsed

    def _next(self, timeout: float) -> RGBDFrame | None:
        frame = self._camera.read(timeout)
        if frame is not None:
            self._first = frame.stamp if self._first is None else self._first
            self._elapsed = frame.stamp - self._first
        return frame

    def _accepted(self, frame: RGBDFrame) -> Accepted | None:
        """What the driver makes of the stamps of its two images."""
        stamp = frame.stamp + self._ahead
        late = self._schedule.active("unpaired-frames") and self._rng.random() < _SINGLE
        now = None if self._recorded else self._clock.now()
        return self._stamps.judge(stamp, stamp - late * _PERIOD, _PERIOD, now)

    def _stamped(self, frame: RGBDFrame, missed: list[ImuSamples], accepted: Accepted) -> RGBDFrame:
        """The frame with the stamp that it gets, and all inertial samples since the one before."""
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
        """As the camera."""
        self._camera.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

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
