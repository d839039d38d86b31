"""Pose estimation: images and wheels, joined in a graph over keyframes.

Every frame is measured against a keyframe. Where images say too little (white walls, darkness) the
wheels carry the pose; without wheels tracking is lost until a frame matches a keyframe again.
"""

from __future__ import annotations

import logging
import sys

import numpy as np
from pydantic import BaseModel

from mapping.features import NO_FEATURES, FeatureConfig, Features, detect
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
    search: float = 0.07
    """Radius of the search around a predicted corner, as a fraction of the image's width."""
    wide_search: float = 0.5
    """The same where the motion was not as predicted."""
    closure_search: float = 0.2
    """The same where a loop may close, after some drift."""
    relocalisation_tries: int = 3
    """Other keyframes a frame is compared with when the last one does not match."""
    sure_inliers: int = 30
    """Matches that must agree where the prediction is poor: closures, tracking regained."""
    wheel_gate: float = 0.1
    """Images may contradict wheels by this much [m, rad] ..."""
    wheel_gate_growth: float = 0.5
    """... and by this fraction of the motion since images were last believed."""
    closure_gate: float = 1.0
    """A closure may move a keyframe by this much at most [m, rad]."""


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
        self._keyframes: dict[int, Keyframe] = {}
        self._Ts_map_cam: dict[int, SE3] = {}
        self._reference = 0
        self._T_reference_cam = np.eye(4)
        self._T_odom_base: SE3 | None = None
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
        features = detect(frame, self._config.features)
        if not self._keyframes:
            self._insert_first(features, T_odom_base)
            return self._estimate(frame.stamp, True)
        motion = self._wheel_motion(T_odom_base)
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
        self._T_odom_base = T_odom_base
        due = self._is_due(features, measured)
        if due:
            self._insert(features, T_map_cam, T_odom_base, measured)
        return self._estimate(frame.stamp, due)

    def _wheel_motion(self, T_odom_base: SE3 | None) -> SE3 | None:
        """T_last_cam by the wheels since the frame before; None without wheels."""
        if T_odom_base is None or self._T_odom_base is None:
            return None
        T_last_base = invert(self._T_odom_base) @ T_odom_base
        return invert(self._T_base_cam) @ T_last_base @ self._T_base_cam

    def _measure(self, features: Features, motion: SE3, wheels: bool) -> RelativePose | None:
        """Measure the frame against the reference, where it should lie after `motion`.

        Where that fails, by way of the frame before, which is closest.
        """
        predicted = self._T_reference_cam @ motion
        reference = self._keyframes[self._reference].features
        for share in (self._config.search, self._config.wide_search):
            radius = share * self._intrinsics.width
            found = self._match(reference, features, predicted, radius)
            if found is not None and self._believed(found, predicted, wheels):
                return found
            if self._last_measured is None:
                continue
            found = self._match(self._last_features, features, motion, radius)
            if found is not None and self._believed(found, motion, wheels):
                return chained(self._last_measured, found)
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
            known = self._keyframes[keyframe].features
            expected = invert(self._Ts_map_cam[keyframe]) @ T_map_cam
            found = self._match(known, features, expected, float(self._intrinsics.width))
            if found is None or found.inliers < self._config.sure_inliers:
                continue
            if self._believed(found, expected, wheels):
                self._reference = keyframe
                return found
        return None

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
        """Whether images are believed: the fewer matches, the closer they must be to the wheels.

        Many contradict wheels altogether, which slip.
        """
        if not wheels:
            return True
        config = self._config
        support = found.inliers / (2 * config.sure_inliers)
        if support >= 1.0 and found.inlier_fraction >= 0.6:
            return True
        gates = config.wheel_gate + config.wheel_gate_growth * self._unseen_motion
        step, turn = min(support, 1.0) * gates
        T_predicted_cam = invert(predicted) @ found.T_keyframe_cam
        near = np.linalg.norm(T_predicted_cam[:3, 3]) < step
        return bool(near and rotation_angle(T_predicted_cam) < turn)

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

    def _insert_first(self, features: Features, T_odom_base: SE3 | None) -> None:
        self._keyframes[0] = Keyframe(features, T_odom_base)
        self._graph.add_keyframe(0, self._T_base_cam, fixed=True)
        self._Ts_map_cam = self._graph.update()
        self._T_odom_base = T_odom_base
        self._last_features = features
        self._last_measured = _ITSELF

    def _insert(
        self,
        features: Features,
        T_map_cam: SE3,
        T_odom_base: SE3 | None,
        measured: RelativePose | None,
    ) -> None:
        """Make the frame a keyframe, link it to those before it, and solve the graph."""
        new, last = len(self._keyframes), len(self._keyframes) - 1
        self._keyframes[new] = Keyframe(features, T_odom_base)
        self._graph.add_keyframe(new, T_map_cam)
        links: dict[int, RelativePose] = {}
        if measured is not None:
            links[self._reference] = measured
        self._link(links, features, T_map_cam)
        for keyframe, link in links.items():
            self._graph.add_image_motion(keyframe, new, link.T_keyframe_cam, link.covariance)
        T_odom_last = self._keyframes[last].T_odom_base
        if T_odom_base is not None:
            self._graph.add_floor(new, T_map_cam)
        if T_odom_base is not None and T_odom_last is not None:
            self._graph.add_wheel_motion(last, new, invert(T_odom_last) @ T_odom_base)
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
            known = self._keyframes[keyframe].features
            expected = invert(self._Ts_map_cam[keyframe]) @ T_map_cam
            closes = keyframe < recent
            share = config.closure_search if closes else config.search
            found = self._match(known, features, expected, share * self._intrinsics.width)
            if found is not None and (not closes or self._closes(found, expected)):
                links[keyframe] = found

    def _closes(self, found: RelativePose, expected: SE3) -> bool:
        """Whether a measurement is sure enough, and near enough to the graph, to close a loop."""
        T_expected_cam = invert(expected) @ found.T_keyframe_cam
        moved = max(float(np.linalg.norm(T_expected_cam[:3, 3])), rotation_angle(T_expected_cam))
        return found.inliers >= self._config.sure_inliers and moved < self._config.closure_gate

    def _estimate(self, stamp: float, is_keyframe: bool) -> PoseEstimate:
        return PoseEstimate(
            stamp=stamp,
            T_map_cam=self._Ts_map_cam[self._reference] @ self._T_reference_cam,
            keyframe=self._reference,
            T_keyframe_cam=self._T_reference_cam,
            is_keyframe=is_keyframe,
            tracking=self._tracking,
        )
