"""Settings of the robot's calibration."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS

_Rate = Annotated[float, Field(ge=-1.0, le=1.0)]


class ResidualsConfig(BaseModel):
    """Residuals of a calibration."""

    model_config = SETTINGS

    axle: float = Field(default=0.0, ge=0.0, le=1.0)
    """Apparent motion of the middle of the axle in the turn (RMS) [m]."""
    floor: float = Field(default=0.0, ge=0.0, le=1.6)
    """Angle between the floor's normal and the axis of the turn [rad]."""
    height: float = Field(default=0.0, ge=0.0, le=1.0)
    """Spread of the camera's height [m]."""
    wheel_base: float = Field(default=0.0, ge=0.0, le=1.0)
    """Half the difference between the turns to the left and to the right, as a fraction [1]."""
    wheel_scale: float = Field(default=0.0, ge=0.0, le=1.0)
    """Half the difference between the distances ahead and back, as a fraction [1]."""
    yaw: float = Field(default=0.0, ge=0.0, le=1.6)
    """Half the angle between the headings ahead and back [rad]."""
    gyro_bias: float = Field(default=0.0, ge=0.0, le=1.0)
    """Standard error of the mean of the rates at rest [rad/s]."""


class CalibrationConfig(BaseModel):
    """When wheels and mount were calibrated, and how well."""

    model_config = SETTINGS

    date: str = ""
    """Date of the calibration; empty before `vizbot calibrate`, which sets it."""
    gyro_bias: tuple[_Rate, _Rate, _Rate] | None = None
    """Rates of the gyroscope at rest, in `cam`, for information: each run learns them anew
    [rad/s]."""
    residuals: ResidualsConfig = ResidualsConfig()
