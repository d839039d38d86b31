"""Settings of keyframes, their index and their pose graph."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class KeyframeConfig(BaseModel):
    """Distances between keyframes, and between two that may see the same place."""

    model_config = SETTINGS
    distance: float = 0.25
    """Distance from the last keyframe at which a frame becomes the next one [m]."""
    angle: float = 0.25
    """Turn from the last keyframe at which a frame becomes the next one [rad]."""
    inliers: int = 60
    """A frame with fewer agreeing matches becomes a keyframe, if it also falls below
    `inlier_share`."""
    inlier_share: float = 0.3
    """Share of the keyframe's corners that must agree where fewer than `inliers` do; it spares bare
    rooms new keyframes."""
    blank_distance: float = 0.5
    """In the dark, distance from the last keyframe and from all blank ones at which a frame becomes
    the next one [m]."""
    links: int = 5
    """Number of preceding keyframes that a new keyframe is measured against."""
    closure_distance: float = 1.5
    """Distance beyond which two cameras are taken to see no common place [m]."""
    closure_angle: float = 0.7
    """Angle beyond which two cameras are taken to see no common place [rad]."""
    closures: int = 4
    """Number of loop closures tried per keyframe."""


class PlaceIndexConfig(BaseModel):
    """How descriptors are hashed to words."""

    model_config = SETTINGS

    tables: int = Field(default=8, gt=0)
    """Number of hash tables. Two descriptors with a tenth of their bits flipped share a word in
    four of five cases with 8 tables of 16 bits."""
    bits: int = Field(default=16, gt=0, le=20)
    """Number of bits of a word."""


class PoseGraphConfig(BaseModel):
    """Noise of each source of motion."""

    model_config = SETTINGS
    image_rotation_sigma: float = 0.003
    """Least standard deviation of a rotation between keyframes by images [rad]."""
    image_translation_sigma: float = 0.008
    """Least standard deviation of a translation between keyframes by images [m]."""
    image_kernel: float = 2.0
    """Whitened error at which a motion by images starts to lose weight (Cauchy)."""
    closure_limit: float = 12.0
    """Whitened error at which a closed loop is taken for a mistake and removed."""
    wheel_rotation_sigma: float = 0.01
    """Standard deviation of a turn by wheels, however short [rad]."""
    wheel_translation_sigma: float = 0.01
    """Standard deviation of a distance by wheels, however short [m]."""
    wheel_slip: float = 0.1
    """Standard deviation of wheels as a fraction of distance and of angle."""
    wheel_kernel: float = 1.5
    """Whitened error at which wheels, which may spin, start to lose weight (Cauchy)."""
    gyro_kernel: float = 3.0
    """Whitened error at which the gyroscope starts to lose weight (Cauchy)."""
    floor_tilt_sigma: float = 0.01
    """Standard deviation of roll and pitch of the base: how level the floor is [rad]."""
    floor_height_sigma: float = 0.02
    """Standard deviation of the height of the base: how flat the floor is [m]."""
