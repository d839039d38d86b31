"""The pose of a camera without a base above the floor, from the first frame alone.

The accelerometer gives the direction up; the floor is the lowest large plane across it. Without an
accelerometer the floor alone decides, with the camera held upright to within MAX_TILT.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.geometry import back_project
from vizbot.core.types import SE3, RGBDFrame

MAX_TILT = np.radians(50)
"""Largest angle between the camera's own up and the floor's normal, without accelerometer [rad]."""

ACCEL_TOLERANCE = np.radians(6)
"""Largest angle between the floor's normal and up by the accelerometer [rad]."""

GRAVITY = 9.80665
"""Standard gravity [m/s^2]."""

DEPTHS = (0.3, 6.0)
"""Range of the depth of points that are used [m]."""

HEIGHTS = (0.1, 2.5)
"""Range of plausible heights of the camera above the floor [m]."""

POINTS = 4000
"""Number of points drawn from the frame to test planes with."""

TRIALS = 800
"""Number of planes tried, each through three neighbouring points."""

NEIGHBOURHOOD = 0.08
"""Largest distance of those three points, as a fraction of the image's width."""

REFINEMENTS = 3
"""Number of least-squares fits, each to the points on the plane before."""

MIN_SUPPORT = 0.06
"""Least share of the points that lie on the floor."""


def estimate_mount(frame: RGBDFrame) -> SE3 | None:
    """Find T_base_cam for a camera without a base, from one frame.

    The base is assumed on the floor below the optical centre, with the heading of the camera: the
    result holds height, roll and pitch; x, y and yaw are zero.

    Returns:
        None if the frame shows no floor: no plane at right angles to up, below the camera, with
        enough points on it and few beneath it.
    """
    usable = (frame.depth > DEPTHS[0]) & (frame.depth < DEPTHS[1])
    pixels = np.argwhere(usable)
    if len(pixels) < POINTS:
        return None
    points = back_project(frame.depth, frame.intrinsics).astype(np.float64)
    rng = np.random.default_rng(0)
    # The floor may be a tenth of the image: three points drawn anywhere would hardly ever all be on
    # it, three neighbours often are.
    reach = max(int(NEIGHBOURHOOD * frame.intrinsics.width), 1)
    first = pixels[rng.integers(0, len(pixels), TRIALS)]
    corner_pixels = first[:, None] + rng.integers(-reach, reach + 1, (TRIALS, 3, 2))
    rows, cols = np.moveaxis(np.clip(corner_pixels, 0, np.array(usable.shape) - 1), -1, 0)
    corners = points[rows, cols][usable[rows, cols].all(axis=1)]
    drawn = points[tuple(pixels[rng.integers(0, len(pixels), POINTS)].T)]
    up = _up_from_accelerometer(frame.imu.accel)
    if up is None:
        plane = _floor(drawn, corners, np.array([0.0, -1.0, 0.0]), float(MAX_TILT))
    else:
        plane = _floor(drawn, corners, up, float(ACCEL_TOLERANCE))
    if plane is None:
        return None
    normal, height = plane
    return _mount(normal if up is None else up, height)


def _up_from_accelerometer(accel: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Unit up (3,) in `cam`; None without samples, or while the camera is being accelerated."""
    if not len(accel):
        return None
    force = np.median(accel, axis=0)
    size = float(np.linalg.norm(force))
    return force / size if abs(size - GRAVITY) < 0.05 * GRAVITY else None


def _floor(
    points: NDArray[np.float64],
    corners: NDArray[np.float64],
    up: NDArray[np.float64],
    max_angle: float,
) -> tuple[NDArray[np.float64], float] | None:
    """Normal (3,), upwards, and distance [m] of the lowest large plane (RANSAC).

    A desk or a bed may hold more points than the floor, but only the floor has none beneath it: the
    score of a plane is the number of points on it less those below.

    Args:
        points: (N, 3) points of the frame in `cam` [m].
        corners: (M, 3, 3) three points of each plane to try.
        up: (3,) unit vector, roughly up.
        max_angle: Between the floor's normal and `up` [rad].
    """
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    corners, normals = corners[lengths > 1e-9], normals[lengths > 1e-9]
    normals /= lengths[lengths > 1e-9, None]
    normals *= np.where(normals @ up < 0, -1.0, 1.0)[:, None]
    heights = -np.einsum("ij,ij->i", normals, corners.mean(axis=1))
    level = (normals @ up > np.cos(max_angle)) & (heights > HEIGHTS[0]) & (heights < HEIGHTS[1])
    normals, heights = normals[level], heights[level]
    if not len(normals):
        return None
    # Depth noise grows with the square of the distance.
    tolerance = 0.01 + 0.004 * points[:, 2] ** 2
    above = (points @ normals.T + heights) / tolerance[:, None]
    score = (np.abs(above) < 1).sum(axis=0) - 2 * (above < -3).sum(axis=0)
    best = int(np.argmax(score))
    normal, height = normals[best], float(heights[best])
    for _ in range(REFINEMENTS):
        on_floor = points[np.abs(points @ normal + height) < tolerance]
        if len(on_floor) < MIN_SUPPORT * len(points):
            return None
        centre = on_floor.mean(axis=0)
        normal = np.linalg.svd(on_floor - centre, full_matrices=False)[2][2]
        normal *= np.sign(normal @ up)
        height = float(-normal @ centre)
    return normal, height


def _mount(up: NDArray[np.float64], height: float) -> SE3:
    """T_base_cam of a camera at `height` [m] above the floor that sees `up` (3,) in `cam`."""
    forward = np.array([0.0, 0.0, 1.0]) - up[2] * up
    forward /= np.linalg.norm(forward)
    T_base_cam = np.eye(4)
    T_base_cam[:3, :3] = np.stack([forward, np.cross(up, forward), up])
    T_base_cam[2, 3] = height
    return T_base_cam
