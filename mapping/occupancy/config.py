"""Settings of the obstacle map."""

from __future__ import annotations

from pydantic import Field

from vizbot.core.settings import BASIC, Settings


class ScanConfig(Settings):
    """How a depth image is classified into floor and obstacles."""

    stride: int = Field(default=2, ge=1, le=32)
    """Every n-th pixel of every n-th row is read, and this is n [px]."""
    min_depth: float = Field(default=0.15, ge=0.0, le=2.0)
    """Depth below this is not used [m]."""
    max_range: float = Field(default=4.5, ge=0.5, le=20.0, json_schema_extra=BASIC)
    """Points farther away than this over the floor are not used [m]."""
    range_step: float = Field(default=0.025, ge=0.005, le=0.5)
    """A polar cell is this long, which is half a map cell, so that no map cell is skipped [m]."""
    min_height: float = Field(default=0.06, ge=0.005, le=0.5)
    """Points up to this height count as floor [m]."""
    max_height: float = Field(default=0.75, ge=0.1, le=2.5, json_schema_extra=BASIC)
    """The robot, mast included, passes under anything above this height [m]."""
    tilt_tolerance: float = Field(default=0.012, ge=0.0, le=0.2)
    """An error of the camera's pitch up to this does not turn floor into obstacles [rad]."""
    depth_noise: float = Field(default=0.003, ge=0.0, le=0.1)
    """The standard deviation of depth is this times the square of the range (D435i) [1/m]."""
    edge_step: float = Field(default=0.05, ge=0.001, le=1.0)
    """A pixel is a flying pixel where depth to a neighbour steps by more than this fraction [1]."""
    min_points: int = Field(default=3, ge=1, le=1000)
    """An obstacle has at least this number of pixels in a polar cell, and a drop in four cells
    [1]."""
    drop_depth: float = Field(default=0.08, ge=0.01, le=1.0)
    """Points deeper below the floor than this are seen through a hole in it, as down stairs [m]."""
    drop_range: float = Field(default=2.0, ge=0.0, le=20.0)
    """A farther drop is not used, since pitch errs and shiny floors mirror the room [m]."""


class DepthMapperConfig(Settings):
    """Cells of the obstacle map, and how fast evidence changes them."""

    scan: ScanConfig = ScanConfig()
    """These settings say how a depth image is read."""
    resolution: float = Field(default=0.05, ge=0.01, le=0.5, json_schema_extra=BASIC)
    """A cell of the obstacle map is this wide (paper, common settings) [m]."""
    obstacle_odds: float = Field(default=0.6, ge=0.01, le=10.0)
    """One near view of an obstacle adds these log odds to its cell; far ones add less [1]."""
    floor_odds: float = Field(default=-0.4, ge=-10.0, le=-0.01)
    """One view of the floor adds these log odds to its cell [1]."""
    drop_odds: float = Field(default=0.4, ge=0.0, le=10.0)
    """One view of a drop adds these log odds: the robot avoids stairs as it avoids a wall [1]."""
    passed_odds: float = Field(default=-0.12, ge=-10.0, le=0.0)
    """Rays that pass over a cell add these log odds to it [1]."""
    min_odds: float = Field(default=-1.6, ge=-20.0, le=-0.1)
    """A cell has at least these log odds, so that an obstacle can appear within some frames [1]."""
    max_odds: float = Field(default=3.5, ge=0.1, le=20.0)
    """A cell has at most these log odds, so that a vanished obstacle is cleared soon [1]."""
    rebuild_distance: float = Field(default=0.025, ge=0.001, le=1.0)
    """The scans of a keyframe are painted again once it has moved by this [m]."""
    rebuild_angle: float = Field(default=0.0087, ge=1e-4, le=1.0)
    """The scans of a keyframe are painted again once it has turned by this [rad]."""
    place_size: float = Field(default=0.05, ge=0.001, le=1.0)
    """Scans or footprints of one keyframe replace each other within this distance [m]."""
    place_angle: float = Field(default=0.05, ge=0.001, le=1.6)
    """Scans at one place replace each other within this angle [rad]."""
