"""Measures frames in keyframes by images, unless wheels or gyroscope rule the result out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.selection import Keyframe
from mapping.keyframes.tracked_pose import TrackedPose
from mapping.odometry.config import FeatureConfig, GatingConfig, OdometryConfig
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.features import Features
from mapping.odometry.gating import agrees_with_gyro, agrees_with_wheels, is_sure, turns_like_gyro
from mapping.odometry.rgbd_odometry import RelativePose, chained, relative_pose
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, Intrinsics


@dataclass(frozen=True, slots=True, eq=False)
class MotionPrior:
    """What is expected of a frame before its image is looked at.

    Attributes:
        T_last_cam: Motion of the camera since the frame before.
        wheel_only: (2,) distance and turn since images were last believed [m, rad]; None without
            wheels.
    """

    T_last_cam: SE3
    wheel_only: NDArray[np.float64] | None


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
        """Measure a frame in a keyframe.

        Args:
            keyframe: Measured against.
            features: Corners of the frame.
            T_keyframe_cam: Predicted pose of the frame.
            share: Radius of the search, as a fraction of the image's width.
            now: Dead reckoning at the frame, to check the turn by gyroscope; None skips the check.
            once: Whether to try one minimal pose only, however few matches agree. Where a frame is
                linked to several keyframes, the graph gives an odd one little weight.

        Returns:
            None if too few corners match, or if the gyroscope contradicts the turn.
        """
        found = self.between(keyframe.features, features, T_keyframe_cam, share, once=once)
        return found if found is not None and self._turns_like_gyro(keyframe, found, now) else None

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
        self,
        keyframe: Keyframe,
        last: tuple[Features, RelativePose] | None,
        features: Features,
        pose: TrackedPose,
        prior: MotionPrior,
        shares: tuple[float, ...],
    ) -> RelativePose | None:
        """Measure a frame in the keyframe in which the frame before was measured.

        Where few matches agree, the frame is also measured by way of the frame before, which is
        closest, and in a wider search; the result with most agreeing matches is taken.

        Args:
            keyframe: The reference keyframe.
            last: Corners of the frame before and its pose in the keyframe; None if images did not
                give that pose.
            features: Corners of the frame.
            pose: Of the frame before, with dead reckoning at this frame.
            prior: The motion since then as predicted.
            shares: Radii of the search, one after another, as fractions of the image's width.
        """
        motion, now = prior.T_last_cam, pose.dead_reckoned
        predicted = pose.T_reference_cam @ motion
        best: RelativePose | None = None
        for share in shares:
            found = self.match(keyframe, features, predicted, share, now)
            if found is not None and self.agrees_with_wheels(found, predicted, prior.wheel_only):
                best = _better(best, found)
            if best is not None and best.inliers >= self._gates.sure_inliers:
                break
            if last is None:
                continue
            step = self.between(last[0], features, motion, share)
            if step is not None and self.agrees_with_wheels(step, motion, prior.wheel_only):
                by_last = chained(last[1], step)
                if self._turns_like_gyro(keyframe, by_last, now):
                    best = _better(best, by_last)
            if best is not None and best.inliers >= self._gates.sure_inliers:
                break
        return best

    def agrees_with_wheels(
        self, found: RelativePose, predicted: SE3, wheel_only: NDArray[np.float64] | None
    ) -> bool:
        """Whether wheels do not rule a pose out; always so without wheels (`wheel_only` None)."""
        return wheel_only is None or agrees_with_wheels(found, predicted, wheel_only, self._gates)

    def agrees_with_gyro(
        self, keyframe: Keyframe, found: RelativePose | None, now: DeadReckonedPose | None
    ) -> bool:
        """Whether images confirm the gyroscope's turn since a keyframe; True if unknown."""
        if keyframe.dead_reckoned is None or now is None or found is None:
            return True
        T_before_now = self._T_base_cam @ found.T_keyframe_cam @ invert(self._T_base_cam)
        return agrees_with_gyro(T_before_now, keyframe.dead_reckoned, now, self._gates)

    def _turns_like_gyro(
        self, keyframe: Keyframe, found: RelativePose, now: DeadReckonedPose | None
    ) -> bool:
        if keyframe.dead_reckoned is None or now is None:
            return True
        T_before_now = self._T_base_cam @ found.T_keyframe_cam @ invert(self._T_base_cam)
        sure = is_sure(found, self._gates)
        return turns_like_gyro(T_before_now, sure, keyframe.dead_reckoned, now, self._gates)


def _better(best: RelativePose | None, found: RelativePose) -> RelativePose:
    return found if best is None or found.inliers > best.inliers else best
