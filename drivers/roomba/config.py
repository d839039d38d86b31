"""How the base is driven and read."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class RoombaConfig(BaseModel):
    """Geometry, limits and patience."""

    model_config = SETTINGS

    wheel_base: float = Field(0.235, gt=0)
    """Distance between the wheels [m]; the manual's value until calibrated."""
    wheel_scale: float = Field(1.0, gt=0)
    """Metres truly rolled for each metre that the encoders count; 1 until calibrated."""
    max_wheel_speed: float = Field(0.5, gt=0, le=0.5)
    """Fastest that a wheel is told to turn [m/s at the rim]; the base takes 0.5 at most."""
    max_turn_rate: float = Field(2.0, gt=0)
    """Fastest that the base is told to turn [rad/s]."""
    acceleration: float = Field(2.0, gt=0)
    """How fast a wheel's speed may grow [m/s^2 at the rim]."""
    deceleration: float = Field(4.0, gt=0)
    """How fast it may shrink [m/s^2]; reflexes stop the wheels at once."""
    command_timeout: float = Field(0.3, gt=0)
    """The wheels stop when no drive() came for so long [s]."""
    silence_timeout: float = Field(0.18, gt=0)
    """The base is silent when no valid frame came for so long; it is told to stop in the next
    period, before 0.2 are over [s]."""
    echo_delay: float = Field(0.1, ge=0.03)
    """What the base says that it was told may be so old [s], ..."""
    echo_tolerance: float = Field(0.0, ge=0)
    """... and so far off [m/s], or it is stopped; 0.01 helps if some firmware rounds."""
    start_timeout: float = Field(3.0, ge=0.1)
    """The base has so long to obey when opened [s]."""
    reconnect_timeout: float = Field(60.0, ge=0)
    """It has so long to come back when its cable is pulled out [s]."""
    mode_offset: int | None = Field(None, ge=0, le=1)
    """1 for the 600-series firmware that reports its mode one too high; None finds it out."""
    full_mode: bool = False
    """Drive in Full mode, in which the base does not stop by itself at cliffs or wheel drops."""
    resume_safe: bool = False
    """Obey again without being asked after a cliff or a wheel drop, as soon as no wheel hangs."""
