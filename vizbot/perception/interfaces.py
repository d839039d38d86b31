"""What perception asks of those who say where frames were taken and where the robot can drive."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.anchors import KeyframeViews
from vizbot.core.types import SE3, Intrinsics, OccupancyGrid, PoseEstimate, RGBDFrame


class PoseEstimator(Protocol):
    """Says where frames were taken, as `mapping.slam.slam.Slam` does."""

    def track(self, frame: RGBDFrame, T_odom_base: SE3 | None) -> PoseEstimate:
        """Where `frame` was taken; it is newer than any before."""
        ...

    def lift(self, stamp: float) -> PoseEstimate:
        """The robot hangs in the air when a frame is taken, which is not the first."""
        ...

    def keyframe_poses(self) -> dict[int, SE3]:
        """T_map_cam of every keyframe by its id, as known now."""
        ...

    @property
    def closures(self) -> list[tuple[int, int]]:
        """Pairs of keyframes between which a loop is closed."""
        ...

    def views(self) -> KeyframeViews:
        """What the keyframes show, to be kept with their poses."""
        ...


class ObstacleMapper(Protocol):
    """Says where the robot can drive, as `mapping.occupancy.depth_mapper.DepthMapper` does."""

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

    def mark_obstacle(self, T_map_base: SE3, points: NDArray[np.float64]) -> None:
        """Keep obstacles that the robot felt at `points` (N, 2) x, y in `base` [m]."""
        ...

    def mark_free(self, T_map_base: SE3, radius: float) -> None:
        """The floor within `radius` [m] of the robot's centre is free."""
        ...

    def follow(self, keyframe_poses: dict[int, SE3]) -> bool:
        """Move with the graph; whether anything changed."""
        ...

    def grid(self) -> OccupancyGrid:
        """The obstacle map now."""
        ...
