"""Where the camera sits on a robot, and how far its wheels truly roll, from what the camera saw.

Two motions tell it: while the base turns on the spot, the middle of its axle is the one point that
stays; when it drives straight, it moves along its own x axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel
from scipy.spatial.transform import Rotation

from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3


class ResidualsConfig(BaseModel):
    """What the estimates of a calibration leave unexplained."""

    model_config = SETTINGS

    axle: float = 0.0
    """How far the middle of the axle seemed to move in the turn (RMS) [m]."""
    floor: float = 0.0
    """Between the floor's normal and the axis of the turn [rad]."""
    height: float = 0.0
    """Spread of the camera's height [m]."""
    wheel_base: float = 0.0
    """Half the difference between the turns to the left and to the right, as a fraction."""
    wheel_scale: float = 0.0
    """Half the difference between the ways ahead and back, as a fraction."""
    yaw: float = 0.0
    """Half the angle between the headings ahead and back [rad]."""
    gyro_bias: float = 0.0
    """Standard error of the mean of the rates at rest [rad/s]."""


class CalibrationConfig(BaseModel):
    """When wheels and mount were calibrated, and how well."""

    model_config = SETTINGS

    date: str = ""
    """Empty before `vizbot calibrate`, which fills this in."""
    gyro_bias: tuple[float, float, float] | None = None
    """Rates that the gyroscope read at rest, in `cam` [rad/s]; for people, each run learns them."""
    residuals: ResidualsConfig = ResidualsConfig()


_FLOOR_BAND = 0.03
"""What is so near to the floor belongs to it [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """Where the camera sits.

    Attributes:
        T_base_cam: The mount.
        spin_residual: How far the middle of the axle seems to move while the base turns on the
            spot (RMS) [m].
        floor_residual: Between the floor's normal and the axis of that turn [rad].
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
    """The axis about which a camera was turned.

    Args:
        Ts_first_cam: (N, 4, 4) of a camera that was turned by at least a radian about one axis.

    Returns:
        The point (3,) of the axis nearest to the camera, in its own coordinates [m]; the axis (3,),
        a unit vector about which the turn was positive; what that leaves unexplained (RMS) [m].
    """
    eye = np.eye(3)
    turns = np.concatenate([T[:3, :3] - eye for T in Ts_first_cam])
    moves = np.concatenate([-T[:3, 3] for T in Ts_first_cam])
    # What no turn moves lies along the axis: the least of the singular values belongs to it.
    axis = np.linalg.svd(turns, full_matrices=False)[2][2]
    vectors = Rotation.from_matrix(Ts_first_cam[:, :3, :3]).as_rotvec()
    small = vectors[np.linalg.norm(vectors, axis=1) < np.pi / 2]
    axis *= np.sign((small @ axis).sum() or 1.0)
    point = np.linalg.lstsq(np.vstack([turns, axis]), np.append(moves, 0.0), rcond=None)[0]
    residual = (turns @ point - moves).reshape(-1, 3)
    return point, axis, float(np.sqrt((residual**2).sum(axis=1).mean()))


def mount_from_motions(
    Ts_first_cam: NDArray[np.float64],
    T_before_ahead: SE3,
    T_ahead_back: SE3,
    floors: Sequence[SE3],
    floor_points: Sequence[NDArray[np.float64]],
) -> Mount:
    """Where the camera sits.

    Up is the mean of the axis about which it turned and of the floor's normal, whose errors have
    nothing to do with each other.

    Args:
        Ts_first_cam: (N, 4, 4) while the base turned to the left on the spot.
        T_before_ahead: Of the camera, from where the base began to drive straight ahead to where
            it ended; it may have turned a little.
        T_ahead_back: From there to where it was after it had driven straight back.
        floors: T_base_cam as some frames' floors tell it (`mapping.level`).
        floor_points: (N, 3) of those frames in `cam`.
    """
    axle, axis, residual = axle_in_camera(Ts_first_cam)
    normal = np.median([T_base_cam[2, :3] for T_base_cam in floors], axis=0)
    normal /= np.linalg.norm(normal)
    up = (axis + normal) / np.linalg.norm(axis + normal)
    roughly = float(np.median([T_base_cam[2, 3] for T_base_cam in floors]))
    heights = [height_above_floor(points, up, roughly) for points in floor_points]
    ahead, back = (_heading(T, axle, up) for T in (T_before_ahead, T_ahead_back))
    forward = (ahead - back) / np.linalg.norm(ahead - back)
    T_base_cam = np.eye(4)
    T_base_cam[:3, :3] = np.stack([forward, np.cross(up, forward), up])
    on_floor = axle - (axle @ up + float(np.median(heights))) * up
    T_base_cam[:3, 3] = -T_base_cam[:3, :3] @ on_floor
    tilted = float(np.arccos(np.clip(axis @ normal, -1.0, 1.0)))
    apart = float(np.arccos(np.clip(-ahead @ back, -1.0, 1.0)))
    return Mount(T_base_cam, residual, tilted, float(np.std(heights)), apart / 2)


def _heading(
    T_start_end: SE3, axle: NDArray[np.float64], up: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Where the middle of the axle (3,) set out to, a unit vector (3,) at right angles to `up`."""
    way = T_start_end[:3, :3] @ axle + T_start_end[:3, 3] - axle
    turned = Rotation.from_matrix(T_start_end[:3, :3]).as_rotvec() @ up
    # The chord of an arc points half of its turn away from where it began.
    way = Rotation.from_rotvec(-0.5 * turned * up).apply(way)
    level = way - (way @ up) * up
    return np.asarray(level / np.linalg.norm(level))


def height_above_floor(
    points: NDArray[np.float64], up: NDArray[np.float64], roughly: float
) -> float:
    """How high a camera is above the points of the floor [m].

    Args:
        points: (N, 3) in `cam`, of the floor and of other things.
        up: (3,) unit, in `cam`.
        roughly: The height to within `_FLOOR_BAND` [m].
    """
    heights = -points @ up
    for _ in range(3):
        roughly = float(np.median(heights[np.abs(heights - roughly) < _FLOOR_BAND]))
    return roughly


def turned_about(T_first_last: SE3, up: NDArray[np.float64], roughly: float) -> float:
    """Turn [rad] about `up` (3,) between two poses, whole turns as a rough figure has them."""
    turn = float(Rotation.from_matrix(T_first_last[:3, :3]).as_rotvec() @ up)
    return turn + 2 * np.pi * round((roughly - turn) / (2 * np.pi))


def moved(T_base_cam: SE3, T_first_last: SE3) -> float:
    """How far the base went between two poses of its camera [m]."""
    T_before_now = T_base_cam @ T_first_last @ invert(T_base_cam)
    half = 0.5 * rotation_angle(T_before_now)
    return float(np.hypot(*T_before_now[:2, 3]) / np.sinc(half / np.pi))
