"""Gyroscope and accelerometer of a camera that rides on a planar base.

The world gives its true motion in steps of constant speed and yaw rate; the acceleration is the
change from one step to the next. Samples are in the axes of `cam`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_stubs.realsense.config import InertialConfig
from vizbot.core.types import SE3, ImuSamples

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
