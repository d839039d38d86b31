"""Settings of relocalisation."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class DepthConsistencyConfig(BaseModel):
    """How many corners decide for or against a pose."""

    model_config = SETTINGS

    corners: int = Field(default=20, gt=0)
    """Least number of corners above the floor that must agree, to decide for or against a pose."""
    share: float = Field(default=0.5, gt=0.0)
    """Least share of the corners above the floor that must agree, likewise."""


class KidnappingConfig(BaseModel):
    """When a robot counts as carried away, and so as lost."""

    model_config = SETTINGS

    corners: int = Field(default=80, gt=0)
    """Number of corners from which an image shows plenty."""
    broken: int = Field(default=250, gt=0)
    """Number of corners of one frame that should be in view in the next for a break: none is, and
    depth differs there."""
    patience: int = Field(default=2, gt=0)
    """Number of frames in a row that show plenty, but not what they should, until the robot is
    lost; somebody who walks by is in view for fewer."""
    patience_in_place: int = Field(default=8, gt=0)
    """Number of such frames until the robot is lost where depth confirms the pose, or did at the
    break: blur and plain walls match nothing."""


class ScanMatchConfig(BaseModel):
    """How a local grid is compared with a map."""

    model_config = SETTINGS

    cell: float = Field(default=0.1, gt=0.0)
    """Spacing of the lattice of poses [m]."""
    angle: float = Field(default=0.05, gt=0.0)
    """Angular spacing of the lattice [rad]; the best pose is then refined to the map's cells."""
    sigma: float = Field(default=0.1, gt=0.0)
    """Standard deviation of obstacles from those of the map at the right pose [m]."""
    in_free: float = Field(default=0.3, ge=0.0)
    """Penalty of an obstacle in free space, as a fraction of the reward of one on an obstacle."""
    on_obstacle: float = Field(default=0.4, ge=0.0)
    """Penalty of a free cell on an obstacle of the map, as a fraction of the same reward."""
    apart: float = Field(default=0.6, gt=0.0)
    """Distance from which two poses count as different [m]."""
    turned: float = Field(default=0.45, gt=0.0)
    """Angle from which two poses count as different [rad]."""
    least: int = Field(default=20, gt=0)
    """Least number of obstacle cells on known cells of the map, to judge a pose."""


class LocalMapConfig(BaseModel):
    """When obstacles relocalise the robot."""

    model_config = SETTINGS

    match: ScanMatchConfig = ScanMatchConfig()
    """How obstacles are compared."""
    reach: float = Field(default=2.0, gt=0.0)
    """Distance after which the local map starts anew, since dead reckoning drifts [m]."""
    turn: float = Field(default=1.0, gt=0.0)
    """Turn after which obstacles are compared with the whole map again [rad]."""
    agreement: float = Field(default=0.7, gt=0.0)
    """Least agreement of a pose."""
    rival: float = Field(default=0.75, gt=0.0)
    """Most agreement of any other pose, as a share of the best one's, unless images confirm it."""
    repeats: int = Field(default=3, gt=0)
    """Number of times in a row that a pose must be the best for `repeated_rival` to hold."""
    repeated_rival: float = Field(default=0.85, gt=0.0)
    """As `rival`, for a pose that was the best `repeats` times: along a wall a step aside fits
    nearly as well."""
    same: float = Field(default=0.3, gt=0.0)
    """Distance within which two poses count as the same [m, rad]."""
    contradiction: float = Field(default=0.6, gt=0.0)
    """Agreement below which a pose by images is rejected."""
    translation_sigma: float = Field(default=0.05, gt=0.0)
    """Standard deviation of the position of a pose by obstacles [m]."""
    rotation_sigma: float = Field(default=0.03, gt=0.0)
    """Standard deviation of the angle of a pose by obstacles [rad]."""


class RelocalisationConfig(BaseModel):
    """When a lost robot counts as relocalised."""

    model_config = SETTINGS

    candidates: int = Field(default=5, gt=0)
    """Number of keyframes that look most like a frame and are compared with it."""
    inliers: int = Field(default=40, gt=0)
    """Least number of matches that agree on a pose."""
    inlier_fraction: float = Field(default=0.5, gt=0.0)
    """Least share of all matches that agree on a pose."""
    shown: float = Field(default=0.1, gt=0.0)
    """Least share of matches that agree among the corners that both images should show."""
    above_floor: float = Field(default=0.03, gt=0.0)
    """Radius of the search for the same pose by corners above the floor alone, as a fraction of the
    image's width; it must succeed, since boards and tiles repeat."""
    alone: int = Field(default=120, gt=0)
    """Number of agreeing matches from which a single frame is believed, unless it looks like
    another place as well or an earlier frame led elsewhere. With fewer, more earlier frames must
    have led to the same place than elsewhere."""
    agreement: float = Field(default=0.15, gt=0.0)
    """Distance within which an earlier frame leads to the same place [m, rad]."""
    aside: float = Field(default=0.35, gt=0.0)
    """Least turn, by dead reckoning, between the frame and one of those earlier frames, so that
    they show different things: there is more than one window with the same view [rad]."""
    guesses: int = Field(default=50, gt=0)
    """Number of earlier frames whose places are remembered, the newest ones: a robot may stand lost
    for hours."""
    beside: float = Field(default=0.3, gt=0.0)
    """Distance within which images confirm a pose by obstacles [m, rad]."""
