"""Detects a faulty gyroscope: images and wheels outvote it, or wheels alone do.

Where images show nothing, one turn does not reveal whether gyroscope or wheels are wrong. But
wheels that slip count too much, so that the true turn lies between theirs and zero; and a person
who turns the robot by hand, or an obstacle that it pivots on, turns it neither evenly nor for long.
A bias does both.
"""

from __future__ import annotations

import numpy as np

from mapping.odometry.config import GyroFaultsConfig, GyroVoteConfig


class GyroFaults:
    """Compares turns by gyroscope and wheels, span by span, where images show nothing."""

    def __init__(self, config: GyroFaultsConfig) -> None:
        self._config = config
        self.reset()

    @property
    def is_unsuspicious(self) -> bool:
        """Whether nothing speaks against the turns by gyroscope so far."""
        return not self._rates and self._period == 0.0

    def reset(self) -> None:
        """Drop the comparisons made so far."""
        self._rates: list[float] = []
        self._begin()

    def _begin(self) -> None:
        self._period, self._difference, self._left, self._right = 0.0, 0.0, 0.0, 0.0
        self._stood = True

    def finds_fault(self, gyro: float, wheels: float, period: float, stands: bool) -> bool:
        """Add a turn; whether the gyroscope was wrong since it became suspicious.

        Turns by gyroscope and wheels are in [rad], `period` in [s]; `stands`: the wheels stood
        still.
        """
        config = self._config
        self._period += period
        self._difference += gyro - wheels
        self._left += max(wheels, 0.0)
        self._right += max(-wheels, 0.0)
        self._stood &= stands
        if self._period < config.averaging_time:
            return False
        rate = self._difference / self._period
        slip = float(np.clip(self._difference, -self._left, self._right)) / self._period
        gate = config.gate + config.gate_growth * (self._left + self._right) / self._period
        if self._stood:
            gate = config.standing_gate
        carried = self._stood and abs(rate) > config.carried_rate
        uneven = abs(rate - float(np.mean(self._rates or [rate])))
        self._begin()
        if abs(rate - slip) > gate and not carried:
            self._rates = [rate] if uneven > gate else [*self._rates, rate]
        elif carried or uneven > min(gate, abs(rate)):
            self.reset()
        return len(self._rates) >= config.averages


class GyroVote:
    """Adds up the differences of gyroscope and wheels from images, and lets both vote."""

    def __init__(self, config: GyroVoteConfig) -> None:
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Drop the turns added so far."""
        self._period, self._variance = 0.0, 0.0
        self._gyro_off, self._wheels_off = 0.0, 0.0

    def outvotes(self, gyro_off: float, wheels_off: float, period: float, variance: float) -> bool:
        """Add a turn; whether images and wheels outvote the gyroscope.

        Both are turns less that by images [rad], whose `variance` is in [rad^2], in a `period` [s].
        """
        config = self._config
        self._period += period
        self._variance += variance
        self._gyro_off += gyro_off
        self._wheels_off += wheels_off
        if self._period < config.turning_time:
            return False
        difference = abs(self._gyro_off)
        limit = max(config.gate * self._period, config.sigmas * float(np.sqrt(self._variance)))
        wheels_agree = abs(self._wheels_off) < config.max_wheel_share * difference
        self.reset()
        return difference > limit and wheels_agree
