"""Which pictures tell the CLIP map something."""

from __future__ import annotations

from math import radians

import numpy as np
from numpy.typing import NDArray

from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3

_BURNT_OUT = 250
_SEEN = 0.2
"""Least share of a picture that is not burnt out, if it shows anything."""
_DISTANCE, _TURN = 0.1, radians(10.0)
"""Pictures nearer to each other show the same [m, rad]."""


def shows_something(rgb: NDArray[np.uint8]) -> bool:
    """Whether a picture (H, W, 3) is not burnt out nearly everywhere, as by the sun."""
    return bool((rgb[::8, ::8] < _BURNT_OUT).any(axis=2).mean() >= _SEEN)


def shows_more(T_map_before: SE3 | None, T_map_cam: SE3) -> bool:
    """Whether a picture is from elsewhere than the one before it; without that it is."""
    if T_map_before is None:
        return True
    T_before_cam = invert(T_map_before) @ T_map_cam
    moved = float(np.linalg.norm(T_before_cam[:3, 3]))
    return moved > _DISTANCE or rotation_angle(T_before_cam) > _TURN
