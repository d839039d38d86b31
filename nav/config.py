"""Settings of planning, exploration, path following and recovery."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from vizbot.core.settings import BASIC, Settings

UNDOCKING_TIME = 8.0
"""Time that a robot has to leave its dock [s]."""
_Coordinate = Annotated[float, Field(ge=-1000.0, le=1000.0)]


class CostmapConfig(Settings):
    """The robot's size, and its distance from obstacles."""

    robot_radius: float = Field(default=0.175, ge=0.1, le=0.5, json_schema_extra=BASIC)
    """The robot is twice this wide over the bumper [m]."""
    margin: float = Field(default=0.025, ge=0.001, le=0.5, json_schema_extra=BASIC)
    """The robot keeps this further distance from obstacles wherever there is another path [m]."""
    map_tolerance: float = Field(default=0.05, ge=0.0, le=0.5)
    """The map may draw obstacles too large by this; a passage tighter than that is closed [m]."""
    squeeze_cost: float = Field(default=15.0, ge=0.01, le=1000.0)
    """A metre costs this where the margin just does not hold, and more towards closed cells; blur
    and noise of depth must not shut the robot in where it has come through [1]."""
    inflation_cost: float = Field(default=4.0, ge=0.01, le=1000.0)
    """A metre costs this much more where the margin just holds [1]."""
    inflation_falloff: float = Field(default=0.12, ge=0.005, le=2.0)
    """The extra cost `inflation_cost` falls to a third over this distance [m]."""
    unknown_cost: float = Field(default=1.5, ge=0.01, le=1000.0)
    """A metre in a cell never seen costs this; free floor costs 1 [1]."""
    occupied_threshold: float = Field(default=0.65, ge=0.01, le=1.0)
    """A cell is an obstacle from this occupancy on [1]."""
    free_threshold: float = Field(default=0.35, ge=0.01, le=1.0)
    """A cell is free up to this occupancy, and unknown from there to `occupied_threshold` [1]."""

    @model_validator(mode="after")
    def _leaves_a_robot(self) -> Self:
        if self.map_tolerance >= self.robot_radius:
            raise ValueError(
                f"map_tolerance {self.map_tolerance} m leaves nothing of robot_radius"
                f" {self.robot_radius} m; lower it, in metres"
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
        return self.robot_radius - self.map_tolerance


class FollowerConfig(Settings):
    """Speeds, and how closely the robot follows the path."""

    max_linear: float = Field(default=0.43, ge=0.05, le=0.5, json_schema_extra=BASIC)
    """The robot drives forward at most this fast [m/s]."""
    max_angular: float = Field(default=1.3, ge=0.05, le=4.3, json_schema_extra=BASIC)
    """The robot turns at most this fast [rad/s]."""
    deceleration: float = Field(default=0.8, ge=0.05, le=10.0, json_schema_extra=BASIC)
    """The robot slows down by this towards the end of the path [m/s^2]."""
    lookahead: float = Field(default=0.35, ge=0.05, le=2.0)
    """The robot pursues a point this far ahead along its path [m]."""
    min_lookahead: float = Field(default=0.15, ge=0.02, le=2.0)
    """Beside obstacles, where bends must not be cut, the robot pursues a point this far ahead
    [m]."""
    turn_in_place_angle: float = Field(default=0.6, ge=0.05, le=3.2)
    """The robot turns before it drives where the pursued point lies this far aside [rad]."""
    turn_gain: float = Field(default=2.5, ge=0.1, le=20.0)
    """The turn rate is this times the error of heading; its product with `twist_duration` is below
    1, or turns overshoot [1/s]."""
    twist_duration: float = Field(default=0.29, ge=0.02, le=1.0)
    """The base may hold a twist for this time [s]."""
    slow_gap: float = Field(default=0.175, ge=0.01, le=1.0)
    """The robot slows down where the gap between its rim and an obstacle is below this [m]."""
    slow_fraction: float = Field(default=0.4, ge=0.05, le=1.0)
    """The robot keeps this share of its full speed at an obstacle [1]."""


class Reach(Settings):
    """Conditions under which a goal counts as reached."""

    distance: float = Field(ge=0.05, le=20.0)
    """The goal is reached where the robot's centre is within this distance of it [m]."""
    extent: float = Field(ge=0.001, le=20.0)
    """Obstacles within this distance of a goal point belong to the goal; where the point it was
    seen from is known, only those before it do [m]."""


class NavigatorConfig(Settings):
    """Driving to goals."""

    costmap: CostmapConfig = CostmapConfig()
    """These settings are the robot's size and its distance from obstacles."""
    follower: FollowerConfig = FollowerConfig()
    """These settings are the speeds along the path."""
    reach_margin: float = Field(default=0.1, ge=0.001, le=1.0)
    """Paths end this far within the limits of where a goal is reached, so that the robot does not
    stop at one [m]."""
    facing_tolerance: float = Field(default=0.15, ge=0.01, le=1.6)
    """The robot faces its goal where its heading errs by at most this [rad]."""
    distant_point: tuple[_Coordinate, _Coordinate] = (-50.0, -50.0)
    """The robot explores towards this point x, y in `map` (paper, common settings) [m]."""
    keep_path_saving: float = Field(default=0.3, ge=0.0, le=1000.0)
    """A new path must save this cost to replace the one being driven [1]."""
    keep_path_within: float = Field(default=0.2, ge=0.0, le=10.0)
    """The robot takes a new path where it is farther from its own than this [m]."""


class FrontierConfig(Settings):
    """Exploration, and the choice of a frontier."""

    field_of_view: float = Field(default=1.1, ge=0.1, le=3.1)
    """The camera sees this angle horizontally, somewhat less than in truth [rad]."""
    look_range: float = Field(default=2.5, ge=0.3, le=20.0)
    """Cells up to this range count as explored, though depth may reach farther [m]."""
    blind_range: float = Field(default=1.3, ge=0.0, le=5.0)
    """Within this range the floor lies below the image, and still counts as explored [m]."""
    unmeasured_gap: float = Field(default=0.4, ge=0.0, le=5.0)
    """The view crosses at most this much floor without depth, which is dark or shiny [m]."""
    min_length: float = Field(default=0.4, ge=0.01, le=10.0)
    """A frontier is at least this long [m]."""
    stand_off: float = Field(default=0.6, ge=0.05, le=5.0)
    """A frontier that the robot faces from this distance, and that persists, is given up [m]."""
    given_up_radius: float = Field(default=0.5, ge=0.01, le=10.0)
    """Frontiers within this distance of one that was given up are ignored, too [m]."""
    gain_reach: float = Field(default=2.5, ge=0.1, le=20.0)
    """The gain of a frontier is the area to see up to this distance beyond it [m]."""
    min_gain: float = Field(default=0.2, ge=0.0, le=100.0)
    """A frontier has at least this gain [m^2]."""
    min_gain_share: float = Field(default=0.5, ge=0.01, le=1.0)
    """A point may stand for its frontier from this share of the best point's gain on [1]."""
    max_gain: float = Field(default=6.0, ge=0.1, le=1000.0)
    """A larger gain than this counts as this [m^2]."""
    path_per_gain: float = Field(default=2.5, ge=0.0, le=100.0)
    """A square metre of gain is worth this length of path [m/m^2]."""
    turn_cost: float = Field(default=0.15, ge=0.0, le=100.0)
    """A radian of turning towards the frontier costs this length of path [m/rad]."""
    frontier_change_saving: float = Field(default=0.6, ge=0.0, le=100.0)
    """A frontier must save this length of path to replace the one being driven to [m]."""


class RecoveryConfig(Settings):
    """Recovery, and its limits."""

    pause: float = Field(default=0.2, ge=0.05, le=5.0)
    """The robot stands still for this time before it backs off [s]."""
    back_off_distance: float = Field(default=0.1, ge=0.02, le=0.3, json_schema_extra=BASIC)
    """The robot backs off by this distance [m]."""
    back_off_speed: float = Field(default=0.12, ge=0.06, le=0.3, json_schema_extra=BASIC)
    """The robot backs off at this speed [m/s]."""
    undocking: float = Field(default=0.5, ge=0.1, le=1.5, json_schema_extra=BASIC)
    """The robot backs off from its dock by this distance before it turns [m]."""
    safe_mode_timeout: float = Field(default=3.0, ge=0.0, le=600.0)
    """A base that left Safe mode has this time to return to it, as after a corrupt byte [s]."""
    lift_timeout: float = Field(default=60.0, ge=1.0, le=86400.0, json_schema_extra=BASIC)
    """A robot that may resume by itself waits this time to be put down [s]."""
    depth_timeout: float = Field(default=5.0, ge=0.0, le=600.0)
    """The robot turns once around after this time without depth, then gives up [s]."""
    min_battery: float = Field(default=0.1, ge=0.05, le=0.9, json_schema_extra=BASIC)
    """The search ends where the charge is below this share of a full battery [1]."""
    edge_timeout: float = Field(default=6.0, ge=0.5, le=600.0)
    """A robot that is still at an edge gives up after this time [s]."""

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
