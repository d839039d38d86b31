"""A frame on its way through pose estimation, and what is stored of it as a keyframe."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.features import NO_FEATURES, Features
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.types import SE3, RGBDFrame, Tracking


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """What is known of the newest frame; each step hands on a copy that knows more.

    Attributes:
        dead_reckoned: Dead reckoning at it; None without wheels.
        T_last_cam: Motion of the camera since the frame before: as predicted until the frame is
            located, then as estimated.
        wheel_only: (2,) distance and turn since images were last believed [m, rad]; None without
            wheels.
        reference: Id of the keyframe that it is measured in.
        T_reference_cam: The camera in that keyframe; that of the frame before until it is located.
        predicted: The same as predicted.
        measured: The same by images; None where they did not give it.
        tracking: What the pose rests on; that of the frame before until it is located.
    """

    image: RGBDFrame
    features: Features = NO_FEATURES
    dead_reckoned: DeadReckonedPose | None = None
    T_last_cam: SE3 = field(default_factory=lambda: np.eye(4))
    wheel_only: NDArray[np.float64] | None = None
    reference: int = 0
    T_reference_cam: SE3 = field(default_factory=lambda: np.eye(4))
    predicted: SE3 = field(default_factory=lambda: np.eye(4))
    measured: RelativePose | None = None
    tracking: Tracking = Tracking.TRACKING


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """What is stored of a frame to measure others against.

    Attributes:
        features: Its corners.
        dead_reckoned: Dead reckoning at the frame; None without a base.
    """

    features: Features
    dead_reckoned: DeadReckonedPose | None


@dataclass(frozen=True, slots=True, eq=False)
class KeyframeMatch:
    """A keyframe in which a frame was found.

    Attributes:
        pose: The frame's camera in it.
    """

    keyframe: int
    pose: RelativePose
