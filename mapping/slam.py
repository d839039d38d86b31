"""Pose estimation: images, wheels and gyroscope, joined in a graph over keyframes.

Every frame is measured against a keyframe. Where images say too little (white walls, darkness) the
wheels and the gyroscope carry the pose; without wheels tracking is lost until a frame matches a
keyframe again.
"""

from __future__ import annotations

import logging
import sys

import numpy as np
from pydantic import BaseModel

from mapping.dead_reckoning import DeadReckoning, GyroConfig, Reckoning
from mapping.features import NO_FEATURES, FeatureConfig, Features, detect
from mapping.gates import GateConfig, closes_loop, like_wheels, turns_like_gyro
from mapping.keyframes import Keyframe, KeyframeConfig, is_due, nearby
from mapping.odometry import OdometryConfig, RelativePose, chained, relative_pose
from mapping.pose_graph import PoseGraph, PoseGraphConfig
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics, PoseEstimate, RGBDFrame, Tracking

_log = logging.getLogger(__name__)


_ITSELF = RelativePose(np.eye(4), np.zeros((6, 6)), sys.maxsize, 1.0)
"""A keyframe in itself."""


class SlamConfig(BaseModel):
    """Pose estimation."""

    model_config = SETTINGS
    features: FeatureConfig = FeatureConfig()
    """Corners and their matching."""
    odometry: OdometryConfig = OdometryConfig()
    """Poses from matches."""
    keyframes: KeyframeConfig = KeyframeConfig()
    """Choice of keyframes and of what they are linked to."""
    graph: PoseGraphConfig = PoseGraphConfig()
    """Trust in images, wheels and floor."""
    gates: GateConfig = GateConfig()
    """What images are believed."""
    gyro: GyroConfig = GyroConfig()
    """Turns between frames."""
    search: float = 0.07
    """Radius of the search around a predicted corner, as a fraction of the image's width."""
    wide_search: float = 0.5
    """The same where the motion was not as predicted."""
    closure_search: float = 0.2
    """The same where a loop may close, after some drift."""
    relocalisation_tries: int = 3
    """Other keyframes a frame is compared with when the last one does not match."""


