"""The pose of the base by wheels and gyroscope, and its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vizbot.core.geometry import invert
from vizbot.core.types import SE3

_BIAS_LASTS = 100.0
"""Time for which the error of the bias keeps its sign [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class DeadReckonedPose:
    """Pose of the base by dead reckoning, at one frame.

    Attributes:
        T_odom_base: By wheels and gyroscope, in the frame in which the wheels' own dead reckoning
            started.
        T_wheels_base: By the wheels alone.
        frames_without_gyro: Number of frames so far whose turn the wheels had to give.
        stamp: Time of the frame [s].
        turn_variance: Variance of all turns by gyroscope so far by its white noise [rad^2].
        bias_sigma: Standard deviation of the gyroscope's bias [rad/s].
        scale_sigma: Standard deviation of the gyroscope's scale.
        turned: Sum of all turns so far, left positive [rad].
    """

    T_odom_base: SE3
    T_wheels_base: SE3
    frames_without_gyro: int
    stamp: float
    turn_variance: float
    bias_sigma: float
    scale_sigma: float
    turned: float

    def gyro_since(self, before: DeadReckonedPose) -> bool:
        """Whether the gyroscope measured all turns since `before`."""
        return self.frames_without_gyro == before.frames_without_gyro

    def chained_gyro_sigma_since(self, before: DeadReckonedPose) -> float:
        """Standard deviation of the gyroscope's turn since `before`, as one link of a chain [rad].

        A pose graph takes the errors of its links for independent, but the bias errs one way in
        all of them. So each gets more of it, for the sum to be as uncertain as it truly is when the
        robot closes a loop.
        """
        noise = self.turn_variance - before.turn_variance
        period = self.stamp - before.stamp
        by_bias = self.bias_sigma**2 * period * max(period, _BIAS_LASTS)
        by_scale = self.scale_sigma * (self.turned - before.turned)
        return float(np.sqrt(noise + by_bias + by_scale**2))

    def since(self, before: DeadReckonedPose) -> SE3:
        """Motion of the base since `before`, T_before_now."""
        return invert(before.T_odom_base) @ self.T_odom_base

    def by_wheels_since(self, before: DeadReckonedPose) -> SE3:
        """Motion of the base since `before` by the wheels alone."""
        return invert(before.T_wheels_base) @ self.T_wheels_base

    def displaced(self, T_now_there: SE3, heading_variance: float) -> DeadReckonedPose:
        """Dead reckoning as if the base stood at `T_now_there` from where it is.

        Turns from there on are no better known than that heading, by its variance [rad^2].
        """
        return replace(
            self,
            T_odom_base=self.T_odom_base @ T_now_there,
            T_wheels_base=self.T_wheels_base @ T_now_there,
            turn_variance=self.turn_variance - heading_variance,
        )
