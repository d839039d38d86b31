"""What images are believed about motion, when wheels, gyroscope or the graph say something else."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import invert, rotation_angle, wrap_angle, yaw_of
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3


class GatingConfig(BaseModel):
    """How far images may contradict the other sources."""

    model_config = SETTINGS
    sure_inliers: int = 30
    """Matches that must agree where the prediction is poor, closures and tracking regained, and
    where a keyframe is linked to others than the last ..."""
    sure_fraction: float = 0.6
    """... and their share of all matches."""
    wheel_gate: float = 0.1
    """Images may contradict dead reckoning by this much [m, rad] ..."""
    wheel_gate_growth: float = 0.5
    """... and by this fraction of the motion since images were last believed."""
    gyro_gate: float = 0.01
    """Images may turn by this much more or less than the gyroscope since a keyframe [rad] ..."""
    gyro_gate_growth: float = 0.02
    """... and by this fraction of the angle."""
    wheel_turn_gate: float = 0.03
    """Wheels turn by this much more or less than images at most, unless they slip [rad] ..."""
    wheel_turn_gate_growth: float = 0.15
    """... and by this fraction of the angle."""
    spin: float = 0.5
    """Where wheels alone had the word, they are off by this share of the way at most. More would
    take the next of two rooms that look the same for the first one."""
    closure_gate: float = 1.0
    """A closure may move a keyframe by this much at most [m, rad], ..."""
    closure_height: float = 0.03
    """... of that, with wheels on a floor, up or down by this much [m] ..."""
    closure_tilt: float = 0.02
    """... and tilt it by this much [rad]: curtains repeat, and match after such a step."""


def like_wheels(
    found: RelativePose, predicted: SE3, unseen: NDArray[np.float64], config: GatingConfig
) -> bool:
    """Whether images move enough like dead reckoning: the fewer matches, the closer they must be.

    Many contradict it altogether, for wheels slip.

    Args:
        found: By images.
        predicted: The same pose by dead reckoning.
        unseen: (2,) motion since images were last believed [m, rad].
        config: The gates.
    """
    if is_sure(found, config):
        return True
    support = found.inliers / (2 * config.sure_inliers)
    step, turn = min(support, 1.0) * (config.wheel_gate + config.wheel_gate_growth * unseen)
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
    """Whether a motion turns as far as the gyroscope says; True where it does not know.

    A plain wall, or tiles that repeat, look alike after a step aside. A gyroscope that has wheels
    and images against it is outvoted: wheels must turn much more like the images than like it, and
    either the images are sure, or wheels rule it out by themselves.

    Args:
        T_before_now: Of the base, by images.
        sure: Whether many matches agree on that.
        before: Dead reckoning where the motion began.
        now: And where it ended.
        config: The gates.
    """
    if agrees_with_gyro(T_before_now, before, now, config):
        return True
    images, gyro = yaw_of(T_before_now), yaw_of(now.since(before))
    wheels = yaw_of(now.by_wheels_since(before))
    gate = config.wheel_turn_gate + config.wheel_turn_gate_growth * abs(wheels)
    alike = min(gate, 0.5 * _apart(gyro, wheels))
    return _apart(images, wheels) < alike and (sure or gate < _apart(gyro, wheels))


def agrees_with_gyro(
    T_before_now: SE3, before: DeadReckonedPose, now: DeadReckonedPose, config: GatingConfig
) -> bool:
    """The same without a vote: whether nothing speaks against the gyroscope since then."""
    if not now.gyro_since(before):
        return True
    gyro = yaw_of(now.since(before))
    gate = config.gyro_gate + config.gyro_gate_growth * abs(gyro)
    return _apart(yaw_of(T_before_now), gyro) < gate


def is_sure(found: RelativePose, config: GatingConfig) -> bool:
    """Whether so many matches agree that images are believed against wheels, which slip."""
    many = found.inliers >= 2 * config.sure_inliers
    return many and found.inlier_fraction >= config.sure_fraction


def _apart(a: float, b: float) -> float:
    return abs(wrap_angle(a - b))


def may_link(
    found: RelativePose, expected: SE3, T_base_cam: SE3 | None, config: GatingConfig
) -> bool:
    """Whether a measurement is sure enough, and near enough to the graph, to link keyframes.

    Args:
        found: A camera in another one.
        expected: The same by the graph.
        T_base_cam: Where the camera sits on a base with wheels; None without.
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
