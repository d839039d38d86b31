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
from mapping.keyframes.frame import Frame, KeyframeMatch
from mapping.keyframes.frame_matcher import FrameMatcher
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.wheel_only_motion import WheelOnlyMotion
from mapping.odometry.dead_reckoned_pose import agrees_with_wheels
from mapping.odometry.dead_reckoning import DeadReckoning
from mapping.odometry.features import NO_FEATURES, Features, detect
from mapping.odometry.rgbd_odometry import RelativePose
from mapping.relocalisation.depth_consistency import DepthConsistency
from mapping.relocalisation.kidnapping import Kidnapping
from mapping.relocalisation.local_map import LocalMap
from mapping.relocalisation.relocaliser import Relocaliser
from mapping.slam.config import SlamConfig
from mapping.slam.loop_closure import LoopClosure
from vizbot.core.errors import MapError
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, ImuSamples, Intrinsics, PoseEstimate, RGBDFrame, Tracking

_log = logging.getLogger(__name__)

_ITSELF = RelativePose(np.eye(4), np.zeros((6, 6)), sys.maxsize, 1.0)
"""Pose of a keyframe in its own camera."""


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
        """Start with an empty map; without a `local_map` images alone relocalise a lost robot."""
        self._T_base_cam = T_base_cam
        self._config = config
        self._dead_reckoning = DeadReckoning(T_base_cam, config.dead_reckoning)
        consistency = DepthConsistency(intrinsics, T_base_cam, config.depth_consistency)
        self._kidnapping = Kidnapping(intrinsics, consistency, config.kidnapping)
        self._map = KeyframeMap(
            FrameMatcher(intrinsics, T_base_cam, config.features, config.odometry, config.gates),
            T_base_cam,
            config.keyframes,
            config.graph,
            config.place_index,
            config.gates,
        )
        self._relocaliser = Relocaliser(
            self._map, intrinsics, T_base_cam, consistency, config.relocalisation, local_map
        )
        self._loops = LoopClosure(self._map, self._relocaliser, T_base_cam, config)
        self._wheel_only = WheelOnlyMotion()
        rgb, depth = np.zeros((0, 0, 3), np.uint8), np.zeros((0, 0), np.float32)
        self._last = Frame(RGBDFrame(0.0, rgb, depth, intrinsics, ImuSamples.none()))
        self._in_saved_map = False

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
        reference = int(keyframes.ids[0])
        self._last = replace(self._last, reference=reference, tracking=Tracking.LOST)

    def track(self, frame: RGBDFrame, T_odom_base: SE3 | None) -> PoseEstimate:
        """Estimate where `frame` was taken.

        Args:
            frame: Newer than any before.
            T_odom_base: Dead reckoning by the wheels at that time; None without a base.
        """
        poses, last = self._map.poses, self._last
        seen = self._see(frame, T_odom_base)
        if not poses:
            first = replace(seen, reference=self._map.add_first(seen), measured=_ITSELF)
            return self._estimate(first, frame.stamp, True)
        T_map_last = poses[last.reference] @ last.T_reference_cam
        found = self._locate(seen)
        T_map_cam = self._map.poses[found.reference] @ found.T_reference_cam
        regular = found.tracking is Tracking.TRACKING
        found = replace(found, T_last_cam=invert(T_map_last) @ T_map_cam if regular else np.eye(4))
        if not self._is_due(found):
            return self._estimate(found, frame.stamp, False)
        reused = self._reuse_keyframe(found)
        kept = self._insert(found) if reused is None else reused
        return self._estimate(kept, frame.stamp, reused is None)

    def lift(self, stamp: float) -> PoseEstimate:
        """Note that the robot hangs in the air: it is lost until it recognises where it stands.

        Args:
            stamp: Of a frame that is not used, not the first one [s].
        """
        self._kidnapping.reset()
        self._relocaliser.reset()
        lost = replace(self._last, measured=None, dead_reckoned=None, tracking=Tracking.LOST)
        return self._estimate(lost, stamp, False)

    def _see(self, image: RGBDFrame, T_odom_base: SE3 | None) -> Frame:
        """The features of the newest frame, and its pose as expected from the frame before."""
        last, now = self._last, None
        if T_odom_base is not None:
            now = self._dead_reckoning.update(image, T_odom_base)
        features = detect(image, self._config.features)
        motion, wheel_only = last.T_last_cam, None
        if now is not None and last.dead_reckoned is not None:
            T_last_base = now.since(last.dead_reckoned)
            motion = invert(self._T_base_cam) @ T_last_base @ self._T_base_cam
            self._wheel_only.add_step(motion, now.gyro_since(last.dead_reckoned))
            wheel_only = self._wheel_only.motion
        return replace(
            last,
            image=image,
            features=features,
            dead_reckoned=now,
            T_last_cam=motion,
            wheel_only=wheel_only,
            predicted=last.T_reference_cam @ motion,
            measured=None,
        )

    def _locate(self, frame: Frame) -> Frame:
        """Find the pose of a frame in a keyframe, and judge what it rests on."""
        config, before = self._config, frame.tracking
        if before is Tracking.LOST:
            found, now = self._relocalise(frame), Tracking.RELOCALISED
        else:
            shares = config.search_radius, config.wide_search_radius
            measured, now = self._map.track(frame, self._last, shares), Tracking.TRACKING
            found = self._regain(frame) if measured is None else replace(frame, measured=measured)
        if found is not None and found.measured is not None:
            self._kidnapping.confirm(found.reference, found.measured)
            self._wheel_only.reset()
            frame = replace(found, T_reference_cam=found.measured.T_keyframe_cam)
        else:
            lost = frame.wheel_only is None or before is Tracking.LOST
            lost = lost or self._is_carried_away(frame)
            now = Tracking.LOST if lost else Tracking.WHEELS_ONLY
            if frame.wheel_only is not None:
                frame = replace(frame, T_reference_cam=frame.predicted)
        if now is not before:
            _log.info("tracking: %s", now.value)
        return replace(frame, tracking=now)

    def _relocalise(self, frame: Frame) -> Frame | None:
        """Find the pose of a frame anywhere in the map, for a robot that may have been carried."""
        found = self._relocaliser.recognise(frame)
        if found is None:
            return None
        self._relocaliser.reset()
        self._kidnapping.forget_confirmed()
        self._map.forget_dead_reckoning()
        return self._refer_to_seen(frame, found)

    def _regain(self, frame: Frame) -> Frame | None:
        """Find the pose of a frame in keyframes near by, which ends a stretch by wheels alone."""
        config, keyframes, reference = self._config, self._map, frame.reference
        T_map_cam = keyframes.poses[reference] @ frame.predicted
        others = keyframes.nearby(T_map_cam, but=reference)
        for keyframe in [reference, *others[: config.nearby_tries]]:
            expected = invert(keyframes.poses[keyframe]) @ T_map_cam
            for found in keyframes.matches(frame, {keyframe: (expected, 1.0)}).values():
                if found.inliers < config.gates.sure_inliers or not agrees_with_wheels(
                    found, expected, frame.wheel_only, config.gates
                ):
                    continue
                if frame.wheel_only is not None and keyframe != reference:
                    T_reference_keyframe = frame.predicted @ invert(found.T_keyframe_cam)
                    since = self._wheel_only.since_reference
                    keyframes.add_wheel_only_link(reference, keyframe, T_reference_keyframe, since)
                return self._refer_to_seen(frame, KeyframeMatch(keyframe, found))
        return None

    def _refer_to_seen(self, frame: Frame, match: KeyframeMatch) -> Frame:
        """Refer to another keyframe from now on, in which images found the frame."""
        self._wheel_only.close_spans(match.keyframe)
        return replace(self._refer_to(frame, match), measured=match.pose)

    def _refer_to_blank(self, frame: Frame) -> Frame | None:
        """Continue in the dark from an older blank keyframe, if one is near enough."""
        T_map_cam = self._map.poses[frame.reference] @ frame.T_reference_cam
        keyframe = self._map.nearest_blank(T_map_cam)
        if keyframe is None:
            return None
        T_keyframe_cam = invert(self._map.poses[keyframe]) @ T_map_cam
        step, turn = self._config.gates.wheel_gate + self._wheel_only.motion
        covariance = np.diag(np.repeat((turn, step), 3) ** 2)
        match = KeyframeMatch(keyframe, RelativePose(T_keyframe_cam, covariance, 0, 1.0))
        frame = self._refer_to(frame, match)
        self._wheel_only.branch_span()
        return frame

    def _refer_to(self, frame: Frame, match: KeyframeMatch) -> Frame:
        keyframe, found = match.keyframe, match.pose
        if keyframe == frame.reference and keyframe in self._map.recent():
            return frame
        self._map.restart_dead_reckoning(keyframe, found, frame.dead_reckoned)
        return replace(frame, reference=keyframe, T_reference_cam=found.T_keyframe_cam)

    def _is_carried_away(self, frame: Frame) -> bool:
        """Whether images that agree with each other have long shown that the robot is elsewhere."""
        last, share = self._last.features, self._config.search_radius
        step = self._map.matcher.between(last, frame.features, frame.T_last_cam, share)
        steady = 0 if step is None else step.inliers
        return self._kidnapping.is_elsewhere(frame, last, steady, self._map)

    def _is_due(self, frame: Frame) -> bool:
        """Whether a frame should become a keyframe."""
        least = 2 * self._config.odometry.min_inliers
        keyframes, measured = self._map, frame.measured
        if frame.tracking is Tracking.LOST:
            # A keyframe at a guessed pose would be wrong, unless nothing was seen before it.
            if self._in_saved_map:
                return False
            seen = list(keyframes.poses)
        elif measured is None and self._kidnapping.doubts:
            return False
        elif self._is_blank(frame):
            # Only frames that are mapped in the dark depend on it.
            distance = float(np.linalg.norm(frame.T_reference_cam[:3, 3]))
            return distance > self._config.keyframes.blank_distance
        else:
            if keyframes.is_due(frame.reference, frame.T_reference_cam, measured):
                reference = keyframes[frame.reference]
                return measured is not None or not keyframes.matcher.shows(
                    reference, frame.features
                )
            seen = [frame.reference]
        return len(frame.features.pixels) >= least and keyframes.show_less(seen, least)

    def _is_blank(self, frame: Frame) -> bool:
        """Whether a frame shows too little to be matched, as in the dark or before a bare wall."""
        few = len(frame.features.pixels) < 2 * self._config.odometry.min_inliers
        return frame.measured is None and few

    def _reuse_keyframe(self, frame: Frame) -> Frame | None:
        """Refer to an older keyframe that serves as well as a new one; None without one."""
        if frame.measured is None:
            return self._refer_to_blank(frame) if self._is_blank(frame) else None
        found = self._loops.close(frame, self._wheel_only.spans)
        return None if found is None else self._refer_to_seen(frame, found)

    def _insert(self, frame: Frame) -> Frame:
        """Make a frame a keyframe."""
        features = NO_FEATURES if self._is_blank(frame) else frame.features
        reference = self._map[frame.reference]
        self._dead_reckoning.learn(reference.dead_reckoned, frame.measured)
        links = self._loops.links(frame)
        for keyframe in links:
            if keyframe != frame.reference:
                self._wheel_only.close_spans(keyframe)
        new = self._map.insert(frame, features, links, self._wheel_only.since_reference)
        self._wheel_only.reset_reference()
        if not links:
            self._wheel_only.start_span(new, self._config.keyframes)
        return replace(frame, reference=new, T_reference_cam=np.eye(4), measured=_ITSELF)

    def _estimate(self, frame: Frame, stamp: float, new: bool) -> PoseEstimate:
        """The pose of a frame, on which nothing changes any more."""
        self._last = frame
        return PoseEstimate(
            stamp,
            self._map.poses[frame.reference] @ frame.T_reference_cam,
            frame.reference,
            frame.T_reference_cam,
            new,
            frame.tracking,
            None if frame.measured is None else frame.measured.covariance,
        )
