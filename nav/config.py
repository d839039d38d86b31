"""Settings of planning, exploration, path following and recovery."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, Field, model_validator

from vizbot.core.settings import SETTINGS

UNDOCKING_TIME = 8.0
"""Time that a robot has to leave its dock [s]."""
_Coordinate = Annotated[float, Field(ge=-1000.0, le=1000.0)]


class CostmapConfig(BaseModel):
    """The robot's size, and its distance from obstacles."""

    model_config = SETTINGS

    robot_radius: float = Field(default=0.175, ge=0.1, le=0.5)
    """Half the width of the robot over the bumper [m]."""
    margin: float = Field(default=0.025, ge=0.001, le=0.5)
    """Further distance from obstacles wherever there is another path [m]."""
    slack: float = Field(default=0.05, ge=0.0, le=0.5)
    """Distance by which the map may draw obstacles too large; a tighter passage is closed [m]."""
    squeeze_cost: float = Field(default=15.0, ge=0.01, le=1000.0)
    """Cost of a metre where the margin just does not hold [1]; it grows towards closed cells. Blur
    and noise of depth must not shut the robot in where it has come through."""
    inflation_cost: float = Field(default=4.0, ge=0.01, le=1000.0)
    """Extra cost of a metre where the margin just holds [1]."""
    inflation_falloff: float = Field(default=0.12, ge=0.005, le=2.0)
    """Distance over which `inflation_cost` falls to a third [m]."""
    unknown_cost: float = Field(default=1.5, ge=0.01, le=1000.0)
    """Cost of a metre in a cell never seen [1]; free floor costs 1."""
    occupied_threshold: float = Field(default=0.65, ge=0.01, le=1.0)
    """Occupancy from which a cell is an obstacle [1]."""
    free_threshold: float = Field(default=0.35, ge=0.01, le=1.0)
    """Occupancy up to which a cell is free [1]; up to `occupied_threshold` it is unknown."""

    @model_validator(mode="after")
    def _leaves_a_robot(self) -> Self:
        if self.slack >= self.robot_radius:
            raise ValueError(
                f"slack {self.slack} m leaves nothing of robot_radius {self.robot_radius} m; lower"
                " it, in metres"
            )
        return self

    @property
    def safe_radius(self) -> float:
        """Distance of the robot's centre from obstacles wherever possible [m]."""
        return self.robot_radius + self.margin

    def inflation_cells(self, resolution: float) -> int:
        """Distance in cells from which an obstacle changes no bit of a cost."""
        least = min(1.0, self.unknown_cost)
        vanishing = np.log(2.0**26 * max(self.inflation_cost / least, 1.0))
        reach = self.safe_radius + self.inflation_falloff * vanishing
        return int(np.ceil(reach / resolution + 0.5))

    @property
    def closed_radius(self) -> float:
        """Distance of the robot's centre from obstacles everywhere [m]."""
        return self.robot_radius - self.slack


class FollowerConfig(BaseModel):
    """Speeds, and how closely the robot follows the path."""

    model_config = SETTINGS

    max_linear: float = Field(default=0.43, ge=0.05, le=0.5)
    """Largest forward speed [m/s]."""
    max_angular: float = Field(default=1.3, ge=0.05, le=4.3)
    """Largest turn rate [rad/s]."""
    deceleration: float = Field(default=0.8, ge=0.05, le=10.0)
    """Deceleration towards the end of the path [m/s^2]."""
    lookahead: float = Field(default=0.35, ge=0.05, le=2.0)
    """Distance along the path to the point that is pursued [m]."""
    min_lookahead: float = Field(default=0.15, ge=0.02, le=2.0)
    """The same distance beside obstacles, where cutting a bend would touch them [m]."""
    turn_in_place_angle: float = Field(default=0.6, ge=0.05, le=3.2)
    """Bearing of the pursued point from which the robot turns before it drives [rad]."""
    turn_gain: float = Field(default=2.5, ge=0.1, le=20.0)
    """Turn rate per error of heading; its product with `hold` is below 1, or turns overshoot
    [1/s]."""
    hold: float = Field(default=0.29, ge=0.02, le=1.0)
    """Time for which the base may hold a twist [s]."""
    slow_gap: float = Field(default=0.175, ge=0.01, le=1.0)
    """Gap between the robot's rim and an obstacle below which it slows down [m]."""
    slow_fraction: float = Field(default=0.4, ge=0.05, le=1.0)
    """Share of the full speed that is left at an obstacle [1]."""


class Reach(BaseModel):
    """When a goal counts as reached."""

    model_config = SETTINGS

    distance: float = Field(ge=0.05, le=20.0)
    """Largest distance between the goal and the robot's centre [m]."""
    extent: float = Field(ge=0.001, le=20.0)
    """Distance from a goal point within which obstacles belong to the goal; only those before it,
    where the point it was seen from is known [m]."""


