"""Settings of the robot's calibration."""

from __future__ import annotations

from pydantic import BaseModel

from vizbot.core.settings import SETTINGS


class ResidualsConfig(BaseModel):
    """Residuals of a calibration."""

    model_config = SETTINGS

    axle: float = 0.0
    """Apparent motion of the middle of the axle in the turn (RMS) [m]."""
    floor: float = 0.0
    """Angle between the floor's normal and the axis of the turn [rad]."""
    height: float = 0.0
    """Spread of the camera's height [m]."""
    wheel_base: float = 0.0
    """Half the difference between the turns to the left and to the right, as a fraction."""
    wheel_scale: float = 0.0
    """Half the difference between the distances ahead and back, as a fraction."""
    yaw: float = 0.0
    """Half the angle between the headings ahead and back [rad]."""
    gyro_bias: float = 0.0
    """Standard error of the mean of the rates at rest [rad/s]."""


class CalibrationConfig(BaseModel):
    """When wheels and mount were calibrated, and how well."""

    model_config = SETTINGS

    date: str = ""
    """Date of the calibration; empty before `vizbot calibrate`, which sets it."""
    gyro_bias: tuple[float, float, float] | None = None
    """Rates of the gyroscope at rest, in `cam`, for information: each run learns them anew
    [rad/s]."""
    residuals: ResidualsConfig = ResidualsConfig()