class Slam:
    """Tracks a camera and keeps the graph of its keyframes.

    The map starts where the base stood at the first frame. Equal input gives equal output, bit for
    bit.
    """

    def __init__(self, intrinsics: Intrinsics, T_base_cam: SE3, config: SlamConfig) -> None:
        self._intrinsics = intrinsics
        self._T_base_cam = T_base_cam
        self._config = config
        self._graph = PoseGraph(T_base_cam, config.graph)
        self._dead_reckoning = DeadReckoning(T_base_cam, config.gyro)
        self._keyframes: dict[int, Keyframe] = {}
        self._Ts_map_cam: dict[int, SE3] = {}
        self._reference = 0
        self._T_reference_cam = np.eye(4)
        self._reckoning: Reckoning | None = None
        self._last_features = NO_FEATURES
        self._last_measured: RelativePose | None = None
        self._T_last_cam = np.eye(4)
        self._unseen_motion = np.zeros(2)
        self._tracking = Tracking.TRACKING

    def keyframe_poses(self) -> dict[int, SE3]:
        """T_map_cam of every keyframe by its id, after the latest update of the graph."""
        return dict(self._Ts_map_cam)

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
        if not self._keyframes:
            self._insert_first(features)
            return self._estimate(frame.stamp, True)
        motion = self._wheel_motion(before)
        wheels = motion is not None
        if motion is None:
            motion = self._T_last_cam
        else:
            self._unseen_motion += np.array([np.linalg.norm(motion[:3, 3]), rotation_angle(motion)])
        T_map_last = self._Ts_map_cam[self._reference] @ self._T_reference_cam
        measured = None
        if self._tracking is not Tracking.LOST:
            measured = self._measure(features, motion, wheels)
        if measured is None:
            measured = self._relocalise(features, motion, wheels)
        self._advance(measured, motion, wheels)
        self._last_features, self._last_measured = features, measured
        T_map_cam = self._Ts_map_cam[self._reference] @ self._T_reference_cam
        regular = self._tracking is Tracking.TRACKING
        self._T_last_cam = invert(T_map_last) @ T_map_cam if regular else np.eye(4)
        due = self._is_due(features, measured)
        if due:
            self._insert(features, T_map_cam, measured)
        return self._estimate(frame.stamp, due)

    def _wheel_motion(self, before: Reckoning | None) -> SE3 | None:
        """T_last_cam by wheels and gyroscope since the frame before; None without wheels."""
        if self._reckoning is None or before is None:
            return None
        return invert(self._T_base_cam) @ self._reckoning.since(before) @ self._T_base_cam

    def _measure(self, features: Features, motion: SE3, wheels: bool) -> RelativePose | None:
        """Measure the frame against the reference, where it should lie after `motion`.

        Where that fails, by way of the frame before, which is closest.
        """
        predicted = self._T_reference_cam @ motion
        for share in (self._config.search, self._config.wide_search):
            radius = share * self._intrinsics.width
            found = self._against(self._reference, features, predicted, radius)
            if found is not None and self._believed(found, predicted, wheels):
                return found
            if self._last_measured is None:
                continue
            found = self._match(self._last_features, features, motion, radius)
            if found is not None and self._believed(found, motion, wheels):
                found = chained(self._last_measured, found)
                return found if self._turns_like_gyro(self._reference, found) else None
        return None

    def _relocalise(self, features: Features, motion: SE3, wheels: bool) -> RelativePose | None:
        """Search the whole image for the keyframes near; the one that agrees is the reference."""
        T_map_cam = self._Ts_map_cam[self._reference] @ self._T_reference_cam @ motion
        others = nearby(
            self._Ts_map_cam,
            (keyframe for keyframe in self._keyframes if keyframe != self._reference),
            T_map_cam,
            self._config.keyframes,
        )
        for keyframe in [self._reference, *others[: self._config.relocalisation_tries]]:
            expected = invert(self._Ts_map_cam[keyframe]) @ T_map_cam
            found = self._against(keyframe, features, expected, float(self._intrinsics.width))
            if found is None or found.inliers < self._config.gates.sure_inliers:
                continue
            if self._believed(found, expected, wheels):
                self._reference = keyframe
                return found
        return None

    def _against(
        self, keyframe: int, features: Features, T_keyframe_cam: SE3, radius: float
    ) -> RelativePose | None:
        """Measure the frame against a keyframe; None if they do not match, or not as it turned."""
        known = self._keyframes[keyframe].features
        found = self._match(known, features, T_keyframe_cam, radius)
        return found if found is not None and self._turns_like_gyro(keyframe, found) else None

    def _match(
        self, keyframe: Features, features: Features, T_keyframe_cam: SE3, radius: float
    ) -> RelativePose | None:
        return relative_pose(
            keyframe,
            features,
            T_keyframe_cam,
            radius,
            self._intrinsics,
            self._config.features,
            self._config.odometry,
        )

    def _believed(self, found: RelativePose, predicted: SE3, wheels: bool) -> bool:
        return not wheels or like_wheels(found, predicted, self._unseen_motion, self._config.gates)

    def _turns_like_gyro(self, keyframe: int, found: RelativePose) -> bool:
        """Whether images turn as far since one of the last keyframes as the gyroscope does."""
        before, now = self._keyframes[keyframe].reckoning, self._reckoning
        recent = keyframe >= len(self._Ts_map_cam) - self._config.keyframes.links
        if not recent or before is None or now is None:
            return True
        T_before_now = self._T_base_cam @ found.T_keyframe_cam @ invert(self._T_base_cam)
        return turns_like_gyro(T_before_now, before, now, self._config.gates)

    def _advance(self, measured: RelativePose | None, motion: SE3, wheels: bool) -> None:
        """Take over the pose of a frame in the reference keyframe, and how it was found."""
        before = self._tracking
        if measured is not None:
            self._tracking = Tracking.TRACKING
            self._T_reference_cam = measured.T_keyframe_cam
            self._unseen_motion = np.zeros(2)
        elif wheels:
            self._tracking = Tracking.WHEELS_ONLY
            self._T_reference_cam = self._T_reference_cam @ motion
        else:
            self._tracking = Tracking.LOST
        if self._tracking is not before:
            _log.info("tracking: %s", self._tracking.value)

    def _is_due(self, features: Features, measured: RelativePose | None) -> bool:
        """Whether the frame should become a keyframe."""
        least = 2 * self._config.odometry.min_inliers
        if self._tracking is Tracking.LOST:
            # A keyframe at a guessed place is a lie, unless nothing has been seen before it.
            seen = list(self._keyframes.values())
        else:
            reference = self._keyframes[self._reference]
            if is_due(reference, self._T_reference_cam, measured, self._config.keyframes):
                return True
            seen = [reference]
        return len(features) >= least and all(len(k.features) < least for k in seen)

    def _insert_first(self, features: Features) -> None:
        self._keyframes[0] = Keyframe(features, self._reckoning)
        self._graph.add_keyframe(0, self._T_base_cam, fixed=True)
        self._Ts_map_cam = self._graph.update()
        self._last_features = features
        self._last_measured = _ITSELF

    def _insert(self, features: Features, T_map_cam: SE3, measured: RelativePose | None) -> None:
        """Make the frame a keyframe, link it to those before it, and solve the graph."""
        new, last = len(self._keyframes), len(self._keyframes) - 1
        self._keyframes[new] = Keyframe(features, self._reckoning)
        self._graph.add_keyframe(new, T_map_cam)
        links: dict[int, RelativePose] = {}
        if measured is not None:
            links[self._reference] = measured
        self._link(links, features, T_map_cam)
        for keyframe, link in links.items():
            self._graph.add_image_motion(keyframe, new, link.T_keyframe_cam, link.covariance)
        now, before = self._reckoning, self._keyframes[last].reckoning
        if now is not None:
            self._graph.add_floor(new, T_map_cam)
        if now is not None and before is not None:
            self._graph.add_wheel_motion(last, new, now.since(before))
            if now.gyro_since(before):
                self._graph.add_gyro_turn(last, new, now.since(before))
        elif not links:
            T_last_cam = invert(self._Ts_map_cam[last]) @ T_map_cam
            self._graph.add_unknown_motion(last, new, T_last_cam)
        self._Ts_map_cam = self._graph.update()
        self._reference = new
        self._T_reference_cam = np.eye(4)
        self._last_measured = _ITSELF

    def _link(self, links: dict[int, RelativePose], features: Features, T_map_cam: SE3) -> None:
        """Measure a new keyframe against the last few, and against the nearest of those before."""
        config = self._config
        recent = max(0, len(self._Ts_map_cam) - config.keyframes.links)
        near = nearby(self._Ts_map_cam, self._Ts_map_cam, T_map_cam, config.keyframes)
        closures = [keyframe for keyframe in near if keyframe < recent]
        for keyframe in [k for k in near if k >= recent] + closures[: config.keyframes.closures]:
            if keyframe in links:
                continue
            expected = invert(self._Ts_map_cam[keyframe]) @ T_map_cam
            closes = keyframe < recent
            share = config.closure_search if closes else config.search
            radius = share * self._intrinsics.width
            found = self._against(keyframe, features, expected, radius)
            if found is not None and (
                not closes or closes_loop(found, expected, self._config.gates)
            ):
                links[keyframe] = found

    def _estimate(self, stamp: float, is_keyframe: bool) -> PoseEstimate:
        return PoseEstimate(
            stamp=stamp,
            T_map_cam=self._Ts_map_cam[self._reference] @ self._T_reference_cam,
            keyframe=self._reference,
            T_keyframe_cam=self._T_reference_cam,
            is_keyframe=is_keyframe,
            tracking=self._tracking,
        )
