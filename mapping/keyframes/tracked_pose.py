"""Where the camera is: in which keyframe of the map, and how dead reckoning came there."""

from __future__ import annotations

import numpy as np

from mapping.keyframes.frame_matcher import FrameMatcher
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.wheel_only_motion import WheelOnlyMotion
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.features import Features
from mapping.odometry.gating import GatingConfig
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import invert
from vizbot.core.types import SE3


class TrackedPose:
    """The newest frame's place.

    Attributes:
        places: The map.
        matcher: Measures frames in its keyframes.
        blind: The way that wheels alone had the word on.
        reckoning: Dead reckoning at the newest frame; None without wheels.
        reference: The keyframe that frames are measured in.
        T_reference_cam: The camera in it.
    """

    def __init__(self, places: KeyframeMap, matcher: FrameMatcher) -> None:
        """In a map that is empty so far."""
        self.places = places
        self.matcher = matcher
        self.blind = WheelOnlyMotion()
        self.reckoning: DeadReckonedPose | None = None
        self.reference = 0
        self.T_reference_cam: SE3 = np.eye(4)

    @property
    def T_map_cam(self) -> SE3:
        """Of the newest frame."""
        return self.places.poses[self.reference] @ self.T_reference_cam

    def against(
        self, keyframe: int, features: Features, expected: SE3, share: float, *, once: bool = False
    ) -> RelativePose | None:
        """Measure the frame in a keyframe; only of recent ones dead reckoning knows the way.

        Args:
            keyframe: Any.
            features: Of the frame.
            expected: Where it should lie in the keyframe.
            share: Radius of the search, as a fraction of the image's width.
            once: Whether one minimal pose will do (`FrameMatcher.against`).
        """
        now = self.reckoning if self.places.is_recent(keyframe) else None
        return self.matcher.against(
            self.places[keyframe], features, expected, share, now, once=once
        )

    def refer_to(self, keyframe: int, found: RelativePose) -> None:
        """Measure what follows against another keyframe, in which images found the frame."""
        self.blind.close_spans(keyframe)
        self._refer_to(keyframe, found)

    def refer_to_blank(self, gates: GatingConfig) -> bool:
        """In the dark, go on from an older keyframe that shows nothing either, if one is near."""
        keyframe = self.places.blank_near(self.T_map_cam)
        if keyframe is None:
            return False
        T_keyframe_cam = invert(self.places.poses[keyframe]) @ self.T_map_cam
        step, turn = gates.wheel_gate + self.blind.motion
        covariance = np.diag(np.repeat((turn, step), 3) ** 2)
        self._refer_to(keyframe, RelativePose(T_keyframe_cam, covariance, 0, 1.0))
        self.blind.branch_span()
        return True

    def _refer_to(self, keyframe: int, found: RelativePose) -> None:
        if keyframe != self.reference or not self.places.is_recent(keyframe):
            self.reference, self.T_reference_cam = keyframe, found.T_keyframe_cam
            self.places.refer_to(keyframe, found, self.reckoning)
