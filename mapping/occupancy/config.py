"""Settings of the obstacle map."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class ScanConfig(BaseModel):
    """How a depth image is classified into floor and obstacles."""

    model_config = SETTINGS

    stride: int = 2
    """Distance of the pixels that are read, along rows and columns [px]."""
    min_depth: float = 0.15
    """Least depth that is used [m]."""
    max_range: float = 4.5
    """Largest distance over the floor of points that are used [m]."""
    range_step: float = 0.025
    """Length of a polar cell [m]; half a map cell, so that no map cell is skipped."""
    min_height: float = 0.06
    """Height up to which points count as floor [m]."""
    max_height: float = 0.75
    """Height above which the robot, mast included, passes under anything [m]."""
    tilt_tolerance: float = 0.012
    """Error of the camera's pitch that must not turn floor into obstacles [rad]."""
    depth_noise: float = 0.003
    """Standard deviation of depth over the square of the range (D435i) [1/m]."""
    edge_step: float = 0.05
    """Relative step of depth to a neighbour from which a pixel is a flying pixel."""
    min_points: int = 3
    """Least number of pixels for an obstacle in a polar cell, or for a drop in four cells."""
    drop_depth: float = 0.08
    """Depth below the floor from which points are seen through a hole in it, as down stairs [m]."""
    drop_range: float = 2.0
    """Largest distance of a drop that is used: pitch errs, and shiny floors mirror the room [m]."""


class DepthMapperConfig(BaseModel):
    """Cells of the obstacle map, and how fast evidence changes them."""

    model_config = SETTINGS

    scan: ScanConfig = ScanConfig()
    """How a depth image is read."""
    resolution: float = Field(default=0.05, ge=0.01, le=0.5)
    """Edge of a cell [m] (paper, common settings)."""
    obstacle_odds: float = 0.6
    """Log odds that one near view of an obstacle adds to its cell; far ones add less."""
    floor_odds: float = -0.4
    """Log odds that one view of the floor adds to its cell."""
    drop_odds: float = 0.4
    """Log odds that one view of a drop adds: the robot avoids stairs as it avoids a wall."""
    passed_odds: float = -0.12
    """Log odds that rays which pass over a cell add to it."""
    min_odds: float = -1.6
    """Least log odds of a cell, so that an obstacle can appear within some frames."""
    max_odds: float = 3.5
    """Largest log odds of a cell, so that a vanished obstacle is cleared within some frames."""
    rebuild_distance: float = 0.025
    """Motion of a keyframe from which its scans are painted again [m]."""
    rebuild_angle: float = 0.0087
    """Turn of a keyframe from which its scans are painted again [rad]."""
    place_size: float = Field(default=0.05, gt=0.0)
    """Distance within which scans or footprints of one keyframe replace each other [m]."""
    place_angle: float = Field(default=0.05, gt=0.0)
    """Angle within which scans at one place replace each other [rad]."""
