"""Measures frames in keyframes by images, unless wheels or gyroscope rule the result out."""

from __future__ import annotations

import numpy as np

from mapping.keyframes.frame import Frame, Keyframe
from mapping.odometry.config import FeatureConfig, GatingConfig, OdometryConfig
from mapping.odometry.dead_reckoned_pose import (
    DeadReckonedPose,
    agrees_with_wheels,
    is_not_ruled_out_by_gyro,
)
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose, chained, relative_pose
from vizbot.core.types import SE3, Intrinsics


class FrameMatcher:
    """Measures frames of one camera in keyframes and in each other."""

    def __init__(
        self,
        intrinsics: Intrinsics,
        T_base_cam: SE3,
        features: FeatureConfig,
        odometry: OdometryConfig,
        gates: GatingConfig,
    ) -> None:
        self._intrinsics = intrinsics
        self._T_base_cam = T_base_cam
        self._features = features
        self._odometry = odometry
        self._once = odometry.model_copy(update={"attempts": 1})
        self._gates = gates

    def match(
        self,
        keyframe: Keyframe,
        features: Features,
        T_keyframe_cam: SE3,
        share: float,
        now: DeadReckonedPose | None,
        *,
        once: bool = False,
    ) -> RelativePose | None:
        """Measure a frame in a keyframe; None if too few corners match or the gyroscope objects.

        `T_keyframe_cam` is predicted; `share` is the radius of the search, as a fraction of the
        image's width. With dead reckoning at the frame, `now`, the turn is checked by gyroscope.
        With `once` one minimal pose is tried, however few matches agree: where a frame is linked to
        several keyframes, the graph gives an odd one little weight.
        """
        found = self.between(keyframe.features, features, T_keyframe_cam, share, once=once)
        before, T, gates = keyframe.dead_reckoned, self._T_base_cam, self._gates
        believed = found is not None and is_not_ruled_out_by_gyro(found, T, before, now, gates)
        return found if believed else None

    def between(
        self,
        before: Features,
        features: Features,
        T_before_cam: SE3,
        share: float,
        *,
        once: bool = False,
    ) -> RelativePose | None:
        """Measure a frame in any other image, without a check; arguments as for `match`."""
        return relative_pose(
            before,
            features,
            T_before_cam,
            share * self._intrinsics.width,
            self._intrinsics,
            self._features,
            self._once if once else self._odometry,
        )

    def shows(self, keyframe: Keyframe, features: Features) -> bool:
        """Whether a frame shows what a keyframe shows, whatever its pose should be.

        A frame that does, but whose pose is not believed, is an image that stands still although
        the robot moves: nothing should be measured against it.
        """
        return self.between(keyframe.features, features, np.eye(4), 1.0) is not None

    def track(
        self, keyframe: Keyframe, frame: Frame, last: Frame, shares: tuple[float, ...]
    ) -> RelativePose | None:
        """Measure a frame in the keyframe in which the frame before was measured.

        Where few matches agree, the frame is also measured by way of the frame before, which is
        closest, and in a wider search; the result with most agreeing matches is taken.

        `shares` are radii of the search, one after another, as fractions of the image's width.
        """
        features, now, wheel_only = frame.features, frame.dead_reckoned, frame.wheel_only
        best: RelativePose | None = None
        for share in shares:
            found = self.match(keyframe, features, frame.predicted, share, now)
            if found is not None and agrees_with_wheels(
                found, frame.predicted, wheel_only, self._gates
            ):
                best = found if best is None or found.inliers > best.inliers else best
            if best is not None and best.inliers >= self._gates.sure_inliers:
                break
            if last.measured is None:
                continue
            step = self.between(last.features, features, frame.T_last_cam, share)
            if step is not None and agrees_with_wheels(
                step, frame.T_last_cam, wheel_only, self._gates
            ):
                found = chained(last.measured, step)
                if is_not_ruled_out_by_gyro(
                    found, self._T_base_cam, keyframe.dead_reckoned, now, self._gates
                ):
                    best = found if best is None or found.inliers > best.inliers else best
            if best is not None and best.inliers >= self._gates.sure_inliers:
                break
        return best
