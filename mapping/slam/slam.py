"""Pose estimation: images, wheels and gyroscope, joined in a graph over keyframes.

Every frame is measured against a keyframe. Where images say too little (white walls, darkness) the
wheels and the gyroscope carry the pose; without wheels tracking is lost until a frame matches a
keyframe again. Where images show plenty, but not what the map shows there, the robot was carried
away, and is lost until it recognises a place. Keyframes are used again where the robot comes by
again, so that the graph grows with the home and not with time.
"""

from __future__ import annotations

import logging
import sys

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.keyframes.frame_matcher import FrameMatcher
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.selection import is_due
from mapping.keyframes.tracked_pose import TrackedPose
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
        surroundings: LocalMap | None = None,
    ) -> None:
        """Know nothing.

        Args:
            intrinsics: Of all frames.
            T_base_cam: Where the camera sits.
            config: Settings.
            surroundings: Tell by obstacles where a lost robot is; None leaves that to images.
        """
        self._T_base_cam = T_base_cam
        self._config = config
        self._dead_reckoning = DeadReckoning(T_base_cam, config.dead_reckoning)
        self._matcher = FrameMatcher(
            intrinsics, T_base_cam, config.features, config.odometry, config.gates
        )
        solid = DepthConsistency(intrinsics, T_base_cam, config.solid)
        self._kidnapping = Kidnapping(intrinsics, solid, config.kidnapping)
        self._relocalisation = Relocaliser(
            intrinsics, T_base_cam, solid, config.relocalisation, surroundings
        )
        self._map = KeyframeMap(T_base_cam, config.keyframes, config.graph, config.places)
        self._where = TrackedPose(self._map, self._matcher)
        self._search = PlaceSearch(self._where, self._relocalisation, config)
        self._loops = LoopClosure(self._where, self._search, T_base_cam, config)
        self._last: tuple[Features, RelativePose] | None = None
        self._seen = NO_FEATURES
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

    def views(self) -> KeyframeViews:
        """What the keyframes show, to be kept with their poses."""
        return self._map.views()

    def know(self, keyframes: Keyframes, views: KeyframeViews) -> None:
        """Begin, before the first frame, in a saved map: lost until a place is recognised.

        Raises:
            MapError: it has no keyframe.
        """
        if len(keyframes.ids) == 0:
            raise MapError("the saved map has no keyframe to know a place by; start without it")
        self._in_saved_map = True
        self._map.restore(keyframes, views)
        self._where.reference = int(keyframes.ids[0])
        self._tracking = Tracking.LOST

    def track(self, frame: RGBDFrame, T_odom_base: SE3 | None) -> PoseEstimate:
        """Estimate where `frame` was taken.

        Args:
            frame: Newer than any before.
            T_odom_base: Dead reckoning by the wheels at that time; None without a base.
        """
        before, self._where.reckoning = self._where.reckoning, None
        if T_odom_base is not None:
            self._where.reckoning = self._dead_reckoning.follow(frame, T_odom_base)
        features = detect(frame, self._config.features)
        if len(self._map) == 0:
            self._where.reference = self._map.begin(features, self._where.reckoning)
            self._last, self._seen = (features, _ITSELF), features
            return self._estimate(frame.stamp, True)
        motion, unseen = self._motion_since(before)
        T_map_last = self._where.T_map_cam
        measured = self._locate(frame, features, motion, unseen)
        self._last, self._seen = None if measured is None else (features, measured), features
        regular = self._tracking is Tracking.TRACKING
        self._T_last_cam = invert(T_map_last) @ self._where.T_map_cam if regular else np.eye(4)
        new = self._is_due(features, measured) and not self._goes_on(features, measured)
        if new:
            self._insert(features, measured)
        return self._estimate(frame.stamp, new)

    def lift(self, stamp: float) -> PoseEstimate:
        """The robot hangs in the air: it is lost until it stands where it recognises a place.

        Args:
            stamp: Of a frame that tells nothing, not the first one [s].
        """
        self._kidnapping.forget()
        self._relocalisation.forget()
        self._last, self._where.reckoning, self._tracking = None, None, Tracking.LOST
        return self._estimate(stamp, False)

    def _motion_since(
        self, before: DeadReckonedPose | None
    ) -> tuple[SE3, NDArray[np.float64] | None]:
        """T_last_cam as predicted, and with wheels the motion since images were last believed."""
        if self._where.reckoning is None or before is None:
            return self._T_last_cam, None
        now = self._where.reckoning
        motion = invert(self._T_base_cam) @ now.since(before) @ self._T_base_cam
        self._where.blind.go(motion, now.gyro_since(before))
        return motion, self._where.blind.motion

    def _locate(
        self,
        frame: RGBDFrame,
        features: Features,
        motion: SE3,
        unseen: NDArray[np.float64] | None,
    ) -> RelativePose | None:
        """Find the frame's place in a keyframe, and say what that place rests on."""
        config, where, before = self._config, self._where, self._tracking
        reference, predicted = self._map[where.reference], where.T_reference_cam @ motion
        if before is Tracking.LOST:
            measured, now = self._search.anywhere(frame, features), Tracking.RELOCALISED
        else:
            measured, now = self._matcher.step(
                reference, self._last, features, where.T_reference_cam, motion,
                (config.search, config.wide_search), where.reckoning, unseen,
            ), Tracking.TRACKING  # fmt: skip
            if measured is None:
                measured = self._search.nearby(features, predicted, unseen)
        if measured is not None:
            if now is Tracking.RELOCALISED:
                self._kidnapping.over()
            self._kidnapping.agree(where.reference, measured)
            self._relocalisation.forget()
            where.T_reference_cam = measured.T_keyframe_cam
            where.blind.end()
        else:
            lost = unseen is None or before is Tracking.LOST
            lost = lost or self._is_carried_away(frame, features, predicted, motion)
            now = Tracking.LOST if lost else Tracking.WHEELS_ONLY
            if unseen is not None:
                where.T_reference_cam = predicted
        if now is not before:
            _log.info("tracking: %s", now.value)
        self._tracking = now
        return measured

    def _is_carried_away(
        self, frame: RGBDFrame, features: Features, predicted: SE3, motion: SE3
    ) -> bool:
        """Whether images that go well together have shown for long that the robot is elsewhere."""
        step = self._matcher.between(self._seen, features, motion, self._config.search)
        steady = 0 if step is None else step.inliers
        self._kidnapping.follow(self._seen, motion, steady, frame)
        return self._kidnapping.is_elsewhere(
            frame, features, self._map, self._matcher, self._where.reference, predicted, steady
        )

    def _is_due(self, features: Features, measured: RelativePose | None) -> bool:
        """Whether the frame should become a keyframe."""
        least = 2 * self._config.odometry.min_inliers
        reference = self._map[self._where.reference]
        if self._tracking is Tracking.LOST:
            # A keyframe at a guessed place is a lie, unless nothing has been seen before it.
            if self._in_saved_map:
                return False
            seen = [self._map[keyframe] for keyframe in self._map.poses]
        elif measured is None and self._kidnapping.doubts:
            return False
        elif self._is_blank(features, measured):
            # Only what is mapped in the dark hangs on it.
            way = float(np.linalg.norm(self._where.T_reference_cam[:3, 3]))
            return way > self._config.keyframes.blank_distance
        else:
            if is_due(reference, self._where.T_reference_cam, measured, self._config.keyframes):
                return measured is not None or not self._matcher.shows(reference, features)
            seen = [reference]
        return len(features) >= least and all(len(k.features) < least for k in seen)

    def _is_blank(self, features: Features, measured: RelativePose | None) -> bool:
        """Whether nothing will ever match a frame: the dark, or a bare wall."""
        return measured is None and len(features) < 2 * self._config.odometry.min_inliers

    def _goes_on(self, features: Features, measured: RelativePose | None) -> bool:
        """Whether an older keyframe serves as well as a new one would, from here on."""
        if measured is None:
            dark = self._is_blank(features, measured)
            return dark and self._where.refer_to_blank(self._config.gates)
        found = self._loops.fall_back(features, measured)
        if found is None:
            found = self._loops.rejoin(features, measured)
        if found is not None:
            self._last = features, found
        return found is not None

    def _insert(self, features: Features, measured: RelativePose | None) -> None:
        """Make the frame a keyframe."""
        where, blank = self._where, self._is_blank(features, measured)
        self._dead_reckoning.compare(self._map[where.reference].reckoning, measured)
        gyro = self._matcher.agrees_with_gyro(self._map[where.reference], measured, where.reckoning)
        links = self._loops.links(features, measured)
        where.reference = self._map.insert(
            NO_FEATURES if blank else features,
            where.reckoning, where.T_map_cam, where.reference, links,
            where.blind.since_reference, gyro=gyro,
        )  # fmt: skip
        where.T_reference_cam = np.eye(4)
        where.blind.reset_reference()
        if not links:
            where.blind.start_span(where.reference, self._config.keyframes)
        self._last = features, _ITSELF

    def _estimate(self, stamp: float, new: bool) -> PoseEstimate:
        T, covariance = self._where.T_reference_cam, self._last and self._last[1].covariance
        return PoseEstimate(
            stamp, self._where.T_map_cam, self._where.reference, T, new, self._tracking, covariance
        )