class NavigatorConfig(BaseModel):
    """How the robot drives to its goals."""

    model_config = SETTINGS

    costmap: CostmapConfig = CostmapConfig()
    """The robot's size and its distance from obstacles."""
    follower: FollowerConfig = FollowerConfig()
    """Speeds along the path."""
    reach_margin: float = Field(default=0.1, ge=0.001, le=1.0)
    """Distance by which paths end nearer than `Reach.distance`, so that the robot does not stop at
    its limit [m]."""
    facing_tolerance: float = Field(default=0.15, ge=0.01, le=1.6)
    """Largest error of heading at which the robot faces its goal [rad]."""
    distant_point: tuple[_Coordinate, _Coordinate] = (-50.0, -50.0)
    """Point x, y in `map` towards which the robot explores (paper, common settings) [m]."""
    keep_path_saving: float = Field(default=0.3, ge=0.0, le=1000.0)
    """Cost that a new path must save to replace the one being driven [1]."""
    keep_path_within: float = Field(default=0.2, ge=0.0, le=10.0)
    """Distance from its path beyond which the robot takes a new one [m]."""


class FrontierConfig(BaseModel):
    """What counts as explored, and which frontier is chosen."""

    model_config = SETTINGS

    field_of_view: float = Field(default=1.1, ge=0.1, le=3.1)
    """Horizontal field of view of the camera, somewhat less than its true one [rad]."""
    look_range: float = Field(default=2.5, ge=0.3, le=20.0)
    """Range up to which cells count as explored, though depth may reach farther [m]."""
    blind_range: float = Field(default=1.3, ge=0.0, le=5.0)
    """Range within which the floor lies below the image, and still counts as explored [m]."""
    unmeasured_gap: float = Field(default=0.4, ge=0.0, le=5.0)
    """Most floor without depth, dark or shiny, that the view crosses [m]."""
    min_length: float = Field(default=0.4, ge=0.01, le=10.0)
    """Least length of a frontier [m]."""
    stand_off: float = Field(default=0.6, ge=0.05, le=5.0)
    """Distance from which a frontier that the robot faces, and that persists, is given up [m]."""
    given_up_radius: float = Field(default=0.5, ge=0.01, le=10.0)
    """Distance from a frontier that was given up within which others are ignored, too [m]."""
    gain_reach: float = Field(default=2.5, ge=0.1, le=20.0)
    """Distance beyond a frontier up to which its gain, the area to see there, is estimated [m]."""
    min_gain: float = Field(default=0.2, ge=0.0, le=100.0)
    """Least gain of a frontier [m^2]."""
    good_view: float = Field(default=0.5, ge=0.01, le=1.0)
    """Least gain of a point to stand for its frontier, as a share of the best point's gain [1]."""
    most_gain: float = Field(default=6.0, ge=0.1, le=1000.0)
    """Largest gain that counts [m^2]."""
    gain_worth: float = Field(default=2.5, ge=0.0, le=100.0)
    """Length of path that a square metre of gain is worth [m/m^2]."""
    turn_cost: float = Field(default=0.15, ge=0.0, le=100.0)
    """Length of path that a radian of turning towards the frontier costs [m/rad]."""
    keep_worth: float = Field(default=0.6, ge=0.0, le=100.0)
    """Length of path that a frontier must save to replace the one being driven to [m]."""


class RecoveryConfig(BaseModel):
    """How the robot recovers, and when it gives up."""

    model_config = SETTINGS

    pause: float = Field(default=0.2, ge=0.05, le=5.0)
    """Time that the robot stands still before it backs off [s]."""
    back_off_distance: float = Field(default=0.1, ge=0.02, le=0.3)
    """Distance that the robot backs off [m]."""
    back_off_speed: float = Field(default=0.12, ge=0.06, le=0.3)
    """Speed at which the robot backs off [m/s]."""
    undocking: float = Field(default=0.5, ge=0.1, le=1.5)
    """Distance that the robot backs off from its dock before it turns [m]."""
    passive_patience: float = Field(default=3.0, ge=0.0, le=600.0)
    """Time for a base that left Safe mode to return to it, as after a corrupt byte [s]."""
    lift_patience: float = Field(default=60.0, ge=1.0, le=86400.0)
    """Time that a robot that may resume by itself waits to be put down [s]."""
    blind_patience: float = Field(default=5.0, ge=0.0, le=600.0)
    """Time without depth after which the robot turns once around, then gives up [s]."""
    battery_floor: float = Field(default=0.1, ge=0.05, le=0.9)
    """Charge below which the search ends, as a share of a full battery [1]."""
    edge_patience: float = Field(default=6.0, ge=0.5, le=600.0)
    """Time after which a robot that is still at an edge gives up [s]."""

    @model_validator(mode="after")
    def _leaves_its_dock_in_time(self) -> Self:
        takes = self.undocking / self.back_off_speed
        if takes > 0.9 * UNDOCKING_TIME:
            raise ValueError(
                f"undocking {self.undocking} m at back_off_speed {self.back_off_speed} m/s takes"
                f" {takes:.1f} s, and {0.9 * UNDOCKING_TIME:.1f} s are allowed; lower the one or"
                " raise the other"
            )
        return self
