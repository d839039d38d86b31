"""Settings of keyframes, their index and their pose graph."""

from __future__ import annotations

from pydantic import Field

from vizbot.core.settings import Settings


class KeyframeConfig(Settings):
    """Distances between keyframes, and between two that may see the same place."""

    distance: float = Field(default=0.25, ge=0.01, le=5.0)
    """A frame this far from the last keyframe becomes the next one [m]."""
    angle: float = Field(default=0.25, ge=0.01, le=3.2)
    """A frame that is turned by this from the last keyframe becomes the next one [rad]."""
    inliers: int = Field(default=60, ge=1, le=10000)
    """A frame with fewer agreeing matches than this becomes a keyframe, if it also falls below
    `inlier_share` [1]."""
    inlier_share: float = Field(default=0.3, ge=0.0, le=1.0)
    """A frame with fewer than `inliers` agreeing matches becomes a keyframe where these are less
    than this share of the keyframe's corners, which spares bare rooms new keyframes [1]."""
    blank_distance: float = Field(default=0.5, ge=0.01, le=10.0)
    """In the dark, a frame this far from the last keyframe and from all blank ones becomes the next
    one [m]."""
    links: int = Field(default=5, ge=1, le=100)
    """A new keyframe is measured against this number of preceding ones [1]."""
    closure_distance: float = Field(default=1.5, ge=0.0, le=50.0)
    """Two cameras farther apart than this are taken to see no common place [m]."""
    closure_angle: float = Field(default=0.7, ge=0.0, le=3.2)
    """Two cameras turned by more than this are taken to see no common place [rad]."""
    closures: int = Field(default=4, ge=0, le=100)
    """This number of loop closures is tried for each keyframe [1]."""


class PlaceIndexConfig(Settings):
    """How descriptors are hashed to words."""

    tables: int = Field(default=8, ge=1, le=64)
    """The index has this number of hash tables; two descriptors with a tenth of their bits flipped
    share a word in four of five cases with 8 tables of 16 bits [1]."""
    bits: int = Field(default=16, ge=1, le=20)
    """A word of the index has this number of bits [1]."""


class PoseGraphConfig(Settings):
    """Noise of each source of motion."""

    image_rotation_sigma: float = Field(default=0.003, ge=1e-5, le=1.0)
    """A rotation between keyframes by images has at least this standard deviation [rad]."""
    image_translation_sigma: float = Field(default=0.008, ge=1e-5, le=1.0)
    """A translation between keyframes by images has at least this standard deviation [m]."""
    image_kernel: float = Field(default=2.0, ge=0.1, le=100.0)
    """A motion by images starts to lose weight (Cauchy) at this whitened error [1]."""
    closure_limit: float = Field(default=12.0, ge=1.0, le=1000.0)
    """A closed loop is taken for a mistake and removed at this whitened error [1]."""
    wheel_rotation_sigma: float = Field(default=0.01, ge=1e-5, le=1.0)
    """A turn by wheels, however short, has this standard deviation [rad]."""
    wheel_translation_sigma: float = Field(default=0.01, ge=1e-5, le=1.0)
    """A distance by wheels, however short, has this standard deviation [m]."""
    wheel_slip: float = Field(default=0.1, ge=0.0, le=2.0)
    """The standard deviation of wheels grows by this fraction of distance and of angle [1]."""
    wheel_kernel: float = Field(default=1.5, ge=0.1, le=100.0)
    """Wheels, which may spin, start to lose weight (Cauchy) at this whitened error [1]."""
    gyro_kernel: float = Field(default=3.0, ge=0.1, le=100.0)
    """The gyroscope starts to lose weight (Cauchy) at this whitened error [1]."""
    floor_tilt_sigma: float = Field(default=0.01, ge=1e-5, le=1.0)
    """Roll and pitch of the base have this standard deviation, as the floor is level [rad]."""
    floor_height_sigma: float = Field(default=0.02, ge=1e-5, le=1.0)
    """The height of the base has this standard deviation, which is how flat the floor is [m]."""
