"""Colour images of any format that a RealSense program records, as RGB."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_CONVERSIONS = {
    "bgr8": cv2.COLOR_BGR2RGB,
    "rgba8": cv2.COLOR_RGBA2RGB,
    "bgra8": cv2.COLOR_BGRA2RGB,
    "yuyv": cv2.COLOR_YUV2RGB_YUYV,
    "uyvy": cv2.COLOR_YUV2RGB_UYVY,
    "y8": cv2.COLOR_GRAY2RGB,
    "y16": cv2.COLOR_GRAY2RGB,
}
"""By the SDK's name of the format (`rs.format`)."""


def require_format(name: str) -> None:
    """Check that images of a format, by the SDK's name, can be converted.

    Raises:
        RuntimeError: they cannot.
    """
    if name != "rgb8" and name not in _CONVERSIONS:
        raise RuntimeError(f"its colour is {name}, which is not one of {', '.join(_CONVERSIONS)}")


def to_rgb(pixels: NDArray[np.generic], name: str, height: int, width: int) -> NDArray[np.uint8]:
    """A copy (H, W, 3) of the SDK's buffer, whose pixels have the format `name`.

    Raises:
        RuntimeError: it is of another size.
    """
    raw = np.ascontiguousarray(pixels).view(np.uint8).ravel()
    if raw.size == 0 or raw.size % (height * width):
        raise RuntimeError("its images are of another size than its calibration says")
    image = raw.reshape(height, width, -1)
    if name == "rgb8":
        return image.copy()
    # Of 16 bits the higher ones are the second byte.
    kept = image[..., 1:].copy() if name == "y16" else image
    return np.asarray(cv2.cvtColor(kept, _CONVERSIONS[name]), np.uint8)
