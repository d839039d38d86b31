"""Notices a gyroscope that lies: images and wheels outvote it, or wheels alone do.

Where images show nothing, one turn does not tell whether it or the wheels are wrong. But wheels
that slip count too much, so that the
truth lies between what they say and nothing; and who turns the robot by hand, or an obstacle that
it pivots on, does so neither evenly nor for long. A bias does both.
"""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class GyroFaultsConfig(BaseModel):
    """When the wheels are believed rather than the gyroscope."""

    model_config = SETTINGS

    span: float = Field(default=1.0, gt=0.0)
    """Rates are means over so long: from frame to frame, wheels jitter [s]."""
    spans: int = Field(default=5, gt=0)
    """The gyroscope lies when so many in a row say so."""
    gate: float = Field(default=0.03, gt=0.0)
    """It turns apart from so much on [rad/s] ..."""
    gate_growth: float = Field(default=0.1, ge=0.0)
    """... and this fraction of what the wheels turn, ..."""
    standing_gate: float = Field(default=0.005, gt=0.0)
    """... from so much on while they stand still [rad/s]; ..."""
    carried: float = Field(default=0.1, gt=0.0)
    """... then, what is faster is somebody who turns the robot [rad/s]."""


class GyroFaults:
    """Compares turns by gyroscope and wheels, span by span."""

    def __init__(self, config: GyroFaultsConfig) -> None:
        """Nothing speaks against the gyroscope."""
        self._config = config
        self.forget()

    @property
    def suspects_nothing(self) -> bool:
        """Whether the gyroscope may be believed in all that it said before the next turn."""
        return not self._rates and self._period == 0.0

    def forget(self) -> None:
        """What was compared until now says nothing more."""
        self._rates: list[float] = []
        self._begin()

    def _begin(self) -> None:
        self._period, self._apart, self._left, self._right = 0.0, 0.0, 0.0, 0.0
        self._stood = True

    def catches_a_lie(self, gyro: float, wheels: float, period: float, stands: bool) -> bool:
        """Whether the next turn shows that the gyroscope has lied since something was suspected.

        Args:
            gyro: Turn by the gyroscope [rad].
            wheels: Turn by the wheels [rad].
            period: Time that it took [s].
            stands: Whether the wheels stood still.
        """
        config = self._config
        self._period += period
        self._apart += gyro - wheels
        self._left += max(wheels, 0.0)
        self._right += max(-wheels, 0.0)
        self._stood &= stands
        if self._period < config.span:
            return False
        rate = self._apart / self._period
        slip = float(np.clip(self._apart, -self._left, self._right)) / self._period
        gate = config.gate + config.gate_growth * (self._left + self._right) / self._period
        if self._stood:
            gate = config.standing_gate
        carried = self._stood and abs(rate) > config.carried
        uneven = abs(rate - float(np.mean(self._rates or [rate])))
        self._begin()
        if abs(rate - slip) > gate and not carried:
            self._rates = [rate] if uneven > gate else [*self._rates, rate]
        elif carried or uneven > min(gate, abs(rate)):
            self.forget()
        return len(self._rates) >= config.spans


class GyroVoteConfig(BaseModel):
    """When images and wheels are believed rather than the gyroscope."""

    model_config = SETTINGS

    span: float = Field(default=1.0, gt=0.0)
    """They vote on turns that took so long together [s]."""
    gate: float = Field(default=0.02, gt=0.0)
    """The gyroscope lies that turns apart from images by so much [rad/s], ..."""
    sigmas: float = Field(default=4.0, gt=0.0)
    """... which is so many times what images may be off, ..."""
    share: float = Field(default=0.5, gt=0.0)
    """... while wheels turn apart from them by less than this share of it."""


class GyroVote:
    """Adds up how far gyroscope and wheels turned apart from images."""

    def __init__(self, config: GyroVoteConfig) -> None:
        """Nothing speaks against the gyroscope."""
        self._config = config
        self.forget()

    def forget(self) -> None:
        """What was added up until now says nothing more."""
        self._period, self._variance = 0.0, 0.0
        self._gyro_off, self._wheels_off = 0.0, 0.0

    def outvotes(self, gyro_off: float, wheels_off: float, period: float, variance: float) -> bool:
        """Whether one more turn makes the gyroscope a liar.

        Args:
            gyro_off: How much farther the gyroscope turned than images [rad].
            wheels_off: The same of the wheels [rad].
            period: Time that it took [s].
            variance: Of the images' turn [rad^2].
        """
        config = self._config
        self._period += period
        self._variance += variance
        self._gyro_off += gyro_off
        self._wheels_off += wheels_off
        if self._period < config.span:
            return False
        apart = abs(self._gyro_off)
        limit = max(config.gate * self._period, config.sigmas * float(np.sqrt(self._variance)))
        lies = apart > limit and abs(self._wheels_off) < config.share * apart
        self.forget()
        return lies
