"""Recovery after a bump or at an edge: stop, back off, and mark in the map what was touched."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from nav.config import RecoveryConfig
from vizbot.core.types import STOP, Twist

CLIFF_BEARINGS = (60.0, 15.0, -15.0, -60.0)
"""Bearings of the cliff sensors: left, front left, front right, right [degrees]."""


class Recovery:
    """Stops and backs off; it is over when `twist` returns None."""

    def __init__(self, config: RecoveryConfig) -> None:
        self._config = config
        self._started: float | None = None

    def begin(self, now: float) -> None:
        """Start, or start again, at `now` [s]."""
        self._started = now

    def twist(self, now: float) -> Twist | None:
        """The twist to drive at `now` [s]; None when no recovery is under way."""
        if self._started is None:
            return None
        config = self._config
        elapsed = now - self._started
        if elapsed < config.pause:
            return STOP
        if elapsed < config.pause + config.back_off_distance / config.back_off_speed:
            return Twist(-config.back_off_speed, 0.0)
        self._started = None
        return None


def contact_points(bump_left: bool, bump_right: bool, robot_radius: float) -> NDArray[np.float64]:
    """Points (N, 2) x, y in `base` [m] just outside the bumper where something was touched.

    The bumper has two switches: both mean straight ahead, one means its own front quarter. The arc
    is short, since a wider one at a door frame would close the door.
    """
    if bump_left and bump_right:
        degrees = [-15.0, 0.0, 15.0]
    elif bump_left:
        degrees = [20.0, 35.0, 50.0]
    elif bump_right:
        degrees = [-20.0, -35.0, -50.0]
    else:
        degrees = []
    return _outside(degrees, robot_radius)


def edge_points(cliffs: tuple[bool, bool, bool, bool], robot_radius: float) -> NDArray[np.float64]:
    """Points (N, 2) x, y in `base` [m] just outside the robot where a cliff sensor sees no floor.

    `cliffs` are those of `BaseState`.
    """
    active = [bearing for bearing, cliff in zip(CLIFF_BEARINGS, cliffs, strict=True) if cliff]
    return _outside(
        [bearing + aside for bearing in active for aside in (-15.0, 0.0, 15.0)], robot_radius
    )


def _outside(degrees: Sequence[float], robot_radius: float) -> NDArray[np.float64]:
    angles = np.radians(degrees)
    # Half a cell of 5 cm outside, so that the marked cell is not one the robot stands in.
    return (robot_radius + 0.025) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
