"""Examination of a camera by a few seconds of its frames, for `vizbot doctor`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from drivers.realsense.sdk import rs
from vizbot.core.interfaces import Camera, Clock


@dataclass(frozen=True, slots=True)
class CameraIdentity:
    """A connected camera.

    Attributes:
        name: Model.
        serial: Number printed on it.
        firmware: Version.
        usb: Version of the connection, such as `3.2`.
    """

    name: str
    serial: str
    firmware: str
    usb: str


@dataclass(frozen=True, slots=True)
class CameraExamination:
    """Findings about a camera.

    Attributes:
        rate: Frames a second.
        holes: Share of pixels without depth.
        gyro_rate: Samples a second; 0 without a gyroscope.
        accel_rate: Samples a second; 0 without an accelerometer.
        gyro_bias: Length of the mean rate, the camera's own motion included [rad/s].
        gravity: Length of the mean acceleration [m/s^2]; 0 without an accelerometer.
    """

    rate: float
    holes: float
    gyro_rate: float
    accel_rate: float
    gyro_bias: float
    gravity: float


def cameras(context: Any = None) -> list[CameraIdentity]:
    """All connected RealSense cameras; none is opened."""
    devices = (context if context is not None else rs.context()).query_devices()
    return [
        CameraIdentity(*(_camera_info(device, kind) for kind in (
            rs.camera_info.name,
            rs.camera_info.serial_number,
            rs.camera_info.firmware_version,
            rs.camera_info.usb_type_descriptor,
        )))
        for device in list(devices)
    ]  # fmt: skip


def examine_camera(camera: Camera, clock: Clock, seconds: float = 2.0) -> CameraExamination:
    """Read frames of an open camera at rest for some seconds; the caller closes it.

    Raises:
        DeviceError: the camera gives no frames.
    """
    first = camera.read()  # a camera takes a while to start
    end, frames = clock.now() + seconds, []
    while clock.now() < end and (frame := camera.read()) is not None:
        frames.append(frame)
    if first is None or not frames:
        return CameraExamination(0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    period = max(frames[-1].stamp - first.stamp, 1e-9)
    gyro = np.concatenate([frame.imu.gyro for frame in frames])
    accel = np.concatenate([frame.imu.accel for frame in frames])
    return CameraExamination(
        rate=len(frames) / period,
        holes=float(np.mean([(frame.depth <= 0.0).mean() for frame in frames])),
        gyro_rate=len(gyro) / period,
        accel_rate=len(accel) / period,
        gyro_bias=float(np.linalg.norm(gyro.mean(axis=0))) if len(gyro) else 0.0,
        gravity=float(np.linalg.norm(accel.mean(axis=0))) if len(accel) else 0.0,
    )


def _camera_info(device: Any, kind: Any) -> str:
    return str(device.get_info(kind)) if device.supports(kind) else "unknown"
