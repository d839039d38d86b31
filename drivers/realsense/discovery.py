"""Discovery of RealSense cameras and of their frame rates."""

from __future__ import annotations

import logging
from collections.abc import Collection
from typing import Any

from drivers.realsense.config import RealSenseConfig
from drivers.realsense.sdk import rs
from vizbot.core.errors import DeviceError

log = logging.getLogger(__name__)

CONNECT = (
    "connect it to a USB 3 port with a USB 3 cable, and on Linux install the udev rules of "
    "librealsense (99-realsense-libusb.rules)"
)
"""Remedy for a missing camera."""


def cameras_by_serial(context: Any) -> dict[str, Any]:
    """All connected cameras (`rs.device`) by serial number, in the SDK's order."""
    found = {}
    for device in list(context.query_devices()):
        try:
            found[str(device.get_info(rs.camera_info.serial_number))] = device
        except RuntimeError as error:  # it was unplugged meanwhile
            log.debug("a camera does not give its serial number: %s", error)
    return found


def find_camera(context: Any, wanted: str | None) -> str:
    """Serial number of the camera to open: the wanted one, or the first.

    Raises:
        DeviceError: the camera is not found.
    """
    serials = list(cameras_by_serial(context))
    if not serials:
        which = "no RealSense camera" if wanted is None else f"RealSense {wanted}: no camera at all"
        raise DeviceError(f"{which} found; {CONNECT}")
    if wanted is not None and wanted not in serials:
        found = ", ".join(serials)
        raise DeviceError(f"RealSense {wanted}: not found, only {found}; set serial, or {CONNECT}")
    return wanted or serials[0]


def frame_rate(device: Any, config: RealSenseConfig, name: str) -> int:
    """Images per second to request: the wanted rate, or the nearest lower one of the camera.

    Colour and depth must both have it at the wanted size. A camera on USB 2 has only low rates. If
    none is low enough, the wanted rate is returned, for the SDK to reject.
    """
    depth = _rates(device, rs.stream.depth, rs.format.z16, config)
    color = _rates(device, rs.stream.color, rs.format.rgb8, config)
    rate = nearest_rate(config.fps, depth & color)
    if rate != config.fps:
        usb = _usb(device)
        log.warning(
            "%s: %dx%d comes at %d/s, not %d/s, on USB %s; use a USB 3 port and a USB 3 cable",
            name, config.width, config.height, rate, config.fps, usb,
        )  # fmt: skip
    return rate


def nearest_rate(wanted: int, offered: Collection[int]) -> int:
    """The highest offered rate not above `wanted`; `wanted` itself if there is none."""
    return max((rate for rate in offered if rate <= wanted), default=wanted)


def _rates(device: Any, stream: Any, form: Any, config: RealSenseConfig) -> set[int]:
    return {
        profile.fps()
        for sensor in device.query_sensors()
        for profile in sensor.get_stream_profiles()
        if profile.stream_type() == stream
        and profile.format() == form
        and _size(profile) == (config.width, config.height)
    }


def _size(profile: Any) -> tuple[int, int]:
    video = profile.as_video_stream_profile()
    return video.width(), video.height()


def _usb(device: Any) -> str:
    kind = rs.camera_info.usb_type_descriptor
    return str(device.get_info(kind)) if device.supports(kind) else "of unknown type"
