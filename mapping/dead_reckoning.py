"""The gyroscope's part in dead reckoning: wheels slip in turns, a gyroscope does not.

A gyroscope's error is its bias, a rate that it reads at rest. It is learned whenever the wheels
stand still, which they also do for a moment before a run begins to drive.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from pydantic import BaseModel, Field

from vizbot.core.geometry import invert, planar, yaw_of
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, ImuSamples, RGBDFrame


class GyroConfig(BaseModel):
    """Use of the gyroscope."""

    model_config = SETTINGS
    least_standing: float = Field(default=0.5, gt=0.0)
    """How long it must have stood before the bias is known [s]."""
    memory: float = Field(default=30.0, gt=0.0)
    """Standing time that the bias is a mean of; what is older fades [s]."""
    greatest_bias: float = Field(default=0.03, gt=0.0)
    """It reads no more than this at rest [rad/s]."""
    greatest_change: float = Field(default=0.005, gt=0.0)
    """Nor does that change by more than this once it is known [rad/s]."""
    rest: float = Field(default=0.02, gt=0.0)
    """Its samples spread no more than this at rest, about any axis [rad/s]."""
    greatest_gap: float = Field(default=0.05, gt=0.0)
    """Without samples for longer than this it does not know how far the robot turned [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Reckoning:
    """Where the base is by dead reckoning.

    Attributes:
        T_odom_base: Where wheels and gyroscope have it, in the frame in which the wheels' own dead
            reckoning began.
        T_wheels_base: Where the wheels alone have it.
        frames_without_gyro: Between how many frames until then the wheels had to say how far the
            robot turned.
    """

    T_odom_base: SE3
    T_wheels_base: SE3
    frames_without_gyro: int

    def gyro_since(self, before: Reckoning) -> bool:
        """Whether the gyroscope knows all that the robot turned since."""
        return self.frames_without_gyro == before.frames_without_gyro

    def since(self, before: Reckoning) -> SE3:
        """The way of the base, T_before_now."""
        return invert(before.T_odom_base) @ self.T_odom_base

    def by_wheels_since(self, before: Reckoning) -> SE3:
        """The same by the wheels alone."""
        return invert(before.T_wheels_base) @ self.T_wheels_base

    def at(self, T_now_there: SE3) -> Reckoning:
        """What it would be now if the base stood `T_now_there` from where it is."""
        return replace(
            self,
            T_odom_base=self.T_odom_base @ T_now_there,
            T_wheels_base=self.T_wheels_base @ T_now_there,
        )


class DeadReckoning:
    """Goes as far as the wheels say and turns as the gyroscope says."""

    def __init__(self, T_base_cam: SE3, config: GyroConfig) -> None:
        """The bias is unknown."""
        # Of an angular rate in `cam`, the part about the base's z axis.
        self._up_cam = T_base_cam[2, :3].copy()
        self._config = config
        self._bias = 0.0
        self._standing_time = 0.0
        self._stands = False
        self._stamp = 0.0
        self._T_wheels: SE3 | None = None
        self._now: Reckoning | None = None

    def follow(self, frame: RGBDFrame, T_odom_base: SE3) -> Reckoning:
        """Go on to `frame`.

        Args:
            frame: Newer than any before; its samples tell the turn since the one before.
            T_odom_base: Dead reckoning by the wheels alone.
        """
        start, self._stamp = self._stamp, frame.stamp
        before, self._T_wheels = self._T_wheels, T_odom_base
        if before is None or self._now is None:
            self._now = Reckoning(T_odom_base, T_odom_base, 0)
            return self._now
        step, without = invert(before) @ T_odom_base, self._now.frames_without_gyro
        angle = self._angle(frame.imu, start, frame.stamp)
        stood, self._stands = self._stands, bool(np.allclose(step, np.eye(4), atol=1e-9))
        if angle is not None and stood and self._stands:
            self._learn(frame.imu, angle / (frame.stamp - start), frame.stamp - start)
        if angle is not None and self._knows_bias:
            turn = angle - self._bias * (frame.stamp - start)
            # The way is an arc: its chord points half as far aside as it turns.
            aside = planar(0.0, 0.0, 0.5 * (turn - yaw_of(step)))
            x, y, _ = (aside @ step)[:3, 3]
            step = planar(x, y, turn)
        elif angle is None or not self._stands:
            without += 1
        self._now = Reckoning(self._now.T_odom_base @ step, T_odom_base, without)
        return self._now

    @property
    def _knows_bias(self) -> bool:
        return self._standing_time >= self._config.least_standing

    def _angle(self, imu: ImuSamples, start: float, end: float) -> float | None:
        """How far the base turned about its z axis, bias included [rad].

        None where nothing was measured for too long.
        """
        within = (imu.gyro_stamps > start) & (imu.gyro_stamps < end)
        stamps = np.concatenate([[start], imu.gyro_stamps[within], [end]])
        if not within.any() or np.diff(stamps).max() > self._config.greatest_gap:
            return None
        rates = imu.gyro[within] @ self._up_cam
        return float(np.trapezoid(np.concatenate([rates[:1], rates, rates[-1:]]), stamps))

    def _learn(self, imu: ImuSamples, rate: float, period: float) -> None:
        """Take a rate that was read with standing wheels for the bias, unless somebody moves it."""
        config = self._config
        change = abs(rate - self._bias)
        if change > (config.greatest_change if self._knows_bias else config.greatest_bias):
            return
        if imu.gyro.std(axis=0).max() > config.rest:
            return
        self._standing_time = min(self._standing_time + period, config.memory)
        self._bias += (rate - self._bias) * min(1.0, period / self._standing_time)
