"""Protocols of the pose estimator and the obstacle mapper that perception works with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mapping.clip.patches import NEAR_MEDIAN
from mapping.clip.scores import Background
from mapping.odometry.features import Features
from vizbot.core.types import SE3, Intrinsics, OccupancyGrid, PoseEstimate, RGBDFrame


class PoseEstimator(Protocol):
    """Estimates where frames were taken, as `mapping.slam.slam.Slam` does."""

    def track(self, frame: RGBDFrame, T_odom_base: SE3 | None) -> PoseEstimate:
        """Estimate where `frame` was taken, which is newer than all before it."""
        ...

    def lift(self, stamp: float) -> PoseEstimate:
        """Estimate for a frame, not the first, that was taken while the robot hung in the air."""
        ...

    def keyframe_poses(self) -> dict[int, SE3]:
        """T_map_cam of every keyframe by its id, as known now."""
        ...

    @property
    def closures(self) -> list[tuple[int, int]]:
        """Pairs of keyframes between which a loop is closed."""
        ...

    def features(self) -> dict[int, Features]:
        """What every keyframe shows, by its id, to be saved with their poses; not changed later."""
        ...


class ObstacleMapper(Protocol):
    """Maps where the robot can drive, as `mapping.occupancy.depth_mapper.DepthMapper` does."""

    def integrate(
        self,
        keyframe: int,
        T_keyframe_cam: SE3,
        T_map_cam: SE3,
        depth: NDArray[np.float32],
        intrinsics: Intrinsics,
    ) -> None:
        """Add a depth image (H, W) [m], taken at `T_map_cam` and anchored to `keyframe`."""
        ...

    def mark_obstacle(
        self, T_map_base: SE3, points: NDArray[np.float64], *, touched: bool = False
    ) -> None:
        """Add obstacles at `points` (N, 2) x, y in `base` [m], which may only have been touched."""
        ...

    def infer_obstacle(self, T_map_base: SE3, points: NDArray[np.float64]) -> None:
        """Mark obstacles at `points` (N, 2) x, y in `base` [m] until depth shows floor there."""
        ...

    def forget_touched(self) -> bool:
        """Forget the obstacles that were only touched; return whether there were any."""
        ...

    def mark_free(self, T_map_base: SE3, radius: float) -> None:
        """Mark the floor within `radius` [m] of the robot's centre as free."""
        ...

    def follow(self, keyframe_poses: dict[int, SE3]) -> bool:
        """Move the map with the pose graph; return whether anything changed."""
        ...

    def grid(self) -> OccupancyGrid:
        """The present obstacle map."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class PerceptionParts:
    """Parts that replace the built-in ones; None keeps the built-in one.

    Attributes:
        slam: Instead of `mapping.slam.slam.Slam`; its `map` begins where the base stands.
        depth_mapper: Instead of `mapping.occupancy.depth_mapper.DepthMapper`.
        background: Embeds the background phrases, or returns them where it has done so before.
        patch_spreads: Which pixels give a patch its point, as of `patches.patch_points`.
        every_pose: Whether the pose of every frame is kept, as of a recording, instead of those
            between which the camera moved.
        every_picture: Whether every picture is mapped, as the paper does, instead of one a view.
    """

    slam: PoseEstimator | None = None
    depth_mapper: ObstacleMapper | None = None
    background: Callable[[], Background] | None = None
    patch_spreads: float = NEAR_MEDIAN
    every_pose: bool = False
    every_picture: bool = False
