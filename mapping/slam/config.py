"""Settings of pose estimation."""

from __future__ import annotations

from pydantic import BaseModel

from mapping.keyframes.place_index import PlaceIndexConfig
from mapping.keyframes.pose_graph import PoseGraphConfig
from mapping.keyframes.selection import KeyframeConfig
from mapping.odometry.dead_reckoning import DeadReckoningConfig
from mapping.odometry.features import FeatureConfig
from mapping.odometry.gating import GatingConfig
from mapping.odometry.rgbd_odometry import OdometryConfig
from mapping.relocalisation.depth_consistency import DepthConsistencyConfig
from mapping.relocalisation.kidnapping import KidnappingConfig
from mapping.relocalisation.relocaliser import RelocalisationConfig
from vizbot.core.settings import SETTINGS


class SlamConfig(BaseModel):
    """Pose estimation."""

    model_config = SETTINGS
    features: FeatureConfig = FeatureConfig()
    """Corners and their matching."""
    odometry: OdometryConfig = OdometryConfig()
    """Poses from matches."""
    keyframes: KeyframeConfig = KeyframeConfig()
    """Choice of keyframes and of what they are linked to."""
    graph: PoseGraphConfig = PoseGraphConfig()
    """Trust in images, wheels and floor."""
    gates: GatingConfig = GatingConfig()
    """What images are believed."""
    dead_reckoning: DeadReckoningConfig = DeadReckoningConfig()
    """Turns between frames."""
    places: PlaceIndexConfig = PlaceIndexConfig()
    """Words by which places are recognised."""
    solid: DepthConsistencyConfig = DepthConsistencyConfig()
    """When depth speaks for or against a place."""
    kidnapping: KidnappingConfig = KidnappingConfig()
    """When the robot is lost."""
    relocalisation: RelocalisationConfig = RelocalisationConfig()
    """When a lost robot knows again where it is."""
    search: float = 0.07
    """Radius of the search around a predicted corner, as a fraction of the image's width."""
    wide_search: float = 0.5
    """The same where the motion was not as predicted."""
    closure_search: float = 0.2
    """The same where a loop may close, after some drift."""
    nearby_tries: int = 3
    """Other keyframes a frame is compared with when the last one does not match."""
