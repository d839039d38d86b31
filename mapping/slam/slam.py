"""Pose estimation: images, wheels and gyroscope, joined in a graph over keyframes.

Every frame is measured against a keyframe. Where images show too little (white walls, darkness),
wheels and gyroscope carry the pose; without wheels tracking is lost until a frame matches a
keyframe again. Where images show plenty, but not what the map shows there, the robot was carried
away, and is lost until it recognises a place. Keyframes are reused where the robot returns to
them, so that the graph grows with the home and not with time.
"""

from __future__ import annotations

import logging
import sys
from dataclasses import replace

import numpy as np

from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.keyframes.frame_matcher import FrameMatcher, MotionPrior
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.selection import is_due
from mapping.keyframes.tracked_pose import KeyframeMatch, TrackedPose
from mapping.keyframes.wheel_only_motion import WheelOnlyMotion
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.dead_reckoning import DeadReckoning
from mapping.odometry.features import NO_FEATURES, Features, detect
from mapping.odometry.rgbd_odometry import RelativePose
from mapping.relocalisation.depth_consistency import DepthConsistency
from mapping.relocalisation.kidnapping import Kidnapping
from mapping.relocalisation.local_map import LocalMap
from mapping.relocalisation.relocaliser import Relocaliser
from mapping.slam.config import SlamConfig
from mapping.slam.loop_closure import LoopClosure
from mapping.slam.place_search import PlaceSearch
from vizbot.core.errors import MapError
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, Intrinsics, PoseEstimate, RGBDFrame, Tracking

_log = logging.getLogger(__name__)

_ITSELF = RelativePose(np.eye(4), np.zeros((6, 6)), sys.maxsize, 1.0)
"""A keyframe in itself."""


