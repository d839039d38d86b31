"""What gyroscope and wheels read too much in turns, learned from images while the robot drives.

A gyroscope's sensitivity is off by up to some percent, wheels wear and sink into carpets: errors
that stay, so that a graph which takes them for chance turns with them, one way all the time.
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
    least: float = Field(default=0.001, gt=0.0)
    """What is left of both, however much is learned [1, rad/m]."""
    gate: float = Field(default=3.0, gt=0.0)
    """Images that contradict a turn by more standard deviations than this teach nothing."""


class TurnCalibration:
    """A Kalman filter of two constants: the error for each radian and for each metre."""

    def __init__(self, config: TurnCalibrationConfig) -> None:
        """Nothing is known yet but the size of errors."""
        self._config = config
        self._error = np.zeros(2)
        self._covariance = np.diag((config.per_radian**2, config.per_metre**2))

    def corrected(self, turn: float, distance: float) -> float:
        """A turn [rad] that was read over a distance, signed [m]."""
        return float(turn - self._error @ (turn, distance))

    def sigma(self, turn: float, distance: float) -> float:
        """What a corrected turn may still be off [rad]."""
        over = np.array((turn, distance))
        least = self._config.least * np.abs(over).sum()
        return float(np.hypot(np.sqrt(over @ self._covariance @ over), least))

    def learn(self, turn: float, distance: float, off: float, variance: float) -> None:
        """Take in that a turn was off.

        Args:
            turn: Corrected as far as was known [rad].
            distance: Driven meanwhile, signed [m].
            off: How much more that is than what images say [rad].
            variance: Of `off`, by the noise of both [rad^2].
        """
        over = np.array((turn, distance))
        spread = self._covariance @ over
        expected = float(over @ spread) + variance
        if off**2 <= self._config.gate**2 * expected:
            self._error = self._error + spread * (off / expected)
            self._covariance = self._covariance - np.outer(spread, spread) / expected
