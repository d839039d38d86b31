"""The drive of a calibration: its legs, and the sample recorded for every frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from mapping.calibration.floor_level import estimate_mount
from mapping.keyframes.anchors import poses_in_map
from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from vizbot.config import Config
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import back_project, camera_mount, invert, mount_angles
from vizbot.core.interfaces import Devices
from vizbot.core.program.interrupts import holding_interrupts, raise_held_interrupt
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

_SPIN, _SPEED = 0.6, 0.15
"""Angular velocity of the turns [rad/s] and velocity of the line [m/s]."""
_TURN, _LINE = 4.0 * np.pi, 1.5
"""How far the robot turns each way [rad], and how far it drives [m]. After whole turns it sees what
it saw before, so that the images close the turn."""
_REST = 2.0
"""How long the robot stands before, between and after the motions [s]."""
_WHEEL_SIGMA = 0.1
"""Standard deviation of wheels and floor in the graph, and their tolerance at closures [m, rad]. It
is over ten times that of images, so that wheels which are 5 % wrong turn and stretch the path that
images give by less than a thousandth."""
_FLOOR_PERIOD = 0.5
"""Time between two frames in which the floor is looked for [s]."""
_STRIDE, _NEAR = 4, 3.0
"""A point is kept of every so many pixels of those frames, up to this depth [m]."""


class Leg(StrEnum):
    """One part of the drive; the robot drives them in this order."""

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
"""The twist of each leg, and how long it is driven [s]; the robot stands still on the others."""


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """One frame of the drive.

    Attributes:
        estimate: Pose of the camera by images; wheels only carry it on where these show too little.
        T_odom_base: Pose of the base by the wheels.
        gyro: Rates (N, 3) in `cam` since the frame before [rad/s].
        floor: T_base_cam by the floor in the frame, and points (N, 3) of the frame in `cam`; None
            where the floor was not looked for or not seen.
    """

    leg: Leg
    estimate: PoseEstimate
    T_odom_base: SE3
    gyro: NDArray[np.float64]
    floor: tuple[SE3, NDArray[np.float64]] | None


@holding_interrupts()
def record(devices: Devices, config: Config, announce: Callable[[str], None]) -> list[Sample]:
    """Drive all legs.

    2 m ahead of the base must be free; a `config` by ruler and guess will do. `announce` gets the
    description of the leg that comes next.

    Raises:
        DeviceError: a device is gone, or the robot touched something and has stopped.
    """
    base, clock = devices.base, devices.clock
    assert base is not None
    samples: list[Sample] = []
    slam: Slam | None = None
    T_odom_start: SE3 | None = None
    for leg in Leg:
        twist, seconds = _DRIVE.get(leg, (STOP, _REST))
        announce(leg.value)
        end, due = clock.now() + seconds, clock.now()
        while clock.now() < end:
            raise_held_interrupt()
            frame = devices.camera.read()
            if frame is None:
                raise DeviceError("the camera gives no more frames; calibrate with a live one")
            base.drive(twist)
            state = base.read()
            _require_free(state)
            if leg is Leg.AHEAD and T_odom_start is None:
                T_odom_start = state.T_odom_base
            if leg is Leg.BACK and T_odom_start is not None and _behind(T_odom_start, state):
                break
            if slam is None:
                slam = Slam(
                    frame.intrinsics, _guessed_mount(frame, config), _trusting_images(config)
                )
            floor = None
            if leg is Leg.LEFT and clock.now() >= due:
                due, floor = due + _FLOOR_PERIOD, _floor_in(frame)
            estimate = slam.track(frame, state.T_odom_base)
            samples.append(Sample(leg, estimate, state.T_odom_base, frame.imu.gyro, floor))
        base.drive(STOP)
    assert slam is not None
    return _in_final_map(samples, slam.keyframe_poses())


def _in_final_map(samples: Sequence[Sample], keyframes: dict[int, SE3]) -> list[Sample]:
    """Replace the poses of the samples by those that the pose graph ends with."""
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


def _guessed_mount(frame: RGBDFrame, config: Config) -> SE3:
    """T_base_cam of the settings, with height, tilt and roll by the floor in the frame."""
    level = estimate_mount(replace(frame, imu=ImuSamples.none()))
    if level is None:
        return config.mount.T_base_cam
    _, tilt, roll = mount_angles(level)
    mount = config.mount
    return camera_mount(
        float(level[2, 3]), mount.forward, tilt, left=mount.left, yaw=mount.yaw, roll=roll
    )


def _trusting_images(config: Config) -> SlamConfig:
    """Let wheels and mount, which are to be measured, only bridge gaps between images.

    Without wheels the robot would be lost in a turn past a plain wall until it sees again what it
    saw before that wall, and what lies behind the wall would never get a keyframe.
    """
    slam = config.perception.slam
    graph = slam.graph.model_copy(
        update={
            "wheel_rotation_sigma": _WHEEL_SIGMA,
            "wheel_translation_sigma": _WHEEL_SIGMA,
            "floor_tilt_sigma": _WHEEL_SIGMA,
            "floor_height_sigma": _WHEEL_SIGMA,
        }
    )
    gates = slam.gates.model_copy(
        update={"closure_height": _WHEEL_SIGMA, "closure_tilt": _WHEEL_SIGMA}
    )
    return slam.model_copy(update={"graph": graph, "gates": gates})


def _floor_in(frame: RGBDFrame) -> tuple[SE3, NDArray[np.float64]] | None:
    """Estimate T_base_cam by the floor alone: an accelerometer has a bias of its own."""
    T_base_cam = estimate_mount(replace(frame, imu=ImuSamples.none()))
    if T_base_cam is None:
        return None
    points = back_project(frame.depth, frame.intrinsics)[::_STRIDE, ::_STRIDE].reshape(-1, 3)
    near = (points[:, 2] > 0.0) & (points[:, 2] < _NEAR)
    return T_base_cam, points[near].astype(np.float64)


def _behind(T_odom_start: SE3, state: BaseState) -> bool:
    """Whether the robot is back where it set out ahead; it does not see what lies behind that."""
    return bool((invert(T_odom_start) @ state.T_odom_base)[0, 3] < 0.0)


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
