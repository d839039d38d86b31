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

from mapping.anchors import Keyframes, Views
from mapping.dead_reckoning import DeadReckoning, Reckoning
from mapping.features import NO_FEATURES, Features, detect
from mapping.frame_matcher import FrameMatcher
from mapping.gates import may_link
from mapping.keyframe_map import KeyframeMap
from mapping.keyframes import is_covered, is_due
from mapping.odometry import RelativePose, chained, reversed_pose
from mapping.relocalisation import Relocalisation
from mapping.slam_config import SlamConfig
from mapping.surroundings import Surroundings
from vizbot.core.geometry import invert, rotation_angle
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
        surroundings: Surroundings | None = None,
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
        self._relocalisation = Relocalisation(
            intrinsics, T_base_cam, config.relocalisation, surroundings
        )
        self._map = KeyframeMap(T_base_cam, config.keyframes, config.graph, config.places)
        self._reference = 0
        self._T_reference_cam = np.eye(4)
        self._reckoning: Reckoning | None = None
        self._last: tuple[Features, RelativePose] | None = None
        self._seen = NO_FEATURES
        self._T_last_cam = np.eye(4)
        self._unseen_motion = np.zeros(2)
        self._tracking = Tracking.TRACKING

    @property
    def closures(self) -> list[tuple[int, int]]:
        """Pairs of keyframes between which a loop is closed."""
        return self._map.closures

    def keyframe_poses(self) -> dict[int, SE3]:
        """T_map_cam of every keyframe by its id, after the latest update of the graph."""
        return dict(self._map.poses)

    def views(self) -> Views:
        """What the keyframes show, to be kept with their poses."""
        return self._map.views()

    def know(self, keyframes: Keyframes, views: Views) -> None:
        """Begin, before the first frame, in a saved map: lost until a place is recognised."""
        self._map.restore(keyframes, views)
        self._reference = int(keyframes.ids[0])
        self._tracking = Tracking.LOST

    def track(self, frame: RGBDFrame, T_odom_base: SE3 | None) -> PoseEstimate:
        """Estimate where `frame` was taken.

        Args:
            frame: Newer than any before.
            T_odom_base: Dead reckoning by the wheels at that time; None without a base.
        """
        before, self._reckoning = self._reckoning, None
        if T_odom_base is not None:
            self._reckoning = self._dead_reckoning.follow(frame, T_odom_base)
        features = detect(frame, self._config.features)
        if len(self._map) == 0:
            self._reference = self._map.begin(features, self._reckoning)
            self._last, self._seen = (features, _ITSELF), features
            return self._estimate(frame.stamp, True)
        motion, unseen = self._motion_since(before)
        T_map_last = self._camera()
        measured = self._locate(frame, features, motion, unseen)
        self._last, self._seen = None if measured is None else (features, measured), features
        regular = self._tracking is Tracking.TRACKING
        self._T_last_cam = invert(T_map_last) @ self._camera() if regular else np.eye(4)
        new = self._is_due(features, measured) and not self._falls_back(features, measured)
        if new:
            self._insert(features, measured)
        return self._estimate(frame.stamp, new)

    def lift(self, stamp: float) -> PoseEstimate:
        """The robot hangs in the air: it is lost until it stands where it recognises a place.

        Args:
            stamp: Of a frame that tells nothing, not the first one [s].
        """
        self._relocalisation.forget()
        self._last, self._reckoning, self._tracking = None, None, Tracking.LOST
        return self._estimate(stamp, False)

    def _camera(self) -> SE3:
        """T_map_cam of the newest frame."""
        return self._map.poses[self._reference] @ self._T_reference_cam

    def _motion_since(self, before: Reckoning | None) -> tuple[SE3, NDArray[np.float64] | None]:
        """T_last_cam as predicted, and with wheels the motion since images were last believed."""
        if self._reckoning is None or before is None:
            return self._T_last_cam, None
        motion = invert(self._T_base_cam) @ self._reckoning.since(before) @ self._T_base_cam
        self._unseen_motion += np.array([np.linalg.norm(motion[:3, 3]), rotation_angle(motion)])
        return motion, self._unseen_motion

    def _locate(
        self,
        frame: RGBDFrame,
        features: Features,
        motion: SE3,
        unseen: NDArray[np.float64] | None,
    ) -> RelativePose | None:
        """Find the frame's place in a keyframe, and say what that place rests on."""
        config, before = self._config, self._tracking
        reference, predicted = self._map[self._reference], self._T_reference_cam @ motion
        if before is Tracking.LOST:
            measured, now = self._find_anywhere(frame, features), Tracking.RELOCALISED
        else:
            measured, now = self._matcher.step(
                reference, self._last, features, self._T_reference_cam, motion,
                (config.search, config.wide_search), self._reckoning, unseen,
            ), Tracking.TRACKING  # fmt: skip
            if measured is None:
                measured = self._find_nearby(features, predicted, unseen)
        if measured is not None:
            self._relocalisation.agree(self._reference, measured)
            self._T_reference_cam = measured.T_keyframe_cam
            self._unseen_motion = np.zeros(2)
        else:
            lost = unseen is None or before is Tracking.LOST
            lost = lost or self._is_carried_away(frame, features, predicted, motion)
            now = Tracking.LOST if lost else Tracking.WHEELS_ONLY
            if unseen is not None:
                self._T_reference_cam = predicted
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
        return self._relocalisation.is_elsewhere(
            frame, features, self._map, self._matcher, self._reference, predicted, steady
        )

    def _find_nearby(
        self, features: Features, predicted: SE3, unseen: NDArray[np.float64] | None
    ) -> RelativePose | None:
        """Search the whole image for the keyframes near; the one that agrees is the reference."""
        T_map_cam = self._map.poses[self._reference] @ predicted
        others = self._map.nearby(T_map_cam, but=self._reference)
        for keyframe in [self._reference, *others[: self._config.nearby_tries]]:
            expected = invert(self._map.poses[keyframe]) @ T_map_cam
            found = self._against(keyframe, features, expected, 1.0)
            if found is None or found.inliers < self._config.gates.sure_inliers:
                continue
            if self._matcher.believed(found, expected, unseen):
                self._refer_to(keyframe, found)
                return found
        return None

    def _find_anywhere(self, frame: RGBDFrame, features: Features) -> RelativePose | None:
        """Compare with all places for the one where the frame was taken."""
        T_odom_base = None if self._reckoning is None else self._reckoning.T_odom_base
        found = self._relocalisation.recognise(
            frame, features, self._map, self._matcher, T_odom_base
        )
        if found is None:
            return None
        self._map.forget_ways()
        self._refer_to(*found)
        return found[1]

    def _against(
        self, keyframe: int, features: Features, expected: SE3, share: float, *, once: bool = False
    ) -> RelativePose | None:
        """Measure the frame in a keyframe; only of recent ones dead reckoning knows the way."""
        now = self._reckoning if self._map.is_recent(keyframe) else None
        return self._matcher.against(self._map[keyframe], features, expected, share, now, once=once)

    def _refer_to(self, keyframe: int, found: RelativePose) -> None:
        """Measure what follows against another keyframe."""
        if keyframe != self._reference or not self._map.is_recent(keyframe):
            self._reference, self._T_reference_cam = keyframe, found.T_keyframe_cam
            self._map.refer_to(keyframe, found, self._reckoning)

    def _is_due(self, features: Features, measured: RelativePose | None) -> bool:
        """Whether the frame should become a keyframe."""
        least = 2 * self._config.odometry.min_inliers
        reference = self._map[self._reference]
        if self._tracking is Tracking.LOST:
            # A keyframe at a guessed place is a lie, unless nothing has been seen before it.
            seen = [self._map[keyframe] for keyframe in self._map.poses]
        else:
            if is_due(reference, self._T_reference_cam, measured, self._config.keyframes):
                lies = self._relocalisation.doubts or self._matcher.shows(reference, features)
                return measured is not None or not lies
            seen = [reference]
        return len(features) >= least and all(len(k.features) < least for k in seen)

    def _falls_back(self, features: Features, measured: RelativePose | None) -> bool:
        """Go on from an older keyframe that shows the same, if any, and close the loop to it."""
        if measured is None:
            return False
        near = self._map.nearby(self._camera(), but=self._reference)
        for keyframe in near[: self._config.nearby_tries]:
            expected = invert(self._map.poses[keyframe]) @ self._camera()
            if not is_covered(expected, self._config.keyframes):
                continue
            found = self._against(keyframe, features, expected, self._config.closure_search)
            if found is None or is_due(
                self._map[keyframe], found.T_keyframe_cam, found, self._config.keyframes
            ):
                continue
            if may_link(found, expected, self._config.gates):
                link = chained(measured, reversed_pose(found))
                self._map.close(self._reference, keyframe, link)
                self._refer_to(keyframe, found)
                self._last = features, found
                return True
        return False

    def _insert(self, features: Features, measured: RelativePose | None) -> None:
        """Make the frame a keyframe."""
        T_map_cam = self._camera()
        links = {} if measured is None else {self._reference: measured}
        self._dead_reckoning.compare(self._map[self._reference].reckoning, measured)
        self._link(links, features, T_map_cam)
        self._reference = self._map.insert(
            features, self._reckoning, T_map_cam, self._reference, links
        )
        self._T_reference_cam = np.eye(4)
        self._last = features, _ITSELF

    def _link(self, links: dict[int, RelativePose], features: Features, T_map_cam: SE3) -> None:
        """Measure a new keyframe against the last few, and against the nearest of those before."""
        config = self._config
        near = self._map.nearby(T_map_cam, but=self._reference)
        recent = [keyframe for keyframe in near if self._map.is_recent(keyframe)]
        older = [keyframe for keyframe in near if not self._map.is_recent(keyframe)]
        for keyframe in recent + older[: config.keyframes.closures]:
            expected = invert(self._map.poses[keyframe]) @ T_map_cam
            share = config.closure_search if keyframe in older else config.search
            found = self._against(keyframe, features, expected, share, once=True)
            if found is not None and may_link(found, expected, config.gates):
                links[keyframe] = found

    def _estimate(self, stamp: float, new: bool) -> PoseEstimate:
        T, covariance = self._T_reference_cam, self._last and self._last[1].covariance
        return PoseEstimate(
            stamp, self._camera(), self._reference, T, new, self._tracking, covariance
        )
