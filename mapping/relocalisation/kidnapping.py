"""Detects that the robot was carried away: images show plenty, but not what the map shows."""

from __future__ import annotations

from fractions import Fraction

from mapping.keyframes.frame import Frame
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from mapping.relocalisation.config import KidnappingConfig
from mapping.relocalisation.depth_consistency import DepthConsistency, corners_in_view
from vizbot.core.geometry import invert
from vizbot.core.types import Intrinsics


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

    def is_elsewhere(
        self, frame: Frame, last: Features, steady: int, keyframes: KeyframeMap
    ) -> bool:
        """Whether a further frame that matches nothing in the map completes the evidence.

        Args:
            frame: Its pose is predicted; it counts less where its depth confirms that.
            last: Corners of the frame before.
            steady: Number of corners that match between the two frames. A blurred frame is no
                evidence, and without a break between them the robot was not carried.
            keyframes: The map, of which the frame should show a part. If the frame shows it at
                another pose, which wheels or gyroscope reject, that is no evidence.
        """
        features, depth, motion = frame.features, frame.image.depth, frame.T_last_cam
        if steady == 0:
            self._broke_off = True
            self._moved |= not self._consistency.confirms(last, motion, depth)
            rich = corners_in_view(last, motion, self._intrinsics) >= self._config.break_corners
            self._suspects |= rich and self._consistency.contradicts(last, motion, depth)
        reference = frame.reference
        T_map_cam = keyframes.poses[reference] @ frame.predicted
        recent = keyframes.recent()
        near = [k for k in keyframes.nearby(T_map_cam, but=reference) if k in recent]
        plenty = len(features) >= self._config.plenty_corners
        known = next((k for k in [reference, *near] if k in self._confirmed), reference)
        shown = keyframes[known].features
        expected = invert(keyframes.poses[known]) @ T_map_cam
        in_view = corners_in_view(shown, expected, self._intrinsics)
        if known in self._confirmed and in_view >= self._config.plenty_corners:
            elsewhere = plenty and not keyframes.matcher.shows(keyframes[known], features)
            self.doubts = elsewhere or self._suspects
            contradicts = elsewhere and self._broke_off
            in_place = self._consistency.confirms(shown, expected, depth)
        else:  # no confirmed keyframe is there
            self.doubts = self._suspects
            contradicts = plenty and self._suspects
            in_place = True
        if contradicts and steady >= self._config.plenty_corners:
            moved = self._moved and not in_place
            patience = self._config.lost_frames if moved else self._config.lost_frames_in_place
            self._contradictions += Fraction(1, patience)
        return self._contradictions >= 1
