"""Settings of the robot's calibration."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from vizbot.core.settings import Settings

_Rate = Annotated[float, Field(ge=-1.0, le=1.0)]


class ResidualsConfig(Settings):
    """Residuals of a calibration."""

    axle: float = Field(default=0.0, ge=0.0, le=1.0)
    """In the turn the middle of the axle seemed to move by this (RMS) [m]."""
    floor: float = Field(default=0.0, ge=0.0, le=1.6)
    """The floor's normal and the axis of the turn differed by this angle [rad]."""
    height: float = Field(default=0.0, ge=0.0, le=1.0)
    """The estimates of the camera's height spread by this [m]."""
    wheel_base: float = Field(default=0.0, ge=0.0, le=1.0)
    """The turns to the left and to the right differed by twice this, as a fraction [1]."""
    wheel_scale: float = Field(default=0.0, ge=0.0, le=1.0)
    """The distances ahead and back differed by twice this, as a fraction [1]."""
    yaw: float = Field(default=0.0, ge=0.0, le=1.6)
    """The headings ahead and back differed by twice this angle [rad]."""
    gyro_bias: float = Field(default=0.0, ge=0.0, le=1.0)
    """The mean of the rates at rest has this standard error [rad/s]."""


class CalibrationConfig(Settings):
    """Date and quality of the calibration of wheels and mount."""

    date: str = ""
    """The robot was calibrated on this date; it is empty until `vizbot calibrate` sets it."""
    gyro_bias: tuple[_Rate, _Rate, _Rate] | None = None
    """The gyroscope had these rates at rest, in `cam`, for information: each run learns them anew
    [rad/s]."""
    residuals: ResidualsConfig = ResidualsConfig()