class Slam:
    """Tracks a camera and keeps the graph of its keyframes.

    The map starts where the base stood at the first frame. Equal input gives equal output, bit for
    bit.
    """

    def __init__(
        self,
        intrinsics: Intrinsics,
        T_base_cam: SE3,
        config: SlamConfig,
        local_map: LocalMap | None = None,
    ) -> None:
        """Start with an empty map.

        Args:
            intrinsics: Of all frames.
            T_base_cam: Where the camera sits.
            config: Settings.
            local_map: Compares obstacles with the map while the robot is lost; None relocalises by
                images alone.
        """
        self._T_base_cam = T_base_cam
        self._config = config
        self._dead_reckoning = DeadReckoning(T_base_cam, config.dead_reckoning)
        self._matcher = FrameMatcher(
            intrinsics, T_base_cam, config.features, config.odometry, config.gates
        )
        consistency = DepthConsistency(intrinsics, T_base_cam, config.depth_consistency)
        self._kidnapping = Kidnapping(intrinsics, consistency, config.kidnapping)
        self._relocaliser = Relocaliser(
            intrinsics, T_base_cam, consistency, config.relocalisation, local_map
        )
        self._map = KeyframeMap(T_base_cam, config.keyframes, config.graph, config.place_index)
        self._search = PlaceSearch(self._map, self._matcher, self._relocaliser, config)
        self._loops = LoopClosure(self._map, self._matcher, self._search, T_base_cam, config)
        self._pose = TrackedPose()
        self._wheel_only = WheelOnlyMotion()
        self._last: tuple[Features, RelativePose] | None = None
        self._last_features = NO_FEATURES
        self._T_last_cam = np.eye(4)
        self._in_saved_map = False
        self._tracking = Tracking.TRACKING

    @property
    def closures(self) -> list[tuple[int, int]]:
        """Pairs of keyframes between which a loop is closed."""
        return self._map.closures

    def keyframe_poses(self) -> dict[int, SE3]:
        """T_map_cam of every keyframe by its id, after the latest update of the graph."""
        return dict(self._map.poses)

    def features(self) -> dict[int, Features]:
        """What every keyframe shows, by its id, to be saved with their poses."""
        return self._map.features()

    def start_in_map(self, keyframes: Keyframes, views: KeyframeViews) -> None:
        """Start, before the first frame, in a saved map: lost until a place is recognised.

        Raises:
            MapError: the map has no keyframe.
        """
        if len(keyframes.ids) == 0:
            raise MapError("the saved map has no keyframe to know a place by; start without it")
        self._in_saved_map = True
        self._map.restore(keyframes, views)
        self._pose = replace(self._pose, reference=int(keyframes.ids[0]))
        self._tracking = Tracking.LOST

    def track(self, frame: RGBDFrame, T_odom_base: SE3 | None) -> PoseEstimate:
        """Estimate where `frame` was taken.

        Args:
            frame: Newer than any before.
            T_odom_base: Dead reckoning by the wheels at that time; None without a base.
        """
        before = self._pose.dead_reckoned
        now = None if T_odom_base is None else self._dead_reckoning.update(frame, T_odom_base)
        self._pose = replace(self._pose, dead_reckoned=now)
        features = detect(frame, self._config.features)
        if len(self._map) == 0:
            self._pose = replace(self._pose, reference=self._map.add_first(features, now))
            self._last, self._last_features = (features, _ITSELF), features
            return self._estimate(frame.stamp, True)
        prior = self._motion_since(before)
        T_map_last = self._pose.in_map(self._map.poses)
        measured = self._locate(frame, features, prior)
        self._last = None if measured is None else (features, measured)
        self._last_features = features
        regular = self._tracking is Tracking.TRACKING
        T_map_cam = self._pose.in_map(self._map.poses)
        self._T_last_cam = invert(T_map_last) @ T_map_cam if regular else np.eye(4)
        new = self._is_due(features, measured) and not self._reuses_keyframe(features, measured)
        if new:
            self._insert(features, measured)
        return self._estimate(frame.stamp, new)

    def lift(self, stamp: float) -> PoseEstimate:
        """Note that the robot hangs in the air: it is lost until it recognises where it stands.

        Args:
            stamp: Of a frame that is not used, not the first one [s].
        """
        self._kidnapping.reset()
        self._relocaliser.reset()
        self._last, self._tracking = None, Tracking.LOST
        self._pose = replace(self._pose, dead_reckoned=None)
        return self._estimate(stamp, False)

    def _motion_since(self, before: DeadReckonedPose | None) -> MotionPrior:
        """What is expected of the newest frame, given dead reckoning at the frame before."""
        now = self._pose.dead_reckoned
        if now is None or before is None:
            return MotionPrior(self._T_last_cam, None)
        motion = invert(self._T_base_cam) @ now.since(before) @ self._T_base_cam
        self._wheel_only.add_step(motion, now.gyro_since(before))
        return MotionPrior(motion, self._wheel_only.motion)

    def _locate(
        self, frame: RGBDFrame, features: Features, prior: MotionPrior
    ) -> RelativePose | None:
        """Find the frame in a keyframe, and set the pose and what it rests on."""
        config, pose, before = self._config, self._pose, self._tracking
        predicted = pose.T_reference_cam @ prior.T_last_cam
        if before is Tracking.LOST:
            measured, now = self._relocalise(frame, features), Tracking.RELOCALISED
        else:
            shares = config.search_radius, config.wide_search_radius
            measured = self._matcher.track(
                self._map[pose.reference], self._last, features, pose, prior, shares
            )
            now = Tracking.TRACKING
            if measured is None:
                measured = self._regain(features, prior)
        if measured is not None:
            if now is Tracking.RELOCALISED:
                self._kidnapping.forget_confirmed()
            self._kidnapping.confirm(self._pose.reference, measured)
            self._relocaliser.reset()
            self._pose = replace(self._pose, T_reference_cam=measured.T_keyframe_cam)
            self._wheel_only.reset()
        else:
            lost = prior.wheel_only is None or before is Tracking.LOST
            lost = lost or self._is_carried_away(frame, features, predicted, prior.T_last_cam)
            now = Tracking.LOST if lost else Tracking.WHEELS_ONLY
            if prior.wheel_only is not None:
                self._pose = replace(self._pose, T_reference_cam=predicted)
        if now is not before:
            _log.info("tracking: %s", now.value)
        self._tracking = now
        return measured

    def _relocalise(self, frame: RGBDFrame, features: Features) -> RelativePose | None:
        """Find a frame anywhere in the map."""
        found = self._search.anywhere(frame, features, self._pose)
        if found is None:
            return None
        self._map.forget_dead_reckoning()
        self._refer_to_seen(found)
        return found.pose

    def _regain(self, features: Features, prior: MotionPrior) -> RelativePose | None:
        """Find a frame in the keyframes near by; a stretch by wheels alone ends there."""
        found = self._search.nearby(features, self._pose, prior)
        if found is None:
            return None
        reference = self._pose.reference
        if prior.wheel_only is not None and found.keyframe != reference:
            predicted = self._pose.T_reference_cam @ prior.T_last_cam
            T_reference_keyframe = predicted @ invert(found.pose.T_keyframe_cam)
            self._map.add_wheel_only_link(
                reference, found.keyframe, T_reference_keyframe, self._wheel_only.since_reference
            )
        self._refer_to_seen(found)
        return found.pose

    def _refer_to_seen(self, match: KeyframeMatch) -> None:
        """Measure what follows in another keyframe, in which images found the frame."""
        self._wheel_only.close_spans(match.keyframe)
        self._refer_to(match)

    def _refer_to_blank(self) -> bool:
        """Continue in the dark from an older blank keyframe; whether one is near enough."""
        T_map_cam = self._pose.in_map(self._map.poses)
        keyframe = self._map.nearest_blank(T_map_cam)
        if keyframe is None:
            return False
        T_keyframe_cam = invert(self._map.poses[keyframe]) @ T_map_cam
        step, turn = self._config.gates.wheel_gate + self._wheel_only.motion
        covariance = np.diag(np.repeat((turn, step), 3) ** 2)
        self._refer_to(KeyframeMatch(keyframe, RelativePose(T_keyframe_cam, covariance, 0, 1.0)))
        self._wheel_only.branch_span()
        return True

    def _refer_to(self, match: KeyframeMatch) -> None:
        keyframe, found = match.keyframe, match.pose
        if keyframe != self._pose.reference or not self._map.is_recent(keyframe):
            T_reference_cam = found.T_keyframe_cam
            self._pose = replace(self._pose, reference=keyframe, T_reference_cam=T_reference_cam)
            self._map.restart_dead_reckoning(keyframe, found, self._pose.dead_reckoned)

    def _is_carried_away(
        self, frame: RGBDFrame, features: Features, predicted: SE3, motion: SE3
    ) -> bool:
        """Whether images that agree with each other have long shown that the robot is elsewhere."""
        last = self._last_features
        step = self._matcher.between(last, features, motion, self._config.search_radius)
        steady = 0 if step is None else step.inliers
        self._kidnapping.compare(last, motion, steady, frame)
        reference = self._pose.reference
        return self._kidnapping.is_elsewhere(
            frame, features, self._map, self._matcher, reference, predicted, steady
        )

    def _is_due(self, features: Features, measured: RelativePose | None) -> bool:
        """Whether the frame should become a keyframe."""
        least = 2 * self._config.odometry.min_inliers
        reference = self._map[self._pose.reference]
        if self._tracking is Tracking.LOST:
            # A keyframe at a guessed pose would be wrong, unless nothing was seen before it.
            if self._in_saved_map:
                return False
            seen = [self._map[keyframe] for keyframe in self._map.poses]
        elif measured is None and self._kidnapping.doubts:
            return False
        elif self._is_blank(features, measured):
            # Only what is mapped in the dark depends on it.
            distance = float(np.linalg.norm(self._pose.T_reference_cam[:3, 3]))
            return distance > self._config.keyframes.blank_distance
        else:
            if is_due(reference, self._pose.T_reference_cam, measured, self._config.keyframes):
                return measured is not None or not self._matcher.shows(reference, features)
            seen = [reference]
        return len(features) >= least and all(len(k.features) < least for k in seen)

    def _is_blank(self, features: Features, measured: RelativePose | None) -> bool:
        """Whether a frame shows too little to be matched, as in the dark or before a bare wall."""
        return measured is None and len(features) < 2 * self._config.odometry.min_inliers

    def _reuses_keyframe(self, features: Features, measured: RelativePose | None) -> bool:
        """Whether an older keyframe serves as well as a new one; it is the reference then."""
        if measured is None:
            return self._is_blank(features, measured) and self._refer_to_blank()
        found = self._loops.close_nearby(features, measured, self._pose)
        if found is None:
            found = self._loops.close_over_spans(
                features, measured, self._pose, self._wheel_only.spans
            )
        if found is None:
            return False
        self._refer_to_seen(found)
        self._last = features, found.pose
        return True

    def _insert(self, features: Features, measured: RelativePose | None) -> None:
        """Make the frame a keyframe."""
        pose, blank = self._pose, self._is_blank(features, measured)
        reference = self._map[pose.reference]
        self._dead_reckoning.learn(reference.dead_reckoned, measured)
        gyro = self._matcher.agrees_with_gyro(reference, measured, pose.dead_reckoned)
        links = self._loops.links(features, measured, pose)
        for keyframe in links:
            if keyframe != pose.reference:
                self._wheel_only.close_spans(keyframe)
        new = self._map.insert(
            NO_FEATURES if blank else features,
            pose.dead_reckoned,
            pose.in_map(self._map.poses),
            pose.reference,
            links,
            self._wheel_only.since_reference,
            gyro=gyro,
        )
        self._pose = replace(pose, reference=new, T_reference_cam=np.eye(4))
        self._wheel_only.reset_reference()
        if not links:
            self._wheel_only.start_span(new, self._config.keyframes)
        self._last = features, _ITSELF

    def _estimate(self, stamp: float, new: bool) -> PoseEstimate:
        pose, covariance = self._pose, self._last and self._last[1].covariance
        return PoseEstimate(
            stamp,
            pose.in_map(self._map.poses),
            pose.reference,
            pose.T_reference_cam,
            new,
            self._tracking,
            covariance,
        )
