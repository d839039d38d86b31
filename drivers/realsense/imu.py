"""Gyroscope and accelerometer of a RealSense camera at their full rate.

A pipeline gives the newest sample of each frameset only, so the motion sensor is opened beside the
pipeline with a callback, which gets every sample. While a recording is played as fast as it is
read, the SDK's reader waits for that callback, so a frame always comes with the same samples.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.realsense.sdk import rs
from vizbot.core.types import ImuSamples

log = logging.getLogger(__name__)

_BACKLOG = 20_000
_JUMP = 1.0
"""Lead over the frames from which a sample has a wrong stamp [s]."""
_NO_ROTATION = 1e-3
"""Error of a rotation matrix that is none."""
_SILENT = 1.0
"""Time without samples, while images come, after which a warning is logged [s]."""


class RealSenseImu:
    """Both motion streams of a device, from the constructor to `close()`.

    Args:
        device: The device of a running pipeline (`rs.device`).
        color: Profile of its colour stream, whose axes are `cam`.
        gyro_rate: Wanted samples per second; the nearest rate of the device is taken.
        accel_rate: As `gyro_rate`.

    A device without motion streams gives no samples.
    """

    def __init__(self, device: Any, color: Any, gyro_rate: int, accel_rate: int) -> None:
        gyro, accel = _MotionSamples("gyroscope"), _MotionSamples("accelerometer")
        self._streams = gyro, accel
        buffers = {rs.stream.gyro: gyro, rs.stream.accel: accel}
        rates = {rs.stream.gyro: gyro_rate, rs.stream.accel: accel_rate}
        with ExitStack() as opened:
            for sensor in device.query_sensors():
                profiles = _nearest_profiles(sensor, rates)
                if not profiles:
                    continue
                for profile in profiles:
                    buffers[profile.stream_type()].R_cam_imu = _rotation_between(profile, color)
                sensor.open(profiles)
                opened.callback(sensor.close)
                sensor.start(lambda frame: buffers[frame.get_profile().stream_type()].add(frame))
                opened.callback(sensor.stop)
            self._opened = opened.pop_all()

    def take(self, until: float, since: float = -math.inf, offset: float = 0.0) -> ImuSamples:
        """Return the samples in `cam` received so far with stamps up to `until`, each once.

        Args:
            until: Stamp of the youngest sample, `offset` included [s].
            since: Samples that are not younger are dropped; `offset` included [s].
            offset: Added to the device's stamps [s].
        """
        taken = [stream.take(until - offset, since - offset) for stream in self._streams]
        (gyro_stamps, gyro), (accel_stamps, accel) = taken
        return ImuSamples(gyro_stamps + offset, gyro, accel_stamps + offset, accel)

    def forget(self) -> None:
        """Drop the samples received so far."""
        for stream in self._streams:
            stream.forget()

    def close(self) -> None:
        """Stop both streams; twice is fine."""
        self._opened.close()


class _MotionSamples:
    """Samples of one stream, between the SDK's thread, which adds, and the reader, which takes."""

    def __init__(self, name: str) -> None:
        self.R_cam_imu = np.eye(3)
        self._name = name
        self._was_heard = False
        self._missed_since: float | None = None
        self._warned = False
        self._samples: deque[tuple[float, float, float, float]] = deque(maxlen=_BACKLOG)

    def add(self, frame: Any) -> None:
        value = frame.as_motion_frame().get_motion_data()
        sample = frame.get_timestamp() / 1000.0, value.x, value.y, value.z
        if all(map(math.isfinite, sample)):  # a damaged recording has others
            self._samples.append(sample)

    def forget(self) -> None:
        self._samples.clear()
        self._missed_since = None  # on another clock

    def take(self, until: float, since: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        taken = []
        while self._samples and not until < self._samples[0][0] <= until + _JUMP:
            sample = self._samples.popleft()
            if since < sample[0] <= until:
                taken.append(sample)
        self._note(until, bool(taken))
        samples = np.array(taken, np.float64).reshape(-1, 4)
        return samples[:, 0], samples[:, 1:] @ self.R_cam_imu.T

    def _note(self, until: float, heard: bool) -> None:
        """Log when a sensor falls silent, and when it is heard again."""
        since, self._was_heard = self._missed_since, self._was_heard or heard
        silence = 0.0 if since is None else until - since
        if heard:
            if self._warned:
                log.warning("the camera's %s is heard again after %.1f s", self._name, silence)
            self._missed_since, self._warned = None, False
        elif self._was_heard and since is None:
            self._missed_since = until
        elif silence > _SILENT and not self._warned:
            self._warned = True
            log.warning(
                "the camera's %s has been silent for %.1f s while images go on: poses are less "
                "sure; unplug the camera and plug it in again",
                self._name,
                silence,
            )


def _nearest_profiles(sensor: Any, rates: dict[Any, int]) -> list[Any]:
    """For each stream in `rates` that the sensor has, its profile nearest to that rate [Hz]."""
    profiles = [p for p in sensor.get_stream_profiles() if p.stream_type() in rates]
    nearest: dict[Any, Any] = {}
    for profile in sorted(profiles, key=lambda p: abs(p.fps() - rates[p.stream_type()])):
        nearest.setdefault(profile.stream_type(), profile)
    return list(nearest.values())


def _rotation_between(motion: Any, color: Any) -> NDArray[np.float64]:
    """R_cam_imu (3, 3); the identity where the recording has no extrinsics of its IMU."""
    try:
        rotation = motion.get_extrinsics_to(color).rotation
    except RuntimeError:
        log.info("no extrinsics from %s to colour: its axes are taken as the camera's", motion)
        return np.eye(3)
    # The SDK stores rotations column by column.
    R_cam_imu = np.array(rotation, np.float64).reshape(3, 3).T
    if not np.allclose(R_cam_imu @ R_cam_imu.T, np.eye(3), atol=_NO_ROTATION):
        log.warning("the extrinsics from %s to colour are no rotation: they are ignored", motion)
        return np.eye(3)
    return R_cam_imu
