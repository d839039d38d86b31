"""Settings of the Roomba driver."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class RoombaConfig(BaseModel):
    """Geometry, speed limits and timeouts of the base."""

    model_config = SETTINGS

    wheel_base: float = Field(default=0.235, ge=0.15, le=0.35)
    """Distance between the wheels [m]; the manual's value until calibrated."""
    wheel_scale: float = Field(default=1.0, ge=0.8, le=1.25)
    """Metres rolled for each metre that the encoders count [1]; 1 until calibrated."""
    max_wheel_speed: float = Field(default=0.5, ge=0.05, le=0.5)
    """Largest commanded speed of a wheel at its rim; the base accepts 0.5 at most [m/s]."""
    max_turn_rate: float = Field(default=2.0, ge=0.1, le=4.3)
    """Largest commanded turn rate; the base cannot turn faster than 4.3, with its wheels at 0.5 m/s
    either way [rad/s]."""
    acceleration: float = Field(default=0.8, ge=0.05, le=100.0)
    """Largest acceleration of a wheel at its rim [m/s^2]."""
    deceleration: float = Field(default=4.0, ge=0.2, le=100.0)
    """Largest deceleration of a wheel rim; commanded stops and reflexes are at once [m/s^2]."""
    command_timeout: float = Field(default=0.3, ge=0.05, le=0.5)
    """Time without a drive() after which the wheels stop; 0.5 at most, because a robot whose
    program hangs rolls on for 0.25 m in that time [s]."""
    silence_timeout: float = Field(default=0.18, ge=0.05, le=0.5)
    """Time without a valid frame after which the base counts as silent and a stop is sent; 0.5 at
    most, because the robot drives without bumper and cliff sensors meanwhile [s]."""
    echo_delay: float = Field(0.1, ge=0.03, le=0.5)
    """Largest delay of the speeds that the base reports as commanded, else it is stopped; 0.5 at
    most, because a base that took a corrupt command drives at other speeds meanwhile [s]."""
    echo_tolerance: float = Field(0.0, ge=0, le=0.05)
    """Largest difference of the speeds that the base reports as commanded, else it is stopped; 0.01
    suits firmware that rounds, and beyond 0.05 corrupt commands pass for rounded ones [m/s]."""
    start_timeout: float = Field(default=3.0, ge=0.1, le=60.0)
    """Time for the base to reach Safe mode when opened [s]."""
    reconnect_timeout: float = Field(default=60.0, ge=0.0, le=86400.0)
    """Time for the base to return after its cable was pulled out [s]."""
    mode_offset: int | None = Field(None, ge=0, le=1)
    """Offset of the reported mode, 1 for some firmware of the 600 series [1]; None detects it."""
    full_mode: bool = False
    """Drive in Full mode, in which the base does not stop by itself at cliffs or wheel drops."""
    resume_safe: bool = False
    """Return to Safe mode without a request after a cliff, a wheel drop, or a silence in which
    somebody may have moved the base, once no wheel hangs."""
