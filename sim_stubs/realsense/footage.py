"""A recording of a RealSense on a robot in a simulated world, for any RealSense program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim_stubs.realsense.camera import SimulatedRealSense
from sim_stubs.realsense.config import SimulatedRealSenseConfig
from sim_stubs.realsense.software_device import SoftwareD435i
from sim_stubs.world.world import World
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import ImuSamples

_FPS = 30
_EPOCH = 1_700_000_000.0
"""First stamp [s since 1970], always the same, so that a seed gives the same frames."""
_TURN_RATE = 0.5
"""Yaw rate of the robot, which turns on the spot [rad/s]."""


class _Turn:
    """The robot's motion, in lockstep with the clock."""

    def __init__(self, world: World, wheel_base: float, rest: float) -> None:
        self._world = world
        self._rest = rest
        self._rim_speed = _TURN_RATE * wheel_base / 2
        self._passed = 0.0

    def publish(self) -> None:
        """Do nothing: this device sends nothing."""

    def advance(self, seconds: float) -> None:
        """Advance the world."""
        if self._passed >= self._rest - 1e-9:
            self._world.set_wheel_speeds(-self._rim_speed, self._rim_speed)
        self._world.advance(seconds)
        self._passed += seconds


def record_footage(
    world: World,
    wheel_base: float,
    config: SimulatedRealSenseConfig,
    path: Path,
    seconds: float,
    rest: float = 2.0,
) -> int:
    """Record a `.db3` of the robot at rest and then turning to the left.

    Args:
        world: The world, which the caller closes.
        wheel_base: Distance of the robot's wheels [m].
        config: Errors of the camera; its rate is that of a D435i in any case.
        path: File of the recording.
        seconds: Duration [s].
        rest: Time that the robot stands at first, for the gyroscope's bias [s].

    Returns:
        The number of frames.
    """
    clock = SimulatedClock(period=1.0 / (4 * _FPS))  # frames are due at whole periods
    clock.attach(_Turn(world, wheel_base, rest))
    at_full_rate = config.model_copy(update={"rate": float(_FPS)})
    frames = max(1, round(seconds * _FPS))
    device = SoftwareD435i(color=world.intrinsics, fps=_FPS)
    with SimulatedRealSense(world, clock, at_full_rate) as camera, device.record(path):
        for _ in range(frames):
            frame = camera.read()
            _push_imu(device, frame.imu)
            depth_mm = np.rint(1000.0 * frame.depth).clip(max=np.iinfo(np.uint16).max)
            device.push_frame(frame.rgb, depth_mm.astype(np.uint16), _EPOCH + frame.stamp)
    return frames


def _push_imu(device: SoftwareD435i, imu: ImuSamples) -> None:
    """Push samples in the order of their stamps, as a camera sends them."""
    samples: list[tuple[float, NDArray[np.float64], Callable[..., None]]] = []
    for stamps, values, push in (
        (imu.gyro_stamps, imu.gyro, device.push_gyro),
        (imu.accel_stamps, imu.accel, device.push_accel),
    ):
        samples += [(t, value, push) for t, value in zip(stamps, values, strict=True)]
    for stamp, value, push in sorted(samples, key=lambda sample: sample[0]):
        push(value, _EPOCH + stamp)
