"""Where the base is by wheels and gyroscope, and how well they know it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vizbot.core.geometry import invert
from vizbot.core.types import SE3

_BIAS_LASTS = 100.0
"""The bias errs one way for about so long [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class DeadReckonedPose:
    """Where the base is by dead reckoning.

    Attributes:
        T_odom_base: Where wheels and gyroscope have it, in the frame in which the wheels' own dead
            reckoning began.
        T_wheels_base: Where the wheels alone have it.
        frames_without_gyro: Between how many frames until then the wheels had to say how far the
            robot turned.
        stamp: Time of the frame [s].
        turn_variance: Of the gyroscope's turns until then by its white noise [rad^2].
        bias_sigma: Error of its bias [rad/s].
        scale_sigma: Error of its turns for each radian.
        turned: All turns until then, to the left less those to the right [rad].
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
        """Whether the gyroscope knows all that the robot turned since."""
        return self.frames_without_gyro == before.frames_without_gyro

    def gyro_sigma_since(self, before: DeadReckonedPose) -> float:
        """Error of the gyroscope's turn since [rad]: noise adds up at random, bias does not."""
        return self._gyro_sigma_since(before, self.stamp - before.stamp)

    def chained_gyro_sigma_since(self, before: DeadReckonedPose) -> float:
        """The same for one turn of a chain in which each counts as if it erred for itself [rad].

        Their bias errs one way, so each needs more of it for the sum to be as uncertain as it is
        when the robot has been around and closes the loop.
        """
        return self._gyro_sigma_since(before, max(self.stamp - before.stamp, _BIAS_LASTS))

    def _gyro_sigma_since(self, before: DeadReckonedPose, bias_lasts: float) -> float:
        noise = self.turn_variance - before.turn_variance
        by_bias = self.bias_sigma**2 * (self.stamp - before.stamp) * bias_lasts
        by_scale = self.scale_sigma * (self.turned - before.turned)
        return float(np.sqrt(noise + by_bias + by_scale**2))

    def since(self, before: DeadReckonedPose) -> SE3:
        """The way of the base, T_before_now."""
        return invert(before.T_odom_base) @ self.T_odom_base

    def by_wheels_since(self, before: DeadReckonedPose) -> SE3:
        """The same by the wheels alone."""
        return invert(before.T_wheels_base) @ self.T_wheels_base

    def at(self, T_now_there: SE3, heading_variance: float) -> DeadReckonedPose:
        """What it would be now if the base stood `T_now_there` from where it is.

        Turns from there on are no better known than that heading, by its variance [rad^2].
        """
        return replace(
            self,
            T_odom_base=self.T_odom_base @ T_now_there,
            T_wheels_base=self.T_wheels_base @ T_now_there,
            turn_variance=self.turn_variance - heading_variance,
        )
