"""Extrinsic calibration: the mount of the camera, from its motion while the base drives.

Two motions determine it: while the base turns on the spot, the middle of its axle is the one point
that stays; when it drives straight, it moves along its own x axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3

_FLOOR_BANDS = (0.03, 0.02, 0.01, 0.007, 0.005, 0.005)
"""Distance from the floor within which points belong to it, fit after fit [m]."""
_FLOOR_POINTS = 300
"""Least number of floor points of a frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """Where the camera sits.

    Attributes:
        spin_residual: Apparent motion of the middle of the axle while the base turns on the spot
            (RMS) [m].
        floor_residual: Angle between the floor's normal and the axis of that turn [rad].
        height_residual: Spread of the camera's height over the frames (standard deviation) [m].
        yaw_residual: Half the angle between the headings ahead and back [rad].
    """

    T_base_cam: SE3
    spin_residual: float
    floor_residual: float
    height_residual: float
    yaw_residual: float


def axle_in_camera(
    Ts_first_cam: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Estimate the axis about which a camera was turned.

    Args:
        Ts_first_cam: (N, 4, 4) of a camera that was turned by at least a radian about one axis, by
            less than half a turn from one pose to the next.

    Returns:
        The point (3,) of the axis nearest to the camera, in its own coordinates [m]; the axis (3,),
        a unit vector about which the turn was positive; the residual (RMS) [m].
    """
    eye = np.eye(3)
    turns = np.concatenate([T[:3, :3] - eye for T in Ts_first_cam])
    moves = np.concatenate([-T[:3, 3] for T in Ts_first_cam])
    # The axis is what no turn moves: the smallest singular value belongs to it.
    axis = np.linalg.svd(turns, full_matrices=False)[2][2]
    rotations = Rotation.from_matrix(Ts_first_cam[:, :3, :3])
    steps = (rotations[:-1].inv() * rotations[1:]).as_rotvec()
    axis *= np.sign((steps @ axis).sum() or 1.0)
    point = np.linalg.lstsq(np.vstack([turns, axis]), np.append(moves, 0.0), rcond=None)[0]
    residual = (turns @ point - moves).reshape(-1, 3)
    return point, axis, float(np.sqrt((residual**2).sum(axis=1).mean()))


def mount_from_motions(
    Ts_first_cam: NDArray[np.float64],
    Ts_ahead: NDArray[np.float64],
    Ts_back: NDArray[np.float64],
    floors: Sequence[SE3],
    floor_points: Sequence[NDArray[np.float64]],
    least_floors: int = 1,
) -> Mount | None:
    """Estimate the mount of the camera; None if fewer frames than `least_floors` show the floor.

    Up is the mean of the axis about which the camera turned and of the floor's normal, whose errors
    are independent.

    Args:
        Ts_first_cam: (N, 4, 4) while the base turned to the left on the spot.
        Ts_ahead: (N, 4, 4) of the camera, in one of its poses, while the base drove straight ahead.
        Ts_back: The same while it drove straight back.
        floors: Rough T_base_cam by the floor in some frames (`floor_level`).
        floor_points: (N, 3) points of those frames in `cam` [m].
        least_floors: Least number of those frames that show the floor at one height.
    """
    axle, axis, residual = axle_in_camera(Ts_first_cam)
    roughly = float(np.median([T_base_cam[2, 3] for T_base_cam in floors]))
    planes = [floor_plane(points, axis, roughly) for points in floor_points]
    found = [plane for plane in planes if plane is not None]
    if len(found) < least_floors:
        return None
    normal, height, spread = _middle(found)
    up = (axis + normal) / np.linalg.norm(axis + normal)
    ahead, back = (_heading(Ts, axle, up) for Ts in (Ts_ahead, Ts_back))
    forward = (ahead - back) / np.linalg.norm(ahead - back)
    T_base_cam = np.eye(4)
    T_base_cam[:3, :3] = np.stack([forward, np.cross(up, forward), up])
    on_floor = axle - (axle @ up + height) * up
    T_base_cam[:3, 3] = -T_base_cam[:3, :3] @ on_floor
    tilted = float(np.arccos(np.clip(axis @ normal, -1.0, 1.0)))
    apart = float(np.arccos(np.clip(-ahead @ back, -1.0, 1.0)))
    return Mount(T_base_cam, residual, tilted, spread, apart / 2)


def _heading(
    Ts_first_cam: NDArray[np.float64], axle: NDArray[np.float64], up: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mean heading of the middle of the axle (3,) in the camera's axes, over its poses (N, 4, 4).

    Wheels slip, and the base turns to and fro while it drives: the vector from the first position
    to the last does not lie along the heading at either.

    Returns:
        A unit vector (3,) at right angles to `up`.
    """
    path = np.zeros(3)
    for before, now in pairwise(Ts_first_cam):
        T_before_now = invert(before) @ now
        step = T_before_now[:3, :3] @ axle + T_before_now[:3, 3] - axle
        turned = Rotation.from_matrix(T_before_now[:3, :3]).as_rotvec() @ up
        # The chord of an arc points half of its turn away from the start.
        path += Rotation.from_rotvec(-0.5 * turned * up).apply(step)
    level = path - (path @ up) * up
    return np.asarray(level / np.linalg.norm(level))


def floor_plane(
    points: NDArray[np.float64], up: NDArray[np.float64], roughly: float
) -> tuple[NDArray[np.float64], float] | None:
    """Fit the floor below a camera.

    Low objects on the floor would tilt a plane fitted to all points near a rough height, so each
    fit uses only the points that the previous one has on the floor.

    Args:
        points: (N, 3) in `cam`, of the floor and of other things.
        up: (3,) unit, in `cam`, to within a degree.
        roughly: The height to within a few centimetres [m].

    Returns:
        Its normal (3,), upwards, and how high the camera is above it [m]; None without enough
        points.
    """
    normal, height = up, roughly
    for band in _FLOOR_BANDS:
        near = points[np.abs(-points @ normal - height) < band]
        if len(near) < _FLOOR_POINTS:
            return None
        normal = np.linalg.eigh(np.cov(near.T))[1][:, 0]
        normal *= np.sign(normal @ up)
        height = float(np.median(-near @ normal))
    return normal, height


def _middle(
    planes: Sequence[tuple[NDArray[np.float64], float]],
) -> tuple[NDArray[np.float64], float, float]:
    """Medians of normals and heights, and the standard deviation of the heights [m]."""
    heights = [height for _, height in planes]
    normal = np.median([normal for normal, _ in planes], axis=0)
    return normal / np.linalg.norm(normal), float(np.median(heights)), float(np.std(heights))


def turned_about(T_first_last: SE3, up: NDArray[np.float64], roughly: float) -> float:
    """Turn about `up` (3,) between two poses, whole turns taken from a rough value [rad]."""
    turn = float(Rotation.from_matrix(T_first_last[:3, :3]).as_rotvec() @ up)
    return turn + 2 * np.pi * round((roughly - turn) / (2 * np.pi))


def driven_distance(T_base_cam: SE3, T_first_last: SE3) -> float:
    """Length of the arc that the base drove between two poses of its camera [m]."""
    T_before_now = T_base_cam @ T_first_last @ invert(T_base_cam)
    half = 0.5 * rotation_angle(T_before_now)
    return float(np.hypot(*T_before_now[:2, 3]) / np.sinc(half / np.pi))
