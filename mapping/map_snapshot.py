"""A snapshot of a growing map: the robot's loop takes it at once, another thread joins it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.fitted.calibration import EncoderCalibration
from mapping.clip.mapped_frames import MappedFrames
from mapping.clip.mapper import ClipElements
from mapping.clip.places.place_rows import PlaceRows
from mapping.keyframes.anchors import Cloud, Keyframes, KeyframeViews, Trajectory
from mapping.map_bundle import MapBundle
from vizbot.core.types import SE3, Intrinsics, OccupancyGrid

if TYPE_CHECKING:  # its module loads OpenCV and numba
    from mapping.odometry.features import Features


@dataclass(frozen=True, slots=True, eq=False)
class MapSnapshot:
    """What a map is at one moment, whatever becomes of it later.

    Attributes that `MapBundle` has mean the same here.

    Attributes:
        keyframe_poses: T_map_cam of every keyframe by its id.
        keyframe_stamps: When their frames were taken [s].
        features: What every keyframe shows.
    """

    model_id: str
    intrinsics: Intrinsics
    T_base_cam: SE3
    keyframe_poses: Mapping[int, SE3]
    keyframe_stamps: Mapping[int, float]
    features: Mapping[int, Features]
    elements: ClipElements
    statistics: NDArray[np.float32]
    pictures: NDArray[np.float32]
    places: PlaceRows
    frames: MappedFrames
    grid: OccupancyGrid
    cloud: Cloud
    trajectory: Trajectory
    notice: str | None
    keep_out: tuple[NDArray[np.float32], ...] = ()
    calibration: EncoderCalibration | None = None
    created: datetime = field(default_factory=lambda: datetime.now(UTC))

    def bundle(self) -> MapBundle:
        """Everything worth saving. Joining takes long on a large map: keep it out of the loop."""
        joined = ("keyframe_poses", "keyframe_stamps", "features")
        kept = {each.name: getattr(self, each.name) for each in fields(self)}
        return MapBundle(
            keyframes=Keyframes.with_poses(self.keyframe_poses, self.keyframe_stamps),
            views=KeyframeViews.with_features(self.features),
            **{name: value for name, value in kept.items() if name not in joined},
        )
