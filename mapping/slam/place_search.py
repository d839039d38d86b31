"""Searches the map for a frame that its reference keyframe does not show."""

from __future__ import annotations

from collections.abc import Iterator

from mapping.keyframes.frame_matcher import FrameMatcher, MotionPrior
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.tracked_pose import KeyframeMatch, TrackedPose
from mapping.odometry.features import Features
from mapping.relocalisation.relocaliser import Relocaliser
from mapping.slam.config import SlamConfig
from vizbot.core.geometry import invert
from vizbot.core.types import RGBDFrame


class PlaceSearch:
    """Finds the keyframe that shows a frame; it changes neither the map nor the pose."""

    def __init__(
        self,
        keyframe_map: KeyframeMap,
        matcher: FrameMatcher,
        relocaliser: Relocaliser,
        config: SlamConfig,
    ) -> None:
        self._map = keyframe_map
        self._matcher = matcher
        self._relocaliser = relocaliser
        self._config = config

    def nearby(
        self, features: Features, pose: TrackedPose, prior: MotionPrior
    ) -> KeyframeMatch | None:
        """Search the whole image for the keyframes near the predicted pose.

        Args:
            features: Corners of the frame.
            pose: Of the frame before, with dead reckoning at this one.
            prior: The motion since then by dead reckoning.
        """
        config, keyframes = self._config, self._map
        T_map_cam = keyframes.poses[pose.reference] @ (pose.T_reference_cam @ prior.T_last_cam)
        others = keyframes.nearby(T_map_cam, but=pose.reference)
        for keyframe in [pose.reference, *others[: config.nearby_tries]]:
            expected = invert(keyframes.poses[keyframe]) @ T_map_cam
            found = self._matcher.match(
                keyframes[keyframe],
                features,
                expected,
                1.0,
                keyframes.dead_reckoned_from(keyframe, pose.dead_reckoned),
            )
            if found is None or found.inliers < config.gates.sure_inliers:
                continue
            if self._matcher.agrees_with_wheels(found, expected, prior.wheel_only):
                return KeyframeMatch(keyframe, found)
        return None

    def anywhere(
        self, frame: RGBDFrame, features: Features, pose: TrackedPose
    ) -> KeyframeMatch | None:
        """Compare the frame with all places, for a robot that may have been carried."""
        now = pose.dead_reckoned
        T_odom_base = None if now is None else now.T_odom_base
        return self._relocaliser.recognise(frame, features, self._map, self._matcher, T_odom_base)

    def sure_matches(self, features: Features, before: int) -> Iterator[KeyframeMatch]:
        """Keyframes older than `before` that look strikingly like a frame, the best first."""
        return self._relocaliser.sure_matches(features, self._map, self._matcher, before)
