"""Systematic errors of gyroscope and wheels in turns, learned from images while the robot drives.

A gyroscope's sensitivity is off by up to some percent, its bias drifts as it warms up, wheels wear
and sink into carpets. These errors persist: a pose graph that takes them for noise turns with them,
one way all the time.
"""

from __future__ import annotations

import numpy as np

from mapping.odometry.config import TurnCalibrationConfig


class TurnCalibration:
    """A Kalman filter of the errors for each radian, metre and second of a source of turns."""

    def __init__(self, config: TurnCalibrationConfig) -> None:
        self._config = config
        self._error = np.zeros(3)
        self._covariance = np.diag((config.per_radian**2, config.per_metre**2, 0.0))

    def corrected(self, turn: float, distance: float, period: float) -> float:
        """Correct a turn [rad] that was measured over a signed distance [m] and a time [s]."""
        return float(turn - self._error @ (turn, distance, period))

    def sigma(self, turn: float, distance: float, period: float) -> float:
        """Standard deviation of a corrected turn [rad]."""
        over = np.array((turn, distance, period))
        least = self._config.least * np.abs(over[:2]).sum()
        return float(np.hypot(np.sqrt(over @ self._covariance @ over), least))

    def reset_rate(self, sigma: float) -> None:
        """Set the error for each second to 0, with a standard deviation [rad/s]."""
        self._error[2] = 0.0
        self._covariance[2], self._covariance[:, 2] = 0.0, 0.0
        self._covariance[2, 2] = sigma**2

    def shift_rate(self, taken_out: float) -> None:
        """Reduce the error for each second by what is corrected elsewhere from now on [rad/s]."""
        self._error[2] -= taken_out

    def predict(self, period: float) -> None:
        """Let the error for each second drift for a time [s]."""
        self._covariance[2, 2] += self._config.wander**2 * period

    def learn(
        self, turn: float, distance: float, period: float, off: float, variance: float
    ) -> bool:
        """Update with the error of a turn, unless it is larger than plausible.

        Args:
            turn: The corrected turn [rad].
            distance: Driven meanwhile, signed [m].
            period: Duration of the turn [s].
            off: The corrected turn less a better measurement of it [rad].
            variance: Of `off`, by noise alone [rad^2].

        Returns:
            Whether the error is plausible.
        """
        over = np.array((turn, distance, period))
        spread = self._covariance @ over
        expected = float(over @ spread) + variance
        if off**2 > self._config.gate**2 * expected:
            return False
        self._error = self._error + spread * (off / expected)
        self._covariance = self._covariance - np.outer(spread, spread) / expected
        return True
