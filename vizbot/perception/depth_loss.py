"""Loss of depth: whether depth images show nothing, and whether the obstacle map explains it.

A camera right in front of a wall measures no depth either (a D435i none below 0.28 m). The obstacle
map shows that wall. Where it shows none, the camera may be broken, covered or dazzled, until it
measures depth again.
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
"""With depth at a smaller share of the pixels the camera may miss what stands in the way."""
_TOO_NEAR = 0.6
"""An obstacle within this distance ahead of the base may hide everything from its camera [m]."""
_HALF_VIEW = tan(radians(35.0))
_OCCUPIED = 0.6
_LOGGED_AFTER = 0.5
"""Shorter losses are not logged [s]."""


class DepthLossMonitor:
    """Measures for how long depth has shown nothing.

    Attributes:
        seconds: Duration of the loss, if the obstacle map does not explain it [s]; None without a
            loss.
    """

    def __init__(self) -> None:
        self.seconds: float | None = None
        self._since: float | None = None
        self._logged = False

    def observe(
        self, frame: RGBDFrame, T_map_base: SE3, grid: Callable[[], OccupancyGrid], now: float
    ) -> None:
        """Take in a frame.

        Args:
            frame: The newest frame.
            T_map_base: Where the robot is.
            grid: Gives the obstacle map; called only when depth is lost.
            now: Time [s].
        """
        shown = float(np.mean(frame.depth[::4, ::4] > 0.0))
        if shown >= _LEAST_SHARE:
            if self._logged:
                log.warning("depth shows something again")
            self._since, self.seconds, self._logged = None, None, False
            return
        if self._since is None:
            if _obstacle_ahead(grid(), T_map_base):
                return
            self._since = now
        self.seconds = now - self._since
        if self.seconds >= _LOGGED_AFTER and not self._logged:
            log.warning("depth shows nothing: the robot stands still until it does")
            self._logged = True


def _obstacle_ahead(grid: OccupancyGrid, T_map_base: SE3) -> bool:
    """Whether an obstacle is right ahead."""
    xy = grid.to_xy(np.argwhere(grid.occupancy > _OCCUPIED))
    p_map = np.column_stack([xy, np.zeros(len(xy))])
    x, y, _ = transform(invert(T_map_base), p_map).T
    return bool(((x > 0.0) & (x < _TOO_NEAR) & (np.abs(y) < _HALF_VIEW * x)).any())
