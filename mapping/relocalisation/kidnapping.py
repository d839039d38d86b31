"""Detects that the robot was carried away: images show plenty, but not what the map shows."""

from __future__ import annotations

from fractions import Fraction

from mapping.keyframes.frame_matcher import FrameMatcher
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from mapping.relocalisation.config import KidnappingConfig
from mapping.relocalisation.depth_consistency import DepthConsistency, corners_in_view
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, Intrinsics, RGBDFrame


class Kidnapping:
    """Collects evidence against the robot's pose.

    Attributes:
        doubts: Whether the newest frame shows plenty, but not what it should, or follows a break;
            no keyframe should be made there.
    """

    def __init__(
        self, intrinsics: Intrinsics, consistency: DepthConsistency, config: KidnappingConfig
    ) -> None:
        self._intrinsics = intrinsics
        self._consistency = consistency
        self._config = config
        self.reset()
        self._confirmed: set[int] = set()

    def confirm(self, keyframe: int, found: RelativePose) -> None:
        """Note that a frame was found in a keyframe, which later frames may be compared with.

        A keyframe that no other frame has matched may be blurred.
        """
        if found.inliers > 0:
            self._confirmed.add(keyframe)
        self.reset()

    def reset(self) -> None:
        """Drop the evidence collected so far."""
        self.doubts = False
        self._broke_off = False
        self._moved = False
        self._suspects = False
        self._contradictions = Fraction(0)

    def forget_confirmed(self) -> None:
        """Note that the robot was relocalised: earlier keyframes are no longer compared with."""
        self._confirmed.clear()

    def compare(self, before: Features, motion: SE3, steady: int, frame: RGBDFrame) -> None:
        """Look for a break between the frame before and a frame that matches nothing in the map.

        Args:
            before: Corners of the frame before.
            motion: T_before_cam as predicted.
            steady: Number of corners that match between the two frames.
            frame: The frame.
        """
        if steady > 0:
            return
        self._broke_off = True
        self._moved |= not self._consistency.confirms(before, motion, frame.depth)
        rich = corners_in_view(before, motion, self._intrinsics) >= self._config.break_corners
        self._suspects |= rich and self._consistency.contradicts(before, motion, frame.depth)

    def is_elsewhere(
        self,
        frame: RGBDFrame,
        features: Features,
        keyframes: KeyframeMap,
        matcher: FrameMatcher,
        reference: int,
        T_reference_cam: SE3,
        steady: int,
    ) -> bool:
        """Whether a further frame that matches nothing completes the evidence.

        Args:
            frame: The frame; it counts less where its depth confirms the pose.
            features: Corners of the frame.
            keyframes: The map, of which the frame should show a part.
            matcher: Checks whether it does, at whatever pose: a match that only wheels or gyroscope
                reject is no evidence.
            reference: Id of the keyframe that the robot has been measured in.
            T_reference_cam: Predicted pose of the frame.
            steady: Number of corners that match the frame before. A blurred frame is no evidence,
                and without a break the robot was not carried.
        """
        T_map_cam = keyframes.poses[reference] @ T_reference_cam
        near = [k for k in keyframes.nearby(T_map_cam, but=reference) if keyframes.is_recent(k)]
        plenty = len(features) >= self._config.plenty_corners
        known = next((k for k in [reference, *near] if k in self._confirmed), reference)
        shown = keyframes[known].features
        expected = invert(keyframes.poses[known]) @ T_map_cam
        in_view = corners_in_view(shown, expected, self._intrinsics)
        if known in self._confirmed and in_view >= self._config.plenty_corners:
            elsewhere = plenty and not matcher.shows(keyframes[known], features)
            self.doubts = elsewhere or self._suspects
            contradicts = elsewhere and self._broke_off
            in_place = self._consistency.confirms(shown, expected, frame.depth)
        else:  # no confirmed keyframe is there
            self.doubts = self._suspects
            contradicts = plenty and self._suspects
            in_place = True
        if contradicts and steady >= self._config.plenty_corners:
            moved = self._moved and not in_place
            patience = self._config.lost_frames if moved else self._config.lost_frames_in_place
            self._contradictions += Fraction(1, patience)
        return self._contradictions >= 1
