"""A D435i in a simulated world: colour, depth, gyroscope and accelerometer as `Camera`.

The world gives the true motion of its planar base in steps of constant speed and yaw rate; the
acceleration is the change from one step to the next. Inertial samples are in the axes of `cam`.
"""

from __future__ import annotations

from math import floor

import numpy as np
from numpy.typing import NDArray

from sim_stubs.realsense.config import InertialConfig, SimulatedRealSenseConfig
from sim_stubs.realsense.depth_noise import AutoExposure, noisy_colour, noisy_depth
from sim_stubs.world.world import World
from vizbot.core.closeable import Closeable
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.interfaces import Clock
from vizbot.core.types import SE3, ImuSamples, Intrinsics, RGBDFrame

GRAVITY = 9.80665
"""Standard gravity [m/s^2]."""


class InertialSensor:
    """A sensor that turns motion into samples, with its biases and its last speed."""

    def __init__(self, config: InertialConfig, T_base_cam: SE3, rng: np.random.Generator) -> None:
        """Draw the biases from `rng`."""
        self._config = config
        self._T_base_cam = T_base_cam
        self._rng = rng
        self._gyro_bias = config.gyro_bias * rng.standard_normal(3)
        self._accel_bias = config.accel_bias * rng.standard_normal(3)
        self._gyro_scale = 1.0 + config.gyro_scale * rng.standard_normal()
        self._last = np.zeros(2)

    def sample(self, start: float, end: float, motion: NDArray[np.float64]) -> ImuSamples:
        """Samples with stamps in (start, end].

        Args:
            start: Start of the period and of `motion` [s].
            end: End of the period [s].
            motion: (N, 3) seconds, speed [m/s], yaw rate [rad/s]; at rest where it does not reach.
        """
        steps = motion if len(motion) else np.array([[max(end - start, 1e-3), 0.0, 0.0]])
        ends = start + np.cumsum(steps[:, 0])
        speeds = steps[:, 1:]
        changes = np.diff(np.vstack([self._last, speeds]), axis=0) / steps[:, :1]
        self._last = speeds[-1]
        v, yaw_rate = speeds.T
        dv, dyaw = changes.T
        rates = np.column_stack([np.zeros_like(v), np.zeros_like(v), yaw_rate])
        # The camera sits ahead of the axle: it is carried around it too.
        ahead = self._T_base_cam[0, 3]
        forces = np.column_stack(
            [dv - ahead * yaw_rate**2, v * yaw_rate + ahead * dyaw, np.full_like(v, GRAVITY)]
        )
        config = self._config
        gyro_stamps = _stamps(start, end, config.gyro_rate)
        accel_stamps = _stamps(start, end, config.accel_rate)
        return ImuSamples(
            gyro_stamps,
            self._measured(
                self._gyro_scale * rates, ends, gyro_stamps, config.gyro_noise, self._gyro_bias
            ),
            accel_stamps,
            self._measured(forces, ends, accel_stamps, config.accel_noise, self._accel_bias),
        )

    def _measured(
        self,
        in_base: NDArray[np.float64],
        ends: NDArray[np.float64],
        stamps: NDArray[np.float64],
        noise: float,
        bias: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """(N, 3) in `cam` at `stamps`, of steps that last until `ends`."""
        step = np.searchsorted(ends, stamps - 1e-9).clip(max=len(ends) - 1)
        true = in_base[step] @ self._T_base_cam[:3, :3]
        return np.asarray(true + bias + noise * self._rng.standard_normal(true.shape))


def _stamps(start: float, end: float, rate: float) -> NDArray[np.float64]:
    """Whole multiples of 1 / rate in (start, end]."""
    first = np.floor(start * rate + 1e-6) + 1
    last = np.floor(end * rate + 1e-6)
    return np.asarray(np.arange(first, last + 1) / rate)


class SimulatedRealSense(Closeable):
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


def _turned(motion: NDArray[np.float64], seconds: float) -> float:
    """Angle turned in the last `seconds` of a motion (N, 3) of seconds, speed, yaw rate [rad]."""
    lasts = np.diff(np.cumsum(motion[::-1, 0]).clip(max=seconds), prepend=0.0)
    return float(lasts @ motion[::-1, 2])
