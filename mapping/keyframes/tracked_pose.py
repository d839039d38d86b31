"""Where the newest frame was taken: in which keyframe, and where by dead reckoning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class TrackedPose:
    """The pose of the newest frame, relative to a keyframe.

    Only `Slam` replaces it. Searches and loop closing read it and return a `KeyframeMatch`.

    Attributes:
        reference: Id of the keyframe that frames are measured in.
        T_reference_cam: The camera in that keyframe.
        dead_reckoned: Dead reckoning at the newest frame; None without wheels.
    """

    reference: int = 0
    T_reference_cam: SE3 = field(default_factory=lambda: np.eye(4))
    dead_reckoned: DeadReckonedPose | None = None

    def in_map(self, keyframe_poses: Mapping[int, SE3]) -> SE3:
        """T_map_cam, given T_map_cam of the keyframes by id."""
        return keyframe_poses[self.reference] @ self.T_reference_cam


@dataclass(frozen=True, slots=True, eq=False)
class KeyframeMatch:
    """A keyframe in which a frame was found.

    Attributes:
        keyframe: Id of the keyframe.
        pose: The frame's camera in it.
    """

    keyframe: int
    pose: RelativePose
