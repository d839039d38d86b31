"""Frames against keyframes: what images say, unless wheels or gyroscope rule it out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.selection import Keyframe
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.features import FeatureConfig, Features
from mapping.odometry.gating import (
    GatingConfig,
    agrees_with_gyro,
    is_sure,
    like_wheels,
    turns_like_gyro,
)
from mapping.odometry.rgbd_odometry import OdometryConfig, RelativePose, chained, relative_pose
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, Intrinsics


class FrameMatcher:
    """Measures frames of one camera."""

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

    def against(
        self,
        keyframe: Keyframe,
        features: Features,
        T_keyframe_cam: SE3,
        share: float,
        now: DeadReckonedPose | None,
        *,
        once: bool = False,
    ) -> RelativePose | None:
        """The frame in a keyframe; None if they do not match, or not as the robot turned.

        Args:
            keyframe: Measured against.
            features: Of the frame.
            T_keyframe_cam: Where it should lie.
            share: Radius of the search, as a fraction of the image's width.
            now: Dead reckoning, to hold it to what the gyroscope says; None does not.
            once: Try one minimal pose, however few matches agree: of several keyframes that a frame
                is linked to, the graph weighs the odd one out.
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
        """Likewise in any other image."""
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
        """Whether a frame shows what a keyframe does, wherever it should be.

        What is not believed all the same stands still, before a robot that moves: it is a lie that
        nothing should be measured against.
        """
        return self.between(keyframe.features, features, np.eye(4), 1.0) is not None

    def step(
        self,
        keyframe: Keyframe,
        last: tuple[Features, RelativePose] | None,
        features: Features,
        T_keyframe_last: SE3,
        motion: SE3,
        shares: tuple[float, ...],
        now: DeadReckonedPose | None,
        unseen: NDArray[np.float64] | None,
    ) -> RelativePose | None:
        """The frame in the keyframe that the one before was measured in.

        Where few matches agree, also by way of the frame before, which is closest, and in a wider
        search; where most agree is believed.

        Args:
            keyframe: The keyframe.
            last: The frame before: what was seen, and where in the keyframe; None if that was not
                measured.
            features: Of the frame.
            T_keyframe_last: Where the frame before was.
            motion: T_last_cam as predicted.
            shares: Radii of the search, one after another.
            now: Dead reckoning; None without wheels.
            unseen: (2,) motion since images were last believed [m, rad]; None without wheels.
        """
        predicted = T_keyframe_last @ motion
        best: RelativePose | None = None
        for share in shares:
            found = self.against(keyframe, features, predicted, share, now)
            if found is not None and self.believed(found, predicted, unseen):
                best = _better(best, found)
            if best is not None and best.inliers >= self._gates.sure_inliers:
                break
            if last is None:
                continue
            step = self.between(last[0], features, motion, share)
            if step is not None and self.believed(step, motion, unseen):
                by_last = chained(last[1], step)
                if self._turns_like_gyro(keyframe, by_last, now):
                    best = _better(best, by_last)
            if best is not None and best.inliers >= self._gates.sure_inliers:
                break
        return best

    def believed(
        self, found: RelativePose, predicted: SE3, unseen: NDArray[np.float64] | None
    ) -> bool:
        """Whether wheels do not rule it out; without them nothing does."""
        return unseen is None or like_wheels(found, predicted, unseen, self._gates)

    def agrees_with_gyro(
        self, keyframe: Keyframe, found: RelativePose | None, now: DeadReckonedPose | None
    ) -> bool:
        """Whether the gyroscope was not outvoted since a keyframe in which the frame was found."""
        if keyframe.reckoning is None or now is None or found is None:
            return True
        T_before_now = self._T_base_cam @ found.T_keyframe_cam @ invert(self._T_base_cam)
        return agrees_with_gyro(T_before_now, keyframe.reckoning, now, self._gates)

    def _turns_like_gyro(
        self, keyframe: Keyframe, found: RelativePose, now: DeadReckonedPose | None
    ) -> bool:
        if keyframe.reckoning is None or now is None:
            return True
        T_before_now = self._T_base_cam @ found.T_keyframe_cam @ invert(self._T_base_cam)
        sure = is_sure(found, self._gates)
        return turns_like_gyro(T_before_now, sure, keyframe.reckoning, now, self._gates)


def _better(best: RelativePose | None, found: RelativePose) -> RelativePose:
    return found if best is None or found.inliers > best.inliers else best
