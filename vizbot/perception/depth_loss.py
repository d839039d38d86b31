"""Loss of depth: whether depth images show nothing, and whether the obstacle map explains it.

A camera right in front of a wall measures no depth (a D435i none below 0.28 m), nor does one whose
view a bare wall fills. The obstacle map shows that wall. Where it shows none, the camera may be
broken, covered or dazzled, until it measures depth again. If it does so in another direction, it
was in front of something that the map has missed, as a bare wall: `unseen_ahead` says where that
may stand.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from math import radians, tan

import numpy as np
from numpy.typing import NDArray

from nav.config import FrontierConfig
from vizbot.core.geometry import invert, transform
from vizbot.core.types import SE3, OccupancyGrid, RGBDFrame

log = logging.getLogger(__name__)

_LEAST_SHARE = 0.02
"""Least share of pixels with depth; with fewer the camera may miss what stands in the way."""
_TOO_NEAR = 0.6
"""An obstacle within this distance ahead of the base may hide everything from its camera [m]."""
_HALF_VIEW = tan(radians(35.0))
_RAYS = 45
"""Rays of the view, which are less than a cell apart where the floor comes into view."""
_FILLED = 0.9
"""Share of the view that obstacles must fill to hide everything."""
_FREE = 0.35
_OCCUPIED = 0.6
_LOGGED_AFTER = 0.5
"""Shorter losses are not logged [s]."""


class DepthLossMonitor:
    """Measures for how long depth has shown nothing.

    Attributes:
        seconds: Duration of the loss, if the obstacle map does not explain it [s]; None without a
            loss.
    """

    def __init__(self, view: FrontierConfig | None = None) -> None:
        """Begin with depth; `view` None takes the defaults."""
        self._view = FrontierConfig() if view is None else view
        self.seconds: float | None = None
        self._since: float | None = None
        self._logged = False

    def observe(
        self, frame: RGBDFrame, T_map_base: SE3, grid: Callable[[], OccupancyGrid], now: float
    ) -> None:
        """Take in the newest frame at `now` [s]; `grid` is called only when depth is lost."""
        shown = float(np.mean(frame.depth[::4, ::4] > 0.0))
        if shown >= _LEAST_SHARE:
            if self._logged:
                log.warning("depth shows something again")
            self._since, self.seconds, self._logged = None, None, False
            return
        if self._since is None:
            known = grid()
            if _obstacle_ahead(known, T_map_base) or _wall_ahead(known, T_map_base, self._view):
                return
            self._since = now
        self.seconds = now - self._since
        if self.seconds >= _LOGGED_AFTER and not self._logged:
            log.warning("depth shows nothing: the robot stands still until it does")
            self._logged = True


def unseen_ahead(grid: OccupancyGrid, T_map_base: SE3, view: FrontierConfig) -> NDArray[np.float64]:
    """The nearest unseen places, where something may stand that hides everything from the camera.

    Nothing that stands beyond where the floor comes into view can hide everything.

    Args:
        grid: The obstacle map.
        T_map_base: Where the robot is.
        view: What the camera has in view.

    Returns:
        (N, 2) x, y in `base` [m], one in each direction of the view in which nothing but free floor
        is known before it.
    """
    nearest, occupancy = _first_not_free(grid, T_map_base, view)
    return np.asarray(nearest[(occupancy > _FREE) & (occupancy <= _OCCUPIED)])


def _wall_ahead(grid: OccupancyGrid, T_map_base: SE3, view: FrontierConfig) -> bool:
    """Whether obstacles fill the view, nearer than where the floor comes into it."""
    _, occupancy = _first_not_free(grid, T_map_base, view)
    return float(np.mean(occupancy > _OCCUPIED)) >= _FILLED


def _first_not_free(
    grid: OccupancyGrid, T_map_base: SE3, view: FrontierConfig
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """The first place in each direction of the view that is not known to be free.

    Returns:
        (N, 2) x, y in `base` [m]; (N,) its occupancy, 0 where none is before the floor comes into
        view.
    """
    bearings = np.linspace(-0.5, 0.5, _RAYS)[:, None] * view.field_of_view
    ranges = np.arange(0.5, view.blind_range / grid.resolution) * grid.resolution
    points = np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings)], axis=-1)
    cells = grid.to_cells(points @ T_map_base[:2, :2].T + T_map_base[:2, 3])
    occupancy = np.full(cells.shape[:-1], 0.5, np.float32)
    inside = grid.contains(cells)
    occupancy[inside] = grid.occupancy[tuple(cells[inside].T)]
    occupancy[occupancy <= _FREE] = 0.0
    first, rays = np.argmax(occupancy > 0.0, axis=1), np.arange(_RAYS)
    return points[rays, first], occupancy[rays, first]


def _obstacle_ahead(grid: OccupancyGrid, T_map_base: SE3) -> bool:
    """Whether an obstacle is right ahead."""
    xy = grid.to_xy(np.argwhere(grid.occupancy > _OCCUPIED))
    p_map = np.column_stack([xy, np.zeros(len(xy))])
    x, y, _ = transform(invert(T_map_base), p_map).T
    return bool(((x > 0.0) & (x < _TOO_NEAR) & (np.abs(y) < _HALF_VIEW * x)).any())
