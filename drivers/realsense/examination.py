"""What can be learned of a camera by looking through it for a moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from drivers.realsense.sdk import rs
from vizbot.core.interfaces import Camera, Clock


@dataclass(frozen=True, slots=True)
class CameraIdentity:
    """A camera that is plugged in.

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
    """What was seen.

    Attributes:
        rate: Frames a second.
        holes: Share of pixels without depth.
        gyro_rate: Samples a second; 0 without a gyroscope.
        accel_rate: Samples a second; 0 without an accelerometer.
        gyro_bias: Mean length of its rate [rad/s]; the camera's own motion is in it.
        gravity: Mean length of the acceleration [m/s^2]; 0 without an accelerometer.
    """

    rate: float
    holes: float
    gyro_rate: float
    accel_rate: float
    gyro_bias: float
    gravity: float


def cameras(context: Any = None) -> list[CameraIdentity]:
    """All RealSense cameras that are plugged in; none is opened."""
    devices = (context if context is not None else rs.context()).query_devices()
    return [
        CameraIdentity(*(_told(device, kind) for kind in (
            rs.camera_info.name,
            rs.camera_info.serial_number,
            rs.camera_info.firmware_version,
            rs.camera_info.usb_type_descriptor,
        )))
        for device in list(devices)
    ]  # fmt: skip


def examine_camera(camera: Camera, clock: Clock, seconds: float = 2.0) -> CameraExamination:
    """Read frames for a while.

    Args:
        camera: Open and at rest; it stays the caller's to close.
        clock: Time of the camera.
        seconds: How long.

    Raises:
        DeviceError: it gives no frames.
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


def _told(device: Any, kind: Any) -> str:
    return str(device.get_info(kind)) if device.supports(kind) else "unknown"
