"""A D435i in a simulated world: colour, depth, gyroscope and accelerometer as `Camera`."""

from __future__ import annotations

from math import floor
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sim_stubs.realsense.colour_noise import AutoExposure, noisy_colour
from sim_stubs.realsense.config import (
    SimulatedRealSenseConfig,
)
from sim_stubs.realsense.depth_noise import noisy_depth
from sim_stubs.realsense.imu import InertialSensor
from sim_stubs.world.world import World
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.interfaces import Clock
from vizbot.core.types import Intrinsics, RGBDFrame


class SimulatedRealSense:
    """A `Camera` on the mast of the world's robot; it never ends.

    No other reader may take the motion from the world.
    """

    def __init__(self, world: World, clock: Clock, config: SimulatedRealSenseConfig) -> None:
        """Open a camera in `world` on `clock`; the caller closes the world."""
        self._world = world
        self._clock = clock
        self._config = config
        self._exposure = AutoExposure(config.colour_noise)
        rng = np.random.default_rng((world.seed, 2))
        self._inertial = InertialSensor(config.inertial, world.T_base_cam, rng)
        self._frames = floor(clock.now() * config.rate + 1e-6)
        self._last = clock.now()
        self._closed = False
        world.drain_motion()

    @property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics that the camera reports; the true ones may differ."""
        return self._world.reported_intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame:
        """Let time pass until the next frame is due, and take it.

        A late caller gets the current frame, as from a camera that keeps only the newest one.

        Raises:
            DeviceTimeoutError: the next frame is due later than `timeout` [s] from now.
            DeviceError: the camera or the world is closed.
        """
        if self._closed:
            raise DeviceError("the simulated camera is closed; open it again")
        due = (self._frames + 1) / self._config.rate
        wait = due - self._clock.now()
        if wait > timeout + 1e-9:
            self._clock.sleep(timeout)
            raise DeviceTimeoutError(
                f"no frame from the simulated camera within {timeout} s; "
                f"it takes one every {1 / self._config.rate:.3g} s"
            )
        if wait > 0:
            self._clock.sleep(wait)
        stamp = self._clock.now()
        self._frames = floor(stamp * self._config.rate + 1e-6)
        seconds, motion = stamp - self._last, self._world.drain_motion()
        imu = self._inertial.sample(self._last, stamp, motion)
        self._last = stamp
        rgb, depth = self._world.render()
        colour, fx = self._config.colour_noise, self._world.intrinsics.fx
        shift = fx * _turned(motion, colour.exposure_time)
        gain = self._exposure.gain(rgb, seconds)
        T_world_cam = self._world.T_world_base @ self._world.T_base_cam
        # Noise belongs to the time of a frame, not to how many were taken before.
        rng = np.random.default_rng((self._world.seed, 4, self._frames))
        return RGBDFrame(
            stamp=stamp,
            rgb=noisy_colour(rgb, gain, shift, colour, rng),
            depth=noisy_depth(
                depth, rgb, self._world.intrinsics, T_world_cam, self._config.depth_noise, rng
            ),
            intrinsics=self.intrinsics,
            imu=imu,
        )

    def close(self) -> None:
        """Close the camera; closing twice is fine."""
        self._closed = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()


def _turned(motion: NDArray[np.float64], seconds: float) -> float:
    """Angle turned in the last `seconds` of a motion (N, 3) of seconds, speed, yaw rate [rad]."""
    lasts = np.diff(np.cumsum(motion[::-1, 0]).clip(max=seconds), prepend=0.0)
    return float(lasts @ motion[::-1, 2])
