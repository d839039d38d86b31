"""Whether a search that failed stood still, or drove and did not find."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Outcome

LAST = 100
"""Number of steps before the limit of steps in which a robot that gets on gets somewhere."""
RADIUS = 0.5
"""Radius of the circle that it then has left [m]."""


def is_stuck(outcome: Outcome | None, *, at_limit: bool, xy: NDArray[np.float64]) -> bool:
    """Whether a search that failed was stuck.

    It was where the robot says so itself, and where the limit of steps ended it in a place.

    Args:
        outcome: How the robot ended it; None after an error, which is no standstill.
        at_limit: Whether the limit of steps ended it.
        xy: True positions (N, 2) at its steps, the last of them where it ended [m].
    """
    if outcome is Outcome.STUCK:
        return True
    if not at_limit or outcome is None or len(xy) <= LAST:
        return False
    return enclosing_radius(xy[-LAST - 1 :]) <= RADIUS


def enclosing_radius(xy: NDArray[np.float64]) -> float:
    """Radius of the smallest circle around points (N, 2), of which there is one at least [m]."""
    near = (xy - xy[0]).astype(np.float32)  # far from the origin, single precision is too little
    _, radius = cv2.minEnclosingCircle(near)
    return float(radius)
