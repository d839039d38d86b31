"""Selection of keyframes: which frames become one, and which keyframes see the same place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from mapping.keyframes.config import KeyframeConfig
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import rotation_angle
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """What is stored of a frame to measure others against.

    Attributes:
        features: Its corners.
        dead_reckoned: Dead reckoning at the frame; None without a base.
    """

    features: Features
    dead_reckoned: DeadReckonedPose | None


def is_due(
    keyframe: Keyframe,
    T_keyframe_cam: SE3,
    measured: RelativePose | None,
    config: KeyframeConfig,
) -> bool:
    """Whether a frame at `T_keyframe_cam` of a keyframe should become the next."""
    if not is_covered(T_keyframe_cam, config):
        return True
    enough = min(config.inliers, config.inlier_share * len(keyframe.features))
    return measured is not None and measured.inliers < enough


def is_covered(T_keyframe_cam: SE3, config: KeyframeConfig) -> bool:
    """Whether a keyframe shows what a frame at `T_keyframe_cam` of it shows."""
    near = np.linalg.norm(T_keyframe_cam[:3, 3]) < config.distance
    return bool(near and rotation_angle(T_keyframe_cam) < config.angle)


def nearby(
    Ts_map_cam: Mapping[int, SE3],
    candidates: Iterable[int],
    T_map_cam: SE3,
    config: KeyframeConfig,
) -> list[int]:
    """Those of `candidates` that may see what a camera at `T_map_cam` sees, nearest first."""
    keyframes = np.fromiter(candidates, np.int64)
    if len(keyframes) == 0:
        return []
    Ts_near = np.stack([Ts_map_cam[int(keyframe)] for keyframe in keyframes])
    distances = np.linalg.norm(Ts_near[:, :3, 3] - T_map_cam[:3, 3], axis=1)
    traces = np.einsum("nij,ij->n", Ts_near[:, :3, :3], T_map_cam[:3, :3])
    angles = np.arccos(np.clip((traces - 1) / 2, -1, 1))
    remoteness = distances / config.closure_distance + angles / config.closure_angle
    near = (distances <= config.closure_distance) & (angles <= config.closure_angle)
    order = np.argsort(remoteness[near], kind="stable")
    return [int(keyframe) for keyframe in keyframes[near][order]]
