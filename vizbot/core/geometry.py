"""Rigid transforms as (4, 4) float64 arrays, and the pinhole camera."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import SE3, Intrinsics

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

R_BASE_CAM = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Rotation of a camera that looks straight ahead: `cam` axes in `base`."""


def invert(T_a_b: SE3) -> SE3:
    """Inverse of a rigid transform, T_b_a."""
    R_b_a = T_a_b[:3, :3].T
    T_b_a = np.eye(4)
    T_b_a[:3, :3] = R_b_a
    T_b_a[:3, 3] = -R_b_a @ T_a_b[:3, 3]
    return T_b_a


def transform(T_a_b: SE3, points_b: NDArray[np.floating]) -> NDArray[np.float64]:
    """Points (..., 3) of frame b in frame a, float64."""
    return points_b @ T_a_b[:3, :3].T + T_a_b[:3, 3]


def planar(x: float, y: float, yaw: float) -> SE3:
    """Transform of a base on the floor: position [m] and heading [rad, counter-clockwise]."""
    c, s = float(np.cos(yaw)), float(np.sin(yaw))
    return np.array(
        [[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]], np.float64
    )


def yaw_of(T_a_b: SE3) -> float:
    """Heading of b's x axis in the x-y plane of a [rad, -pi to pi]."""
    return float(np.arctan2(T_a_b[1, 0], T_a_b[0, 0]))


def wrap_angle(angle: float) -> float:
    """The same angle in [-pi, pi)."""
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def camera_mount(
    height: float,
    forward: float,
    tilt: float,
    left: float = 0.0,
    yaw: float = 0.0,
    roll: float = 0.0,
) -> SE3:
    """T_base_cam of a camera on a mast.

    Args:
        height: Height of the optical centre above the floor [m].
        forward: Distance of the optical centre ahead of the wheel axle [m].
        tilt: Angle by which the camera looks down from the horizontal [rad].
        left: Distance of the optical centre to the left of the middle of the axle [m].
        yaw: Angle by which the camera looks to the left of the base's heading [rad].
        roll: Angle about the optical axis, positive when the camera's right side is lower [rad].
    """
    T_base_cam = np.eye(4)
    R_base_level = _rotations().from_euler("ZYX", (yaw, tilt, roll)).as_matrix()
    T_base_cam[:3, :3] = R_base_level @ R_BASE_CAM
    T_base_cam[:3, 3] = forward, left, height
    return T_base_cam


def mount_angles(T_base_cam: SE3) -> tuple[float, float, float]:
    """Yaw, tilt and roll [rad] of a `camera_mount`."""
    R_base_level = T_base_cam[:3, :3] @ R_BASE_CAM.T
    yaw, tilt, roll = _rotations().from_matrix(R_base_level).as_euler("ZYX")
    return float(yaw), float(tilt), float(roll)


def from_quat_xyzw(translation: NDArray[np.float64], quat_xyzw: NDArray[np.float64]) -> SE3:
    """Transform from a translation (3,) [m] and a quaternion (4,), need not be unit."""
    T = np.eye(4)
    T[:3, :3] = _rotations().from_quat(quat_xyzw).as_matrix()
    T[:3, 3] = translation
    return T


def to_quat_xyzw(T_a_b: SE3) -> NDArray[np.float64]:
    """Unit quaternion (4,) of the rotation, w >= 0."""
    return np.asarray(_rotation_of(T_a_b).as_quat(canonical=True))


def rotation_angle(T_a_b: SE3) -> float:
    """Angle of the rotation [rad, 0 to pi]."""
    return float(_rotation_of(T_a_b).magnitude())


def back_project(depth: NDArray[np.float32], intrinsics: Intrinsics) -> NDArray[np.float32]:
    """Points (H, W, 3) float32 in `cam` [m] of a depth image (paper, equation 2).

    Pixels without depth (0) give the origin.
    """
    u = (np.arange(intrinsics.width, dtype=np.float32) - intrinsics.cx) / intrinsics.fx
    v = (np.arange(intrinsics.height, dtype=np.float32) - intrinsics.cy) / intrinsics.fy
    points = np.empty((*depth.shape, 3), np.float32)
    np.multiply(depth, u.astype(np.float32)[None, :], out=points[..., 0])
    np.multiply(depth, v.astype(np.float32)[:, None], out=points[..., 1])
    points[..., 2] = depth
    return points


def _rotation_of(T_a_b: SE3) -> Rotation:
    """The rotation as it is: to check it first takes seven times as long."""
    return _rotations().from_matrix(T_a_b[:3, :3], assume_valid=True)


def _rotations() -> type[Rotation]:
    """SciPy's rotations, which take a program that asks for none long to load."""
    from scipy.spatial.transform import Rotation

    rotations: type[Rotation] = Rotation
    return rotations
