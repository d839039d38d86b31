"""A camera that freezes, vanishes, goes blind and lies about the time; real ones may be wrapped."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sim_stubs.faults import FaultSchedule
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.interfaces import Camera, Clock
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

_SLICE = 0.015
"""It is looked so often whether frames come again [s]."""
_JUMP = 100.0
_HOLES = 0.6
_HOLE_SIZE = 16
"""Edge of the blocks that holes are made of [px]."""


class FaultyCamera:
    """A `Camera` with faults; as the driver gives them, so unpaired images are frames that miss."""

    def __init__(self, camera: Camera, clock: Clock, schedule: FaultSchedule, seed: int) -> None:
        """Wrap an open camera; closed with this one."""
        self._camera = camera
        self._clock = clock
        self._schedule = schedule
        self._rng = np.random.default_rng((seed, 8))

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
        end = self._clock.now() + timeout - 1e-9
        while (what := self._gone()) is not None:
            if self._clock.now() >= end:
                raise DeviceTimeoutError(f"the camera {what}; check its cable")
            self._clock.sleep(_SLICE)
        frame = self._camera.read(timeout)
        missed: list[ImuSamples] = []
        while frame is not None and self._misses(len(missed)):
            missed.append(frame.imu)
            frame = self._camera.read(timeout)
        if frame is None:
            return None
        return self._spoilt(replace(frame, imu=_joined([*missed, frame.imu])))

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

    def _misses(self, missed: int) -> bool:
        """Whether a frame never comes, after so many that did not."""
        if missed == 0 and self._schedule.active("half-rate"):
            return True
        return self._schedule.active("unpaired-frames") and bool(self._rng.random() < 0.5)

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
        if schedule.active("stamps-jump"):
            imu = replace(
                frame.imu,
                gyro_stamps=frame.imu.gyro_stamps + _JUMP,
                accel_stamps=frame.imu.accel_stamps + _JUMP,
            )
            frame = replace(frame, stamp=frame.stamp + _JUMP, imu=imu)
        return frame

    def _with_holes(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        rows, cols = depth.shape
        blocks = self._rng.random((-(-rows // _HOLE_SIZE), -(-cols // _HOLE_SIZE))) >= _HOLES
        kept = np.kron(blocks, np.ones((_HOLE_SIZE, _HOLE_SIZE), np.bool_))
        return np.where(kept[:rows, :cols], depth, np.float32(0.0))


def _joined(parts: list[ImuSamples]) -> ImuSamples:
    """All samples, in order."""
    return ImuSamples(
        np.concatenate([part.gyro_stamps for part in parts]),
        np.concatenate([part.gyro for part in parts]),
        np.concatenate([part.accel_stamps for part in parts]),
        np.concatenate([part.accel for part in parts]),
    )
