"""How much of the floor the robot has truly seen, beside what it says of that."""

from __future__ import annotations

import cv2
import numpy as np

from nav.frontier import FrontierSearch
from sim_stubs.homes.geometry.occupancy_slice import reachable
from sim_stubs.world.world import World
from vizbot.config import Config
from vizbot.core.types import SE3, OccupancyGrid


class SeenFloor:
    """The floor that the robot's body can cover, by the true plan, and what its camera looked at.

    Floor counts as seen by the robot's own measure, but from where it truly stood, and among true
    obstacles.
    """

    def __init__(self, world: World, config: Config) -> None:
        """Nothing is seen yet."""
        free, plan = world.free
        start = plan.cell_of(*world.T_world_base[:2, 3].tolist())
        self._radius = config.navigator.costmap.robot_radius
        cells = 2 * round(self._radius / plan.resolution) + 1
        body = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (cells, cells))
        centres = np.zeros_like(free) if start is None else reachable(free, start)
        self._floor = cv2.dilate(centres.astype(np.uint8), body) > 0
        occupied = cv2.dilate(free.astype(np.uint8), body) == 0
        self._grid = OccupancyGrid(occupied.astype(np.float32), plan.resolution, plan.origin)
        self._frontiers = FrontierSearch(config.frontier)

    def look(self, T_world_base: SE3) -> None:
        """The camera takes a picture from here."""
        self._frontiers.look(self._grid, T_world_base, self._radius)

    @property
    def share(self) -> float:
        """Share of the floor that was seen, 0 to 1."""
        seen = self._frontiers.explored.mask_on(self._grid) & self._floor
        return float(seen.sum() / self._floor.sum()) if self._floor.any() else 0.0
