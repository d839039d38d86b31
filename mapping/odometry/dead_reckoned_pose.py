"""The pose of the base by wheels and gyroscope, its uncertainty, and gates against images.

A gate says which motions by images are believed against wheels, gyroscope and the pose graph.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapping.odometry.config import GatingConfig
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import invert, rotation_angle, wrap_angle, yaw_of
from vizbot.core.types import SE3

_BIAS_LASTS = 100.0
"""Time for which the error of the bias keeps its sign [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class DeadReckonedPose:
    """Pose of the base by dead reckoning, at one frame.

    Attributes:
        T_odom_base: By wheels and gyroscope, in the frame in which the wheels' own dead reckoning
            started.
        T_wheels_base: By the wheels alone.
        frames_without_gyro: Number of frames so far whose turn the wheels had to give.
        stamp: Time of the frame [s].
        turn_variance: Variance of all turns by gyroscope so far by its white noise [rad^2].
        bias_sigma: Standard deviation of the gyroscope's bias [rad/s].
        scale_sigma: Standard deviation of the gyroscope's scale.
        turned: Sum of all turns so far, left positive [rad].
    """

    T_odom_base: SE3
    T_wheels_base: SE3
    frames_without_gyro: int
    stamp: float
    turn_variance: float
    bias_sigma: float
    scale_sigma: float
    turned: float

    def gyro_since(self, before: DeadReckonedPose) -> bool:
        """Whether the gyroscope measured all turns since `before`."""
        return self.frames_without_gyro == before.frames_without_gyro

    def chained_gyro_sigma_since(self, before: DeadReckonedPose) -> float:
        """Standard deviation of the gyroscope's turn since `before`, as one link of a chain [rad].

        A pose graph takes the errors of its links for independent, but the bias errs one way in
        all of them. So each gets more of it, for the sum to be as uncertain as it truly is when the
        robot closes a loop.
        """
        noise = self.turn_variance - before.turn_variance
        period = self.stamp - before.stamp
        by_bias = self.bias_sigma**2 * period * max(period, _BIAS_LASTS)
        by_scale = self.scale_sigma * (self.turned - before.turned)
        return float(np.sqrt(noise + by_bias + by_scale**2))

    def since(self, before: DeadReckonedPose) -> SE3:
        """Motion of the base since `before`, T_before_now."""
        return invert(before.T_odom_base) @ self.T_odom_base

    def by_wheels_since(self, before: DeadReckonedPose) -> SE3:
        """Motion of the base since `before` by the wheels alone."""
        return invert(before.T_wheels_base) @ self.T_wheels_base

    def displaced(self, T_now_there: SE3, heading_variance: float) -> DeadReckonedPose:
        """Dead reckoning as if the base stood at `T_now_there` from where it is.

        Turns from there on are no better known than that heading, by its variance [rad^2].
        """
        return replace(
            self,
            T_odom_base=self.T_odom_base @ T_now_there,
            T_wheels_base=self.T_wheels_base @ T_now_there,
            turn_variance=self.turn_variance - heading_variance,
        )


def agrees_with_wheels(
    found: RelativePose,
    predicted: SE3,
    wheel_only: NDArray[np.float64] | None,
    config: GatingConfig,
) -> bool:
    """Whether a pose by images is near enough to dead reckoning; without wheels each is.

    The fewer matches agree on the pose, the nearer it must be. Many may contradict dead reckoning
    altogether, for wheels slip.

    `wheel_only` (2,) is distance and turn since images were last believed [m, rad]; None without
    wheels.
    """
    if wheel_only is None or _is_sure(found, config):
        return True
    support = found.inliers / (2 * config.sure_inliers)
    step, turn = min(support, 1.0) * (config.wheel_gate + config.wheel_gate_growth * wheel_only)
    T_predicted_cam = invert(predicted) @ found.T_keyframe_cam
    near = np.linalg.norm(T_predicted_cam[:3, 3]) < step
    return bool(near and rotation_angle(T_predicted_cam) < turn)


def is_not_ruled_out_by_gyro(
    found: RelativePose,
    T_base_cam: SE3,
    before: DeadReckonedPose | None,
    now: DeadReckonedPose | None,
    config: GatingConfig,
) -> bool:
    """Whether a camera turned as far as the gyroscope measured; so it did without dead reckoning.

    Arguments as for `turns_like_gyro`.
    """
    if before is None or now is None:
        return True
    T_before_now = T_base_cam @ found.T_keyframe_cam @ invert(T_base_cam)
    return turns_like_gyro(T_before_now, _is_sure(found, config), before, now, config)


def turns_like_gyro(
    T_before_now: SE3,
    sure: bool,
    before: DeadReckonedPose,
    now: DeadReckonedPose,
    config: GatingConfig,
) -> bool:
    """Whether a motion turns as far as the gyroscope measured; True where it did not measure.

    A plain wall, or tiles that repeat, look alike after a step aside. Wheels and images together
    outvote the gyroscope: wheels must agree much better with the images than with it, and either
    the images are sure, or wheels rule the gyroscope out by themselves.

    `T_before_now` is the motion of the base by images; `sure`: many matches agree on it.
    """
    if agrees_with_gyro(T_before_now, before, now, config):
        return True
    images, gyro = yaw_of(T_before_now), yaw_of(now.since(before))
    wheels = yaw_of(now.by_wheels_since(before))
    gate = config.wheel_turn_gate + config.wheel_turn_gate_growth * abs(wheels)
    disagreement = _difference(gyro, wheels)
    agrees = _difference(images, wheels) < min(gate, 0.5 * disagreement)
    return agrees and (sure or gate < disagreement)


def agrees_with_gyro(
    T_before_now: SE3, before: DeadReckonedPose, now: DeadReckonedPose, config: GatingConfig
) -> bool:
    """As `turns_like_gyro`, without a vote: whether images and gyroscope agree on a turn."""
    if not now.gyro_since(before):
        return True
    gyro = yaw_of(now.since(before))
    gate = config.gyro_gate + config.gyro_gate_growth * abs(gyro)
    return _difference(yaw_of(T_before_now), gyro) < gate


def _is_sure(found: RelativePose, config: GatingConfig) -> bool:
    """Whether enough matches agree for images to be believed against wheels, which slip."""
    many = found.inliers >= 2 * config.sure_inliers
    return many and found.inlier_fraction >= config.sure_fraction


def _difference(a: float, b: float) -> float:
    return abs(wrap_angle(a - b))


def may_link(
    found: RelativePose, expected: SE3, T_base_cam: SE3 | None, config: GatingConfig
) -> bool:
    """Whether a pose by images is sure enough, and near enough to the graph, to link keyframes.

    `found` and `expected` by the graph are one camera in another; `T_base_cam` is None without
    wheels.
    """
    T_expected_cam = invert(expected) @ found.T_keyframe_cam
    moved = max(float(np.linalg.norm(T_expected_cam[:3, 3])), rotation_angle(T_expected_cam))
    return (
        found.inliers >= config.sure_inliers
        and found.inlier_fraction >= config.sure_fraction
        and moved < config.closure_gate
        and (T_base_cam is None or _stays_level(T_expected_cam, T_base_cam, config))
    )


def _stays_level(T_expected_cam: SE3, T_base_cam: SE3, config: GatingConfig) -> bool:
    T_expected_base = T_base_cam @ T_expected_cam @ invert(T_base_cam)
    tilt = np.arccos(np.clip(T_expected_base[2, 2], -1.0, 1.0))
    return bool(abs(T_expected_base[2, 3]) < config.closure_height and tilt < config.closure_tilt)
