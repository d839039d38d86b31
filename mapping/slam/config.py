"""Settings of pose estimation."""

from __future__ import annotations

from pydantic import BaseModel, Field

from mapping.keyframes.config import KeyframeConfig, PlaceIndexConfig, PoseGraphConfig
from mapping.odometry.config import DeadReckoningConfig, FeatureConfig, GatingConfig, OdometryConfig
from mapping.relocalisation.config import (
    DepthConsistencyConfig,
    KidnappingConfig,
    RelocalisationConfig,
)
from vizbot.core.settings import SETTINGS


class SlamConfig(BaseModel):
    """Pose estimation."""

    model_config = SETTINGS
    features: FeatureConfig = FeatureConfig()
    """Detection and matching of corners."""
    odometry: OdometryConfig = OdometryConfig()
    """Poses from matched corners."""
    keyframes: KeyframeConfig = KeyframeConfig()
    """Choice of keyframes and of their links."""
    graph: PoseGraphConfig = PoseGraphConfig()
    """Noise of images, wheels, gyroscope and floor in the pose graph."""
    gates: GatingConfig = GatingConfig()
    """Which motions by images are believed."""
    dead_reckoning: DeadReckoningConfig = DeadReckoningConfig()
    """Dead reckoning by wheels and gyroscope."""
    places: PlaceIndexConfig = PlaceIndexConfig()
    """The index by which places are recognised."""
    solid: DepthConsistencyConfig = DepthConsistencyConfig()
    """When depth decides for or against a pose."""
    kidnapping: KidnappingConfig = KidnappingConfig()
    """When the robot counts as carried away."""
    relocalisation: RelocalisationConfig = RelocalisationConfig()
    """When a lost robot counts as relocalised."""
    search: float = Field(default=0.07, ge=0.005, le=1.0)
    """Radius of the search around a predicted corner, as a fraction of the image's width [1]."""
    wide_search: float = Field(default=0.5, ge=0.005, le=1.0)
    """The same radius where the motion was not as predicted [1]."""
    closure_search: float = Field(default=0.2, ge=0.005, le=1.0)
    """The same radius where a loop may close, after some drift [1]."""
    nearby_tries: int = Field(default=3, ge=0, le=100)
    """Number of other keyframes that a frame is compared with when the last one does not match
    [1]."""
