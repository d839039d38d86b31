"""Gates: which motions by images are believed against wheels, gyroscope and the pose graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.odometry.config import GatingConfig
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import invert, rotation_angle, wrap_angle, yaw_of
from vizbot.core.types import SE3


def agrees_with_wheels(
    found: RelativePose, predicted: SE3, wheel_only: NDArray[np.float64], config: GatingConfig
) -> bool:
    """Whether a pose by images is near enough to dead reckoning.

    The fewer matches agree on the pose, the nearer it must be. Many may contradict dead reckoning
    altogether, for wheels slip.

    Args:
        found: By images.
        predicted: The same pose by dead reckoning.
        wheel_only: (2,) distance and turn since images were last believed [m, rad].
        config: The gates.
    """
    if is_sure(found, config):
        return True
    support = found.inliers / (2 * config.sure_inliers)
    step, turn = min(support, 1.0) * (config.wheel_gate + config.wheel_gate_growth * wheel_only)
    T_predicted_cam = invert(predicted) @ found.T_keyframe_cam
    near = np.linalg.norm(T_predicted_cam[:3, 3]) < step
    return bool(near and rotation_angle(T_predicted_cam) < turn)


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

    Args:
        T_before_now: Motion of the base, by images.
        sure: Whether many matches agree on it.
        before: Dead reckoning at the start of the motion.
        now: Dead reckoning at its end.
        config: The gates.
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


def is_sure(found: RelativePose, config: GatingConfig) -> bool:
    """Whether enough matches agree for images to be believed against wheels, which slip."""
    many = found.inliers >= 2 * config.sure_inliers
    return many and found.inlier_fraction >= config.sure_fraction


def _difference(a: float, b: float) -> float:
    return abs(wrap_angle(a - b))


def may_link(
    found: RelativePose, expected: SE3, T_base_cam: SE3 | None, config: GatingConfig
) -> bool:
    """Whether a pose by images is sure enough, and near enough to the graph, to link keyframes.

    Args:
        found: One camera in another, by images.
        expected: The same, by the graph.
        T_base_cam: Where the camera sits on a base with wheels; None without wheels.
        config: The gates.
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
