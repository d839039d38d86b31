"""Measures the robot: how far its wheels roll, where its camera sits, the gyroscope's bias.

The robot turns on the spot, to the left and to the right, and drives a straight line to and fro.
The motion by its wheels is compared with the motion by its camera.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from drivers.roomba.config import RoombaConfig
from mapping.calibration.config import CalibrationConfig, ResidualsConfig
from mapping.calibration.robot_calibration import driven_distance, mount_from_motions, turned_about
from vizbot.calibration.drive import Leg, Sample
from vizbot.config import Config, MountConfig
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import invert, mount_angles, yaw_of
from vizbot.core.settings import explained
from vizbot.core.types import SE3

_Model = TypeVar("_Model", bound=BaseModel)
_FLOORS = 10
"""At least this many frames must show the floor."""
_NO_FLOOR = "the camera hardly saw the floor; calibrate on open floor"
_SEEN = 0.8
"""Least share of the frames that must be posed from images."""
_MOST = ResidualsConfig(
    axle=0.03, floor=0.03, height=0.02, wheel_base=0.03, wheel_scale=0.03, yaw=0.02, gyro_bias=0.01
)
"""Greatest residuals of a drive that has measured something."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """The result of a calibration.

    Attributes:
        wheel_base: Distance between the wheels [m].
        wheel_scale: Metres rolled for each metre that the encoders count.
        calibration: Date, gyroscope bias and residuals.
    """

    mount: MountConfig
    wheel_base: float
    wheel_scale: float
    calibration: CalibrationConfig


def solve(samples: Sequence[Sample], config: Config) -> Calibration:
    """Compute mount, wheels and gyroscope bias from the samples of `record` and its settings.

    Raises:
        DeviceError: too few frames were posed from images or show the floor, the gyroscope turned
            at rest, or the residuals are too large.
    """
    gyro = np.concatenate([sample.gyro for sample in samples if sample.leg is Leg.REST])
    bias = _plausible_bias(gyro, config.perception.slam.dead_reckoning.greatest_bias)
    seen = sum(sample.estimate.tracking.by_images for sample in samples)
    if seen < _SEEN * len(samples):
        share = f"{100 * seen / len(samples):.0f} % of the frames"
        raise DeviceError(
            f"images showed the motion in {share}; calibrate where there is more to see"
        )
    samples = [sample for sample in samples if sample.estimate.tracking.by_images]
    if {sample.leg for sample in samples} != set(Leg):
        raise DeviceError("images showed nothing of one part of the drive; calibrate elsewhere")
    floors = [sample.floor for sample in samples if sample.floor is not None]
    if len(floors) < _FLOORS:
        raise DeviceError(_NO_FLOOR)
    first = invert(_last(samples, Leg.REST).estimate.T_map_cam)
    spin = [first @ sample.estimate.T_map_cam for sample in samples if sample.leg is Leg.LEFT]
    ahead = _between(samples, Leg.TURNED_RIGHT, Leg.WENT_AHEAD)
    back = _between(samples, Leg.WENT_AHEAD, Leg.CAME_BACK)
    mount = mount_from_motions(
        np.array(spin),
        _seen_along(samples, Leg.TURNED_RIGHT, Leg.WENT_AHEAD),
        _seen_along(samples, Leg.WENT_AHEAD, Leg.CAME_BACK),
        [T_base_cam for T_base_cam, _ in floors],
        [points for _, points in floors],
        least_floors=_FLOORS,
    )
    if mount is None:
        raise DeviceError(_NO_FLOOR)
    T_base_cam, up = mount.T_base_cam, mount.T_base_cam[2, :3]
    ways = [
        driven_distance(T_base_cam, each.T_camera) / _arc(each.T_odometry) for each in (ahead, back)
    ]
    turns = []
    for start, end in ((Leg.REST, Leg.TURNED_LEFT), (Leg.TURNED_LEFT, Leg.TURNED_RIGHT)):
        rolled, T_seen = _wheel_turn(samples, start, end), _between(samples, start, end).T_camera
        turns.append(rolled / turned_about(T_seen, up, rolled))
    wheel_ratio, turn_ratio = float(np.mean(ways)), float(np.mean(turns))
    wheels = _possible(
        RoombaConfig,
        wheel_base=_rounded(config.roomba.wheel_base * wheel_ratio * turn_ratio),
        wheel_scale=_rounded(config.roomba.wheel_scale * wheel_ratio),
    )
    yaw, tilt, roll = mount_angles(mount.T_base_cam)
    forward, left, above = mount.T_base_cam[:3, 3]
    return Calibration(
        _possible(
            MountConfig,
            height=_rounded(above), forward=_rounded(forward), left=_rounded(left),
            tilt=_rounded(tilt), yaw=_rounded(yaw), roll=_rounded(roll),
        ),
        wheel_base=wheels.wheel_base,
        wheel_scale=wheels.wheel_scale,
        calibration=CalibrationConfig(
            date=date.today().isoformat(),
            gyro_bias=bias,
            residuals=_trusted(
                _possible(
                    ResidualsConfig,
                    axle=_rounded(mount.spin_residual),
                    floor=_rounded(mount.floor_residual),
                    height=_rounded(mount.height_residual),
                    wheel_base=_rounded(abs(turns[0] - turns[1]) / 2),
                    wheel_scale=_rounded(abs(ways[0] - ways[1]) / 2),
                    yaw=_rounded(mount.yaw_residual),
                    gyro_bias=_standard_error(gyro),
                )
            ),
        ),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Motion:
    """Motion from one rest to another.

    Attributes:
        T_camera: Motion of the camera by images.
        T_odometry: Motion of the base by the wheels.
    """

    T_camera: SE3
    T_odometry: SE3


def _between(samples: Sequence[Sample], start: Leg, end: Leg) -> _Motion:
    a, b = _last(samples, start), _last(samples, end)
    return _Motion(
        invert(a.estimate.T_map_cam) @ b.estimate.T_map_cam, invert(a.T_odom_base) @ b.T_odom_base
    )


def _seen_along(samples: Sequence[Sample], start: Leg, end: Leg) -> NDArray[np.float64]:
    """T_map_cam (N, 4, 4) from the end of one leg to the end of another."""
    first, last = samples.index(_last(samples, start)), samples.index(_last(samples, end))
    return np.array([sample.estimate.T_map_cam for sample in samples[first : last + 1]])


def _last(samples: Sequence[Sample], leg: Leg) -> Sample:
    return next(sample for sample in reversed(samples) if sample.leg is leg)


def _wheel_turn(samples: Sequence[Sample], start: Leg, end: Leg) -> float:
    """Turn of the base by its wheels, whole turns counted [rad]."""
    first, last = samples.index(_last(samples, start)), samples.index(_last(samples, end))
    yaws = [yaw_of(sample.T_odom_base) for sample in samples[first : last + 1]]
    unwrapped = np.unwrap(yaws)
    return float(unwrapped[-1] - unwrapped[0])


def _arc(T_odometry: SE3) -> float:
    """Length of the arc that a base rolls to T_odometry [m]; a little where it counts nothing."""
    return max(driven_distance(np.eye(4), T_odometry), 1e-6)


def _plausible_bias(
    rates: NDArray[np.float64], greatest: float
) -> tuple[float, float, float] | None:
    """Mean of the rates (N, 3) at rest [rad/s]; None without a gyroscope.

    Raises:
        DeviceError: its norm is above `greatest` [rad/s], as that of no bias.
    """
    if not len(rates):
        return None
    x, y, z = (float(rate) for rate in rates.mean(axis=0))
    if (read := math.hypot(x, y, z)) > greatest:
        what = f"the gyroscope read {read:.3f} rad/s at rest, of at most {greatest}"
        raise DeviceError(f"{what}; keep the robot still, then calibrate the camera's IMU")
    return x, y, z


def _standard_error(rates: NDArray[np.float64]) -> float:
    """Standard error of the mean of rates (N, 3), the three axes together [rad/s]."""
    if len(rates) < 2:
        return 0.0
    return float(np.linalg.norm(rates.std(axis=0, ddof=1)) / np.sqrt(len(rates)))


def _possible(model: type[_Model], **found: float) -> _Model:
    """Settings with what was found; raises `DeviceError` for what no robot of this kind has."""
    try:
        return model(**found)
    except ValidationError as error:
        raise DeviceError(
            f"the drive found what no robot of this kind has: {explained(error, model)}; look"
            " whether a wheel slips or is blocked, then calibrate on open floor"
        ) from error


def _trusted(residuals: ResidualsConfig) -> ResidualsConfig:
    """The residuals themselves; raises `DeviceError` where one is too large."""
    for name, most in _MOST:
        if getattr(residuals, name) > most:
            unexplained = f"{name} {getattr(residuals, name)} of at most {most}"
            raise DeviceError(f"the drive left too much unexplained ({unexplained}); try elsewhere")
    return residuals


def _rounded(value: float) -> float:
    return round(float(value), 5)
