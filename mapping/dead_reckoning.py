"""The gyroscope's part in dead reckoning: wheels slip in turns, a gyroscope does not.

A gyroscope's error is its bias, a rate that it reads at rest. It is learned whenever the wheels
stand still, which they also do for a moment before a run begins to drive.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from vizbot.core.geometry import invert, planar, yaw_of
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, ImuSamples, RGBDFrame


class GyroConfig(BaseModel):
    """Use of the gyroscope."""

    model_config = SETTINGS
    settling: float = Field(default=2.0, ge=0.0)
    """How long the robot stands at the start of a run [s]."""
    least_standing: float = Field(default=0.5, gt=0.0)
    """How long it must have stood before the bias is known [s]."""
    memory: float = Field(default=30.0, gt=0.0)
    """Standing time that the bias is a mean of; what is older fades [s]."""
    greatest_bias: float = Field(default=0.1, gt=0.0)
    """Somebody turns the robot where it reads more than this with standing wheels [rad/s]."""
    coverage: float = Field(default=0.7, gt=0.0, le=1.0)
    """Part of the time between two frames that its samples must span."""


@dataclass(frozen=True, slots=True, eq=False)
class Reckoning:
    """Where the base is by dead reckoning.

    Attributes:
        T_odom_base: Since the first frame of the run.
        turns_by_wheels: How often until then the wheels had to say how far the robot turned.
    """

    T_odom_base: SE3
    turns_by_wheels: int

    def gyro_since(self, before: Reckoning) -> bool:
        """Whether the gyroscope knows all that the robot turned since."""
        return self.turns_by_wheels == before.turns_by_wheels

    def since(self, before: Reckoning) -> SE3:
        """The way of the base, T_before_now."""
        return invert(before.T_odom_base) @ self.T_odom_base


class DeadReckoning:
    """Goes as far as the wheels say and turns as the gyroscope says."""

    def __init__(self, T_base_cam: SE3, config: GyroConfig) -> None:
        """The bias is unknown."""
        # Of an angular rate in `cam`, the part about the base's z axis.
        self._up_cam = T_base_cam[2, :3].copy()
        self._config = config
        self._bias = 0.0
        self._stood = 0.0
        self._stands = False
        self._stamp = 0.0
        self._T_wheels: SE3 | None = None
        self._now = Reckoning(np.eye(4), 0)

    def follow(self, frame: RGBDFrame, T_odom_base: SE3) -> Reckoning:
        """Go on to `frame`.

        Args:
            frame: Newer than any before; its samples tell the turn since the one before.
            T_odom_base: Dead reckoning by the wheels alone.
        """
        period, self._stamp = frame.stamp - self._stamp, frame.stamp
        before, self._T_wheels = self._T_wheels, T_odom_base
        if before is None:
            self._now = Reckoning(T_odom_base, 0)
            return self._now
        step, turns_by_wheels = invert(before) @ T_odom_base, self._now.turns_by_wheels
        rate = self._rate(frame.imu, period)
        stood, self._stands = self._stands, bool(np.allclose(step, np.eye(4), atol=1e-9))
        if rate is not None and stood and self._stands:
            self._learn(rate, period)
        if rate is not None and self._stood >= self._config.least_standing:
            turn = (rate - self._bias) * period
            # The way is an arc: its chord points half as far aside as it turns.
            aside = planar(0.0, 0.0, 0.5 * (turn - yaw_of(step)))
            x, y, _ = (aside @ step)[:3, 3]
            step = planar(x, y, turn)
        else:
            turns_by_wheels += 1
        self._now = Reckoning(self._now.T_odom_base @ step, turns_by_wheels)
        return self._now

    def _rate(self, imu: ImuSamples, period: float) -> float | None:
        """Mean rate about the base's z axis [rad/s]; None where too little of it was measured."""
        stamps = imu.gyro_stamps
        if len(stamps) < 2 or stamps[-1] - stamps[0] < self._config.coverage * period:
            return None
        return float((imu.gyro @ self._up_cam).mean())

    def _learn(self, rate: float, period: float) -> None:
        if abs(rate) > self._config.greatest_bias:
            return
        self._stood = min(self._stood + period, self._config.memory)
        self._bias += (rate - self._bias) * min(1.0, period / self._stood)
