"""Costmap: the cost of a metre of path in each cell, and where the robot cannot be at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from nav.keep_out import forbidden
from vizbot.core.distance import distance_to_zero
from vizbot.core.settings import SETTINGS
from vizbot.core.types import OccupancyGrid


class CostmapConfig(BaseModel):
    """The robot's size, and its distance from obstacles."""

    model_config = SETTINGS

    robot_radius: float = Field(default=0.175, gt=0.0, le=1.0)
    """Half the width of the robot over the bumper [m]."""
    margin: float = Field(default=0.025, gt=0.0)
    """Further distance from obstacles wherever there is another path [m]."""
    slack: float = Field(default=0.05, ge=0.0)
    """Distance by which the map may draw obstacles too large; a tighter passage is closed [m]."""
    squeeze_cost: float = Field(default=15.0, gt=0.0)
    """Cost of a metre where the margin just does not hold; it grows towards closed cells. Blur and
    noise of depth must not shut the robot in where it has come through."""
    inflation_cost: float = Field(default=4.0, gt=0.0)
    """Extra cost of a metre where the margin just holds."""
    inflation_falloff: float = Field(default=0.12, gt=0.0)
    """Distance over which `inflation_cost` falls to a third [m]."""
    unknown_cost: float = Field(default=1.5, gt=0.0)
    """Cost of a metre in a cell never seen; free floor costs 1."""
    occupied_threshold: float = Field(default=0.65, gt=0.0)
    """Occupancy from which a cell is an obstacle."""
    free_threshold: float = Field(default=0.35, gt=0.0)
    """Occupancy up to which a cell is free; up to `occupied_threshold` it is unknown."""

    @property
    def safe_radius(self) -> float:
        """Distance of the robot's centre from obstacles wherever possible [m]."""
        return self.robot_radius + self.margin

    @property
    def closed_radius(self) -> float:
        """Distance of the robot's centre from obstacles everywhere [m]."""
        return self.robot_radius - self.slack


@dataclass(frozen=True, slots=True, eq=False)
class Costmap:
    """Costs of a grid, cell for cell.

    Attributes:
        grid: The obstacle map they were made from; converts between metres and cells.
        cost: (rows, cols) float32, cost of a metre, 1 or more; inf where the robot cannot be.
        clearance: (rows, cols) float32, from the cell's centre to the edge of the nearest occupied
            cell [m]; 0 in one, inf where there is none.
        to_zone: (rows, cols) float32, as `clearance`, to the nearest keep-out zone; None without.
        config: The settings they were made with.
        least: The least cost; inf where all cells are closed.
    """

    grid: OccupancyGrid
    cost: NDArray[np.float32]
    clearance: NDArray[np.float32]
    to_zone: NDArray[np.float32] | None
    config: CostmapConfig
    least: float

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """(rows, cols) cells that hold an obstacle."""
        return np.asarray(self.clearance == 0)

    @property
    def closed(self) -> NDArray[np.bool_] | None:
        """(rows, cols) cells where the robot would be in a keep-out zone; None without one."""
        return None if self.to_zone is None else self.to_zone <= self.config.safe_radius

    def room(self, cell: NDArray[np.int64]) -> float:
        """From a cell (2,) in the map to the nearest obstacle or keep-out zone [m]."""
        row, col = cell
        clearance = float(self.clearance[row, col])
        return clearance if self.to_zone is None else min(clearance, float(self.to_zone[row, col]))


def build_costmap(grid: OccupancyGrid, config: CostmapConfig) -> Costmap:
    """Inflate the obstacles of a grid by the robot's radius; unknown cells cost more but pass."""
    occupied = grid.occupancy >= config.occupied_threshold
    clearance = _distance_to(occupied, grid.resolution)
    cost = np.where(grid.occupancy <= config.free_threshold, 1.0, config.unknown_cost)
    nearness = (clearance - config.safe_radius) / config.inflation_falloff
    cost += config.inflation_cost * np.exp(-np.maximum(nearness, 0.0))
    tightness = (config.safe_radius - clearance) / config.margin
    cost = np.where(tightness > 0, config.squeeze_cost * (1 + tightness), cost)
    cost[clearance <= config.closed_radius] = np.inf
    to_zone = None
    if grid.zones:
        to_zone = _distance_to(forbidden(grid), grid.resolution)
        cost[to_zone <= config.safe_radius] = np.inf
    cost = cost.astype(np.float32)
    return Costmap(grid, cost, clearance, to_zone, config, float(cost.min()))


def _distance_to(cells: NDArray[np.bool_], resolution: float) -> NDArray[np.float32]:
    """From each cell's centre to the edge of the nearest of `cells` [m]; inf without any."""
    if not cells.any():
        return np.full(cells.shape, np.inf, np.float32)
    return np.asarray(np.maximum(distance_to_zero(~cells) - 0.5, 0.0) * resolution, np.float32)
