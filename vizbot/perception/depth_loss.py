"""Depth that shows nothing: the robot notices that it cannot see, and whether it knows why.

A camera right before a wall sees no depth either (a D435i none below 0.28 m). The obstacle map
knows of that wall; where it knows of nothing, the camera may be broken, covered or dazzled, until
depth itself tells that it is not.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from math import radians, tan

import numpy as np

from vizbot.core.geometry import invert, transform
from vizbot.core.types import SE3, OccupancyGrid, RGBDFrame

log = logging.getLogger(__name__)

_LEAST_SHARE = 0.02
"""Depth at a smaller share of the pixels shows nothing that stands in the way."""
_TOO_NEAR = 0.6
"""An obstacle so near ahead of the base hides everything from its camera [m]."""
_HALF_VIEW = tan(radians(35.0))
_OCCUPIED = 0.6
_TOLD_AFTER = 0.5
"""What passes sooner is not worth a line [s]."""


class DepthLossMonitor:
    """Looks at depth, frame by frame.

    Attributes:
        seconds: How long it has shown nothing, for no known reason [s]; None while it does show
            something.
    """

    def __init__(self) -> None:
        """Nothing has been seen yet."""
        self.seconds: float | None = None
        self._since: float | None = None
        self._told = False

    def look(
        self, frame: RGBDFrame, T_map_base: SE3, grid: Callable[[], OccupancyGrid], now: float
    ) -> None:
        """Look at a frame.

        Args:
            frame: The newest.
            T_map_base: Where the robot is.
            grid: Gives the obstacle map; asked only where depth shows nothing all at once.
            now: Time [s].
        """
        shown = float(np.mean(frame.depth[::4, ::4] > 0.0))
        if shown >= _LEAST_SHARE:
            if self._told:
                log.warning("depth shows something again")
            self._since, self.seconds, self._told = None, None, False
            return
        if self._since is None:
            if _stands_before_something(grid(), T_map_base):
                return
            self._since = now
        self.seconds = now - self._since
        if self.seconds >= _TOLD_AFTER and not self._told:
            log.warning("depth shows nothing: the robot stands still until it does")
            self._told = True


def _stands_before_something(grid: OccupancyGrid, T_map_base: SE3) -> bool:
    """Whether an obstacle is right ahead."""
    xy = grid.to_xy(np.argwhere(grid.occupancy > _OCCUPIED))
    p_map = np.column_stack([xy, np.zeros(len(xy))])
    x, y, _ = transform(invert(T_map_base), p_map).T
    return bool(((x > 0.0) & (x < _TOO_NEAR) & (np.abs(y) < _HALF_VIEW * x)).any())
