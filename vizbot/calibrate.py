"""Measures the robot: how far its wheels roll, where its camera sits, the gyroscope's bias.

The robot turns on the spot, to the left and to the right, and drives a straight line to and fro.
What its wheels count is held against what its camera sees.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import date
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from mapping.anchors import poses_in_map
from mapping.level import estimate_mount
from mapping.robot_calibration import mount_from_motions, moved, turned_about
from mapping.slam import Slam
from vizbot.config import CalibrationConfig, Config, MountConfig, ResidualsConfig
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import back_project, invert, mount_angles, yaw_of
from vizbot.core.types import (
    SE3,
    STOP,
    BaseState,
    Button,
    ImuSamples,
    PoseEstimate,
    RGBDFrame,
    Twist,
)
from vizbot.rig import Devices

_SPIN, _SPEED = 0.6, 0.15
"""[rad/s], [m/s]"""
_TURN, _LINE = 3.0 * np.pi, 1.5
"""How far it turns each way [rad], and how far it drives [m]."""
_REST = 2.0
"""Before, between and after the motions [s]."""
_FLOORS = 20
"""So many frames are asked where the floor is."""
_STRIDE, _NEAR = 4, 3.0
"""Every how many pixels a point of them is kept, and up to which depth [m]."""
_SEEN = 0.8
"""Share of the frames whose poses images must tell."""
_MOST = ResidualsConfig(axle=0.03, floor=0.03, height=0.02, wheel_base=0.03, wheel_scale=0.03)
"""A drive that leaves more than this unexplained has measured nothing."""


class Leg(StrEnum):
    """One part of the drive, in this order."""

    REST = "standing still"
    LEFT = "turning to the left"
    TURNED_LEFT = "standing still after it"
    RIGHT = "turning to the right"
    TURNED_RIGHT = "standing still after that"
    AHEAD = "driving ahead"
    WENT_AHEAD = "standing still ahead"
    BACK = "driving back"
    CAME_BACK = "standing still at last"


_DRIVE = {
    Leg.LEFT: (Twist(0.0, _SPIN), _TURN / _SPIN),
    Leg.RIGHT: (Twist(0.0, -_SPIN), _TURN / _SPIN),
    Leg.AHEAD: (Twist(_SPEED, 0.0), _LINE / _SPEED),
    Leg.BACK: (Twist(-_SPEED, 0.0), _LINE / _SPEED),
}
"""What is driven on each leg, and for how long [s]; it stands still on the others."""


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """One frame of the drive.

    Attributes:
        leg: During which it was taken.
        estimate: Where, by images alone.
        T_odom_base: Where the wheels have the base.
        gyro: Rates (N, 3) in `cam` since the frame before [rad/s].
        floor: T_base_cam as the floor in the frame tells it, and points (N, 3) of the frame in
            `cam`; None where it was not asked or seen.
    """

    leg: Leg
    estimate: PoseEstimate
    T_odom_base: SE3
    gyro: NDArray[np.float64]
    floor: tuple[SE3, NDArray[np.float64]] | None


@dataclass(frozen=True, slots=True)
class Calibration:
    """What was measured.

    Attributes:
        mount: Of the camera.
        wheel_base: Distance between the wheels [m].
        wheel_scale: Metres truly rolled for each metre that the encoders count.
        calibration: When, and how well.
    """

    mount: MountConfig
    wheel_base: float
    wheel_scale: float
    calibration: CalibrationConfig

    def applied_to(self, config: Config) -> Config:
        """The configuration with these figures in it."""
        roomba = config.roomba.model_copy(
            update={"wheel_base": self.wheel_base, "wheel_scale": self.wheel_scale}
        )
        measured = {"mount": self.mount, "roomba": roomba, "calibration": self.calibration}
        return config.model_copy(update=measured)


def record(devices: Devices, config: Config, tell: Callable[[str], None]) -> list[Sample]:
    """Drive all legs.

    Args:
        devices: With a base; 2 m ahead of it must be free.
        config: Of the devices.
        tell: Told what comes next.

    Raises:
        DeviceError: a device is gone, or the robot touched something and has stopped.
    """
    base, clock = devices.base, devices.clock
    assert base is not None
    samples: list[Sample] = []
    slam: Slam | None = None
    for leg in Leg:
        twist, seconds = _DRIVE.get(leg, (STOP, _REST))
        tell(leg.value)
        end, asked = clock.now() + seconds, 0
        while clock.now() < end:
            frame = devices.camera.read()
            if frame is None:
                raise DeviceError("the camera gives no more frames; calibrate with a live one")
            base.drive(twist)
            state = base.read()
            _require_free(state)
            if slam is None:
                slam = Slam(frame.intrinsics, config.mount.T_base_cam, config.perception.slam)
            floor = None
            if leg is Leg.LEFT and asked < _FLOORS:
                asked, floor = asked + 1, _floor_in(frame)
            estimate = slam.track(frame, None)
            samples.append(Sample(leg, estimate, state.T_odom_base, frame.imu.gyro, floor))
        base.drive(STOP)
    assert slam is not None
    return _in_final_map(samples, slam.keyframe_poses())


def solve(samples: Sequence[Sample], config: Config) -> Calibration:
    """What the drive tells.

    Args:
        samples: Of `record`.
        config: As they were recorded with.

    Raises:
        DeviceError: images did not tell enough.
    """
    seen = sum(sample.estimate.tracking.by_images for sample in samples)
    if seen < _SEEN * len(samples):
        share = f"{100 * seen / len(samples):.0f} % of the frames"
        raise DeviceError(
            f"images told the motion of {share}; calibrate where there is more to see"
        )
    samples = [sample for sample in samples if sample.estimate.tracking.by_images]
    if {sample.leg for sample in samples} != set(Leg):
        raise DeviceError("images told nothing of one part of the drive; calibrate elsewhere")
    floors = [sample.floor for sample in samples if sample.floor is not None]
    if len(floors) < _FLOORS // 2:
        raise DeviceError("the camera hardly saw the floor; calibrate on open floor")
    first = invert(_last(samples, Leg.REST).estimate.T_map_cam)
    spin = [first @ sample.estimate.T_map_cam for sample in samples if sample.leg is Leg.LEFT]
    ahead = _between(samples, Leg.TURNED_RIGHT, Leg.WENT_AHEAD)
    mount = mount_from_motions(np.array(spin), ahead.T_camera, *zip(*floors, strict=True))
    T_base_cam, up = mount.T_base_cam, mount.T_base_cam[2, :3]

    back = _between(samples, Leg.WENT_AHEAD, Leg.CAME_BACK)
    ways = [moved(T_base_cam, each.T_camera) / _arc(each.T_odometry) for each in (ahead, back)]
    turns = []
    for start, end in ((Leg.REST, Leg.TURNED_LEFT), (Leg.TURNED_LEFT, Leg.TURNED_RIGHT)):
        told, seen_turn = _told_turn(samples, start, end), _between(samples, start, end).T_camera
        turns.append(told / turned_about(seen_turn, up, told))
    wheel_ratio, turn_ratio = float(np.mean(ways)), float(np.mean(turns))
    gyro = np.concatenate([sample.gyro for sample in samples if sample.leg is Leg.REST])
    bias = tuple(float(rate) for rate in gyro.mean(axis=0)) if len(gyro) else None
    yaw, tilt, roll = mount_angles(mount.T_base_cam)
    forward, left, above = mount.T_base_cam[:3, 3]
    return Calibration(
        MountConfig(
            height=_rounded(above), forward=_rounded(forward), left=_rounded(left),
            tilt=_rounded(tilt), yaw=_rounded(yaw), roll=_rounded(roll),
        ),
        wheel_base=_rounded(config.roomba.wheel_base * wheel_ratio * turn_ratio),
        wheel_scale=_rounded(config.roomba.wheel_scale * wheel_ratio),
        calibration=CalibrationConfig(
            date=date.today().isoformat(),
            gyro_bias=bias,
            residuals=_trusted(
                ResidualsConfig(
                    axle=_rounded(mount.spin_residual),
                    floor=_rounded(mount.floor_residual),
                    height=_rounded(mount.height_residual),
                    wheel_base=_rounded(abs(turns[0] - turns[1]) / 2),
                    wheel_scale=_rounded(abs(ways[0] - ways[1]) / 2),
                )
            ),
        ),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Motion:
    """From one rest to another.

    Attributes:
        T_camera: Of the camera, as it saw it.
        T_odometry: Of the base, as the wheels have it.
    """

    T_camera: SE3
    T_odometry: SE3


def _between(samples: Sequence[Sample], start: Leg, end: Leg) -> _Motion:
    a, b = _last(samples, start), _last(samples, end)
    return _Motion(
        invert(a.estimate.T_map_cam) @ b.estimate.T_map_cam, invert(a.T_odom_base) @ b.T_odom_base
    )


def _last(samples: Sequence[Sample], leg: Leg) -> Sample:
    return next(sample for sample in reversed(samples) if sample.leg is leg)


def _told_turn(samples: Sequence[Sample], start: Leg, end: Leg) -> float:
    """How far the wheels say that the base turned, whole turns counted [rad]."""
    first, last = samples.index(_last(samples, start)), samples.index(_last(samples, end))
    yaws = [yaw_of(sample.T_odom_base) for sample in samples[first : last + 1]]
    unwrapped = np.unwrap(yaws)
    return float(unwrapped[-1] - unwrapped[0])


def _arc(T_odometry: SE3) -> float:
    """Length of the arc that ends there [m]."""
    return moved(np.eye(4), T_odometry)


def _in_final_map(samples: Sequence[Sample], keyframes: dict[int, SE3]) -> list[Sample]:
    """The samples with the poses that the graph has for them in the end."""
    estimates = [sample.estimate for sample in samples]
    Ts_map_cam = poses_in_map(
        np.array([estimate.T_keyframe_cam for estimate in estimates]).reshape(-1, 4, 4),
        np.array([estimate.keyframe for estimate in estimates], np.int32),
        keyframes,
    )
    return [
        replace(sample, estimate=replace(sample.estimate, T_map_cam=T_map_cam))
        for sample, T_map_cam in zip(samples, Ts_map_cam, strict=True)
    ]


def _floor_in(frame: RGBDFrame) -> tuple[SE3, NDArray[np.float64]] | None:
    """By the floor alone: an accelerometer has a bias of its own."""
    T_base_cam = estimate_mount(replace(frame, imu=ImuSamples.none()))
    if T_base_cam is None:
        return None
    points = back_project(frame.depth, frame.intrinsics)[::_STRIDE, ::_STRIDE].reshape(-1, 3)
    near = (points[:, 2] > 0.0) & (points[:, 2] < _NEAR)
    return T_base_cam, points[near].astype(np.float64)


def _trusted(residuals: ResidualsConfig) -> ResidualsConfig:
    for name, most in _MOST:
        if getattr(residuals, name) > most:
            unexplained = f"{name} {getattr(residuals, name)} of at most {most}"
            raise DeviceError(f"the drive left too much unexplained ({unexplained}); try elsewhere")
    return residuals


def _require_free(state: BaseState) -> None:
    if state.docked:
        raise DeviceError("the robot stands on its dock; put it where 2 m ahead of it are free")
    if Button.CLEAN in state.buttons:
        raise DeviceError("somebody pressed Clean on the base; calibrate again")
    if state.blocked or any(state.cliffs) or any(state.wheel_drops):
        what = "something in its way" if state.blocked else "an edge or a dropped wheel"
        raise DeviceError(f"stopped for {what}; put the robot where 2 m ahead of it are free")
    if not state.mode.obeys:
        mode = state.mode.name.title()
        raise DeviceError(f"the base has gone to {mode} mode; look at it and calibrate again")


def _rounded(value: float) -> float:
    return round(float(value), 5)
