"""Settings of pose estimation."""

from __future__ import annotations

from pydantic import Field

from mapping.keyframes.config import KeyframeConfig, PlaceIndexConfig, PoseGraphConfig
from mapping.odometry.config import DeadReckoningConfig, FeatureConfig, GatingConfig, OdometryConfig
from mapping.relocalisation.config import (
    DepthConsistencyConfig,
    KidnappingConfig,
    RelocalisationConfig,
)
from vizbot.core.settings import Settings


class SlamConfig(Settings):
    """Pose estimation."""

    features: FeatureConfig = FeatureConfig()
    """These settings say how corners are detected and matched."""
    odometry: OdometryConfig = OdometryConfig()
    """These settings say when matched corners give a pose."""
    keyframes: KeyframeConfig = KeyframeConfig()
    """These settings say which frames become keyframes, and how they are linked."""
    graph: PoseGraphConfig = PoseGraphConfig()
    """These settings are the noise of images, wheels, gyroscope and floor in the pose graph."""
    gates: GatingConfig = GatingConfig()
    """These settings say which motions by images are believed."""
    dead_reckoning: DeadReckoningConfig = DeadReckoningConfig()
    """These settings say how wheels and gyroscope are used."""
    place_index: PlaceIndexConfig = PlaceIndexConfig()
    """These settings say how places are indexed to be recognised."""
    depth_consistency: DepthConsistencyConfig = DepthConsistencyConfig()
    """These settings say when depth decides for or against a pose."""
    kidnapping: KidnappingConfig = KidnappingConfig()
    """These settings say when the robot counts as carried away."""
    relocalisation: RelocalisationConfig = RelocalisationConfig()
    """These settings say when a lost robot counts as relocalised."""
    search_radius: float = Field(default=0.07, ge=0.005, le=1.0)
    """A predicted corner is looked for within this share of the image's width [1]."""
    wide_search_radius: float = Field(default=0.5, ge=0.005, le=1.0)
    """After an unexpected motion corners are looked for within this share of the width [1]."""
    closure_search_radius: float = Field(default=0.2, ge=0.005, le=1.0)
    """Where a loop may close, corners are looked for within this share of the image's width [1]."""
    nearby_tries: int = Field(default=3, ge=0, le=100)
    """A frame that does not match the last keyframe is compared with this number of other ones
    [1]."""
