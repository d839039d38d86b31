"""Settings of relocalisation."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class DepthConsistencyConfig(BaseModel):
    """How many corners decide for or against a pose."""

    model_config = SETTINGS

    corners: int = Field(default=20, ge=1, le=10000)
    """Least number of corners above the floor that must agree, to decide for or against a pose
    [1]."""
    share: float = Field(default=0.5, ge=0.01, le=1.0)
    """Least share of the corners above the floor that must agree, likewise [1]."""


class KidnappingConfig(BaseModel):
    """When a robot counts as carried away, and so as lost."""

    model_config = SETTINGS

    corners: int = Field(default=80, ge=1, le=10000)
    """Number of corners from which an image shows plenty [1]."""
    broken: int = Field(default=250, ge=1, le=10000)
    """Number of corners of one frame that should be in view in the next for a break [1]: none is,
    and depth differs there."""
    patience: int = Field(default=2, ge=1, le=1000)
    """Number of frames in a row that show plenty, but not what they should, until the robot is lost
    [1]; somebody who walks by is in view for fewer."""
    patience_in_place: int = Field(default=8, ge=1, le=1000)
    """Number of such frames until the robot is lost where depth confirms the pose, or did at the
    break [1]: blur and plain walls match nothing."""


class ScanMatchConfig(BaseModel):
    """How a local grid is compared with a map."""

    model_config = SETTINGS

    cell: float = Field(default=0.1, ge=0.01, le=1.0)
    """Spacing of the lattice of poses [m]."""
    angle: float = Field(default=0.05, ge=0.005, le=1.6)
    """Angular spacing of the lattice [rad]; the best pose is then refined to the map's cells."""
    sigma: float = Field(default=0.1, ge=0.01, le=2.0)
    """Standard deviation of obstacles from those of the map at the right pose [m]."""
    in_free: float = Field(default=0.3, ge=0.0, le=10.0)
    """Penalty of an obstacle in free space, as a fraction of the reward of one on an obstacle
    [1]."""
    on_obstacle: float = Field(default=0.4, ge=0.0, le=10.0)
    """Penalty of a free cell on an obstacle of the map, as a fraction of the same reward [1]."""
    apart: float = Field(default=0.6, ge=0.01, le=20.0)
    """Distance from which two poses count as different [m]."""
    turned: float = Field(default=0.45, ge=0.01, le=3.2)
    """Angle from which two poses count as different [rad]."""
    least: int = Field(default=20, ge=1, le=100000)
    """Least number of obstacle cells on known cells of the map, to judge a pose [1]."""


class LocalMapConfig(BaseModel):
    """When obstacles relocalise the robot."""

    model_config = SETTINGS

    match: ScanMatchConfig = ScanMatchConfig()
    """How obstacles are compared."""
    reach: float = Field(default=2.0, ge=0.1, le=100.0)
    """Distance after which the local map starts anew, since dead reckoning drifts [m]."""
    turn: float = Field(default=1.0, ge=0.05, le=6.3)
    """Turn after which obstacles are compared with the whole map again [rad]."""
    agreement: float = Field(default=0.7, ge=0.01, le=1.0)
    """Least agreement of a pose [1]."""
    rival: float = Field(default=0.75, ge=0.01, le=1.0)
    """Most agreement of any other pose, as a share of the best one's, unless images confirm it
    [1]."""
    repeats: int = Field(default=3, ge=1, le=1000)
    """Number of times in a row that a pose must be the best for `repeated_rival` to hold [1]."""
    repeated_rival: float = Field(default=0.85, ge=0.01, le=1.0)
    """As `rival`, for a pose that was the best `repeats` times [1]: along a wall a step aside fits
    nearly as well."""
    same: float = Field(default=0.3, ge=0.01, le=10.0)
    """Distance within which two poses count as the same [m, rad]."""
    contradiction: float = Field(default=0.6, ge=0.01, le=1.0)
    """Agreement below which a pose by images is rejected [1]."""
    translation_sigma: float = Field(default=0.05, ge=0.001, le=2.0)
    """Standard deviation of the position of a pose by obstacles [m]."""
    rotation_sigma: float = Field(default=0.03, ge=0.001, le=1.6)
    """Standard deviation of the angle of a pose by obstacles [rad]."""


class RelocalisationConfig(BaseModel):
    """When a lost robot counts as relocalised."""

    model_config = SETTINGS

    candidates: int = Field(default=5, ge=1, le=1000)
    """Number of keyframes that look most like a frame and are compared with it [1]."""
    inliers: int = Field(default=40, ge=1, le=10000)
    """Least number of matches that agree on a pose [1]."""
    inlier_fraction: float = Field(default=0.5, ge=0.01, le=1.0)
    """Least share of all matches that agree on a pose [1]."""
    shown: float = Field(default=0.1, ge=0.001, le=1.0)
    """Least share of matches that agree among the corners that both images should show [1]."""
    above_floor: float = Field(default=0.03, ge=0.001, le=1.0)
    """Radius of the search for the same pose by corners above the floor alone, as a fraction of the
    image's width [1]; it must succeed, since boards and tiles repeat."""
    alone: int = Field(default=120, ge=1, le=100000)
    """Number of agreeing matches from which a single frame is believed, unless it looks like
    another place as well or an earlier frame led elsewhere [1]. With fewer, more earlier frames
    must have led to the same place than elsewhere."""
    agreement: float = Field(default=0.15, ge=0.0, le=10.0)
    """Distance within which an earlier frame leads to the same place [m, rad]."""
    aside: float = Field(default=0.35, ge=0.0, le=3.2)
    """Least turn, by dead reckoning, between the frame and one of those earlier frames, so that
    they show different things: there is more than one window with the same view [rad]."""
    guesses: int = Field(default=50, ge=1, le=100000)
    """Number of earlier frames whose places are remembered, the newest ones [1]: a robot may stand
    lost for hours."""
    beside: float = Field(default=0.3, ge=0.01, le=10.0)
    """Distance within which images confirm a pose by obstacles [m, rad]."""
