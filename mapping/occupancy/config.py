"""Settings of the obstacle map."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class ScanConfig(BaseModel):
    """How a depth image is classified into floor and obstacles."""

    model_config = SETTINGS

    stride: int = Field(default=2, ge=1, le=32)
    """Distance of the pixels that are read, along rows and columns [px]."""
    min_depth: float = Field(default=0.15, ge=0.0, le=2.0)
    """Least depth that is used [m]."""
    max_range: float = Field(default=4.5, ge=0.5, le=20.0)
    """Largest distance over the floor of points that are used [m]."""
    range_step: float = Field(default=0.025, ge=0.005, le=0.5)
    """Length of a polar cell [m]; half a map cell, so that no map cell is skipped."""
    min_height: float = Field(default=0.06, ge=0.005, le=0.5)
    """Height up to which points count as floor [m]."""
    max_height: float = Field(default=0.75, ge=0.1, le=2.5)
    """Height above which the robot, mast included, passes under anything [m]."""
    tilt_tolerance: float = Field(default=0.012, ge=0.0, le=0.2)
    """Error of the camera's pitch that must not turn floor into obstacles [rad]."""
    depth_noise: float = Field(default=0.003, ge=0.0, le=0.1)
    """Standard deviation of depth over the square of the range (D435i) [1/m]."""
    edge_step: float = Field(default=0.05, ge=0.001, le=1.0)
    """Relative step of depth to a neighbour from which a pixel is a flying pixel [1]."""
    min_points: int = Field(default=3, ge=1, le=1000)
    """Least number of pixels for an obstacle in a polar cell, or for a drop in four cells [1]."""
    drop_depth: float = Field(default=0.08, ge=0.01, le=1.0)
    """Depth below the floor from which points are seen through a hole in it, as down stairs [m]."""
    drop_range: float = Field(default=2.0, ge=0.0, le=20.0)
    """Largest distance of a drop that is used: pitch errs, and shiny floors mirror the room [m]."""


class DepthMapperConfig(BaseModel):
    """Cells of the obstacle map, and how fast evidence changes them."""

    model_config = SETTINGS

    scan: ScanConfig = ScanConfig()
    """How a depth image is read."""
    resolution: float = Field(default=0.05, ge=0.01, le=0.5)
    """Edge of a cell [m] (paper, common settings)."""
    obstacle_odds: float = Field(default=0.6, ge=0.01, le=10.0)
    """Log odds that one near view of an obstacle adds to its cell [1]; far ones add less."""
    floor_odds: float = Field(default=-0.4, ge=-10.0, le=-0.01)
    """Log odds that one view of the floor adds to its cell [1]."""
    drop_odds: float = Field(default=0.4, ge=0.0, le=10.0)
    """Log odds that one view of a drop adds [1]: the robot avoids stairs as it avoids a wall."""
    passed_odds: float = Field(default=-0.12, ge=-10.0, le=0.0)
    """Log odds that rays which pass over a cell add to it [1]."""
    min_odds: float = Field(default=-1.6, ge=-20.0, le=-0.1)
    """Least log odds of a cell, so that an obstacle can appear within some frames [1]."""
    max_odds: float = Field(default=3.5, ge=0.1, le=20.0)
    """Largest log odds of a cell, so that a vanished obstacle is cleared within some frames [1]."""
    rebuild_distance: float = Field(default=0.025, ge=0.001, le=1.0)
    """Motion of a keyframe from which its scans are painted again [m]."""
    rebuild_angle: float = Field(default=0.0087, ge=1e-4, le=1.0)
    """Turn of a keyframe from which its scans are painted again [rad]."""
    place_size: float = Field(default=0.05, ge=0.001, le=1.0)
    """Distance within which scans or footprints of one keyframe replace each other [m]."""
    place_angle: float = Field(default=0.05, ge=0.001, le=1.6)
    """Angle within which scans at one place replace each other [rad]."""
