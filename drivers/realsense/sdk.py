"""The RealSense SDK as `rs`, importable on a machine without a libusb of its own.

The wheel of pyrealsense2 links to `libusb-1.0.so.0` and does not bring it. The system's library is
taken where there is one; otherwise the one from the wheel `libusb-package` is loaded first, whose
name inside the file is the same, so that the linker finds it. Import the SDK from here only.
"""

from __future__ import annotations

import ctypes

import libusb_package

from vizbot.core.errors import DeviceError


def _preload_libusb() -> None:
    try:
        ctypes.CDLL("libusb-1.0.so.0", mode=ctypes.RTLD_GLOBAL)
    except OSError:
        ctypes.CDLL(str(libusb_package.get_library_path()), mode=ctypes.RTLD_GLOBAL)


_preload_libusb()

try:
    import pyrealsense2 as rs
except ModuleNotFoundError as missing:
    raise DeviceError(
        "the RealSense SDK is not installed: pip install pyrealsense2 (on aarch64 there is a wheel"
        " for Python 3.12 alone)"
    ) from missing

__all__ = ["rs"]
