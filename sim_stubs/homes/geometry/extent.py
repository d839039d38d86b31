"""How large a world may be; a world is refused by it before OpenCV is loaded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

WIDEST = 100.0
"""Longest edge of the box around a world [m]. Cells of 1 cm in a square of that width take 3 GB and
a quarter of a minute; homes are a third as wide."""


def require_home_sized(points: NDArray[np.float64]) -> None:
    """Reject a world that is too large; call it before its shapes are made.

    Args:
        points: (N, 2) or (N, 3), what the world reaches [m].

    Raises:
        ValueError: it is too large, or a coordinate is not a number.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        width = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if not width <= WIDEST:
        raise ValueError(
            f"it is {width:g} m wide, of {WIDEST:g} m at most: give its lengths in the right unit,"
            " or a part of it"
        )
