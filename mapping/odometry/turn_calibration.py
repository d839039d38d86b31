"""What gyroscope and wheels read too much in turns, learned from images while the robot drives.

A gyroscope's sensitivity is off by up to some percent, its bias wanders as it warms up, wheels wear
and sink into carpets: errors that stay, so that a graph which takes them for chance turns with
them, one way all the time.
"""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class TurnCalibrationConfig(BaseModel):
    """How far a source of turns may be off."""

    model_config = SETTINGS

    per_radian: float = Field(ge=0.0)
    """Error at first as a fraction of the turn."""
    per_metre: float = Field(ge=0.0)
    """Error at first as a turn for each metre driven straight [rad/m]."""
    wander: float = Field(default=0.0, ge=0.0)
    """How far the error for each second wanders in a second [rad/s/sqrt(s)]; it is none at first,
    until somebody knows it (`know_rate`)."""
    least: float = Field(default=0.001, gt=0.0)
    """What is left of the first two, however much is learned [1, rad/m]."""
    gate: float = Field(default=3.0, gt=0.0)
    """Images that contradict a turn by more standard deviations than this teach nothing."""


class TurnCalibration:
    """A Kalman filter of the errors for each radian, metre and second."""

    def __init__(self, config: TurnCalibrationConfig) -> None:
        """Nothing is known yet but the size of errors."""
        self._config = config
        self._error = np.zeros(3)
        self._covariance = np.diag((config.per_radian**2, config.per_metre**2, 0.0))

    def corrected(self, turn: float, distance: float, period: float) -> float:
        """A turn [rad] that was read over a distance, signed [m], and a time [s]."""
        return float(turn - self._error @ (turn, distance, period))

    def sigma(self, turn: float, distance: float, period: float) -> float:
        """What a corrected turn may still be off [rad]."""
        over = np.array((turn, distance, period))
        least = self._config.least * np.abs(over[:2]).sum()
        return float(np.hypot(np.sqrt(over @ self._covariance @ over), least))

    def know_rate(self, sigma: float) -> None:
        """The error for each second has been taken out but for this [rad/s]."""
        self._error[2] = 0.0
        self._covariance[2], self._covariance[:, 2] = 0.0, 0.0
        self._covariance[2, 2] = sigma**2

    def shift_rate(self, taken_out: float) -> None:
        """So much more of the error for each second is taken out elsewhere now [rad/s]."""
        self._error[2] -= taken_out

    def wait(self, period: float) -> None:
        """Time passes [s]."""
        self._covariance[2, 2] += self._config.wander**2 * period

    def learn(
        self, turn: float, distance: float, period: float, off: float, variance: float
    ) -> bool:
        """Take in that a turn was off, unless it is off by more than can be.

        Args:
            turn: Corrected as far as was known [rad].
            distance: Driven meanwhile, signed [m].
            period: Time that it took [s].
            off: How much more that is than what is known better [rad].
            variance: Of `off`, by noise alone [rad^2].

        Returns:
            Whether it could be.
        """
        over = np.array((turn, distance, period))
        spread = self._covariance @ over
        expected = float(over @ spread) + variance
        if off**2 > self._config.gate**2 * expected:
            return False
        self._error = self._error + spread * (off / expected)
        self._covariance = self._covariance - np.outer(spread, spread) / expected
        return True
