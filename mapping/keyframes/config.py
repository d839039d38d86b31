"""Settings of keyframes, their index and their pose graph."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class KeyframeConfig(BaseModel):
    """Distances between keyframes, and between two that may see the same place."""

    model_config = SETTINGS
    distance: float = Field(default=0.25, ge=0.01, le=5.0)
    """Distance from the last keyframe at which a frame becomes the next one [m]."""
    angle: float = Field(default=0.25, ge=0.01, le=3.2)
    """Turn from the last keyframe at which a frame becomes the next one [rad]."""
    inliers: int = Field(default=60, ge=1, le=10000)
    """A frame with fewer agreeing matches becomes a keyframe, if it also falls below `inlier_share`
    [1]."""
    inlier_share: float = Field(default=0.3, ge=0.0, le=1.0)
    """Share of the keyframe's corners that must agree where fewer than `inliers` do [1]; it spares
    bare rooms new keyframes."""
    blank_distance: float = Field(default=0.5, ge=0.01, le=10.0)
    """In the dark, distance from the last keyframe and from all blank ones at which a frame becomes
    the next one [m]."""
    links: int = Field(default=5, ge=1, le=100)
    """Number of preceding keyframes that a new keyframe is measured against [1]."""
    closure_distance: float = Field(default=1.5, ge=0.0, le=50.0)
    """Distance beyond which two cameras are taken to see no common place [m]."""
    closure_angle: float = Field(default=0.7, ge=0.0, le=3.2)
    """Angle beyond which two cameras are taken to see no common place [rad]."""
    closures: int = Field(default=4, ge=0, le=100)
    """Number of loop closures tried per keyframe [1]."""


class PlaceIndexConfig(BaseModel):
    """How descriptors are hashed to words."""

    model_config = SETTINGS

    tables: int = Field(default=8, ge=1, le=64)
    """Number of hash tables [1]. Two descriptors with a tenth of their bits flipped share a word in
    four of five cases with 8 tables of 16 bits."""
    bits: int = Field(default=16, ge=1, le=20)
    """Number of bits of a word [1]."""


class PoseGraphConfig(BaseModel):
    """Noise of each source of motion."""

    model_config = SETTINGS
    image_rotation_sigma: float = Field(default=0.003, ge=1e-5, le=1.0)
    """Least standard deviation of a rotation between keyframes by images [rad]."""
    image_translation_sigma: float = Field(default=0.008, ge=1e-5, le=1.0)
    """Least standard deviation of a translation between keyframes by images [m]."""
    image_kernel: float = Field(default=2.0, ge=0.1, le=100.0)
    """Whitened error at which a motion by images starts to lose weight (Cauchy) [1]."""
    closure_limit: float = Field(default=12.0, ge=1.0, le=1000.0)
    """Whitened error at which a closed loop is taken for a mistake and removed [1]."""
    wheel_rotation_sigma: float = Field(default=0.01, ge=1e-5, le=1.0)
    """Standard deviation of a turn by wheels, however short [rad]."""
    wheel_translation_sigma: float = Field(default=0.01, ge=1e-5, le=1.0)
    """Standard deviation of a distance by wheels, however short [m]."""
    wheel_slip: float = Field(default=0.1, ge=0.0, le=2.0)
    """Standard deviation of wheels as a fraction of distance and of angle [1]."""
    wheel_kernel: float = Field(default=1.5, ge=0.1, le=100.0)
    """Whitened error at which wheels, which may spin, start to lose weight (Cauchy) [1]."""
    gyro_kernel: float = Field(default=3.0, ge=0.1, le=100.0)
    """Whitened error at which the gyroscope starts to lose weight (Cauchy) [1]."""
    floor_tilt_sigma: float = Field(default=0.01, ge=1e-5, le=1.0)
    """Standard deviation of roll and pitch of the base: how level the floor is [rad]."""
    floor_height_sigma: float = Field(default=0.02, ge=1e-5, le=1.0)
    """Standard deviation of the height of the base: how flat the floor is [m]."""
