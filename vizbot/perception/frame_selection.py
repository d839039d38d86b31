"""Which images are worth an embedding."""

from __future__ import annotations

from math import radians

import numpy as np
from numpy.typing import NDArray

from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3

_OVEREXPOSED = 250
_LEAST_EXPOSED = 0.2
"""An image shows something when at least this share of it is not overexposed."""
_DISTANCE, _TURN = 0.1, radians(10.0)
"""Images from closer together show the same [m, rad]."""


def shows_something(rgb: NDArray[np.uint8]) -> bool:
    """Whether an image (H, W, 3) is not overexposed nearly everywhere, as by the sun."""
    return bool((rgb[::8, ::8] < _OVEREXPOSED).any(axis=2).mean() >= _LEAST_EXPOSED)


def shows_more(T_map_previous: SE3 | None, T_map_cam: SE3) -> bool:
    """Whether an image is from elsewhere than the previous one; a first image is."""
    if T_map_previous is None:
        return True
    T_previous_cam = invert(T_map_previous) @ T_map_cam
    moved = float(np.linalg.norm(T_previous_cam[:3, 3]))
    return moved > _DISTANCE or rotation_angle(T_previous_cam) > _TURN
