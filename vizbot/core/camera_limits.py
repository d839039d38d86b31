"""Limits of what cameras and recordings can be; damaged or hostile files exceed them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import Intrinsics

MOST_PIXELS = 16_384
"""Longest edge of an image [px]."""
LATEST_STAMP = 1e20
"""Latest stamp: far beyond nanoseconds since 1970, and differences are still finite [s]."""
FARTHEST_DEPTH = 8.0
"""Beyond this depth no indoor camera measures places; what it gives are false matches [m]."""
_SHORTEST, _LONGEST = 0.05, 50.0
"""Focal lengths in longest edges of the image. A pinhole sees 169 degrees with the one and 1.1 with
the other; no depth camera sees more, or less."""
_FEWEST_UNITS, _MOST_UNITS = 10.0, 1e6
"""Units of depth in a metre. 16 bits of larger units would reach beyond the 10 km of a map, and no
sensor measures smaller ones than a micrometre."""


def require_camera(camera: Intrinsics) -> None:
    """Reject intrinsics that no camera has.

    Raises:
        ValueError: a value is out of its range, or not a number.
    """
    width, height = camera.width, camera.height
    edge = max(width, height)
    if not (min(width, height) >= 1 and edge <= MOST_PIXELS):
        raise ValueError(f"images of {width}x{height} px are none of a camera's")
    for name, length in (("fx", camera.fx), ("fy", camera.fy)):
        _require(f"{name} [px]", length, _SHORTEST * edge, _LONGEST * edge)
    # Images may be cut out of larger ones, but not from farther away than that.
    _require("cx [px]", camera.cx, -edge, 2 * edge)
    _require("cy [px]", camera.cy, -edge, 2 * edge)


def require_depth_scale(depth_scale: float) -> None:
    """Reject units of depth, in a metre, that no camera measures in.

    Raises:
        ValueError: they are too few, too many, or not a number.
    """
    _require("depth_scale [1/m]", depth_scale, _FEWEST_UNITS, _MOST_UNITS)


def is_stamp(stamp: float) -> bool:
    """Whether a number can be a stamp [s]."""
    return abs(stamp) <= LATEST_STAMP


def _require(name: str, value: float, least: float, most: float) -> None:
    if not least <= value <= most:
        raise ValueError(f"{name} is {value:g}, a camera's is {least:g} to {most:g}")


_SATURATED = np.iinfo(np.uint16).max
"""What some cameras and data sets write where nothing was measured, instead of 0."""


def without_saturated(raw: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """The depth image (H, W) with 0 wherever nothing was measured."""
    return np.where(raw == _SATURATED, np.uint16(0), raw)
