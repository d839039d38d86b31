"""Depth images as devices give them, in 16 bits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_SATURATED = np.iinfo(np.uint16).max
"""What some cameras and data sets write where nothing was measured, instead of 0."""


def without_saturated(raw: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """The depth image (H, W) with 0 wherever nothing was measured."""
    return np.where(raw == _SATURATED, np.uint16(0), raw)
