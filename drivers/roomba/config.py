"""Settings of the Roomba driver."""

from __future__ import annotations

from pydantic import Field

from vizbot.core.settings import BASIC, Settings


class RoombaConfig(Settings):
    """Geometry, speed limits and timeouts of the base."""

    wheel_base: float = Field(default=0.235, ge=0.15, le=0.35, json_schema_extra=BASIC)
    """The wheels are this far apart; it is the manual's value until calibrated [m]."""
    wheel_scale: float = Field(default=1.0, ge=0.8, le=1.25, json_schema_extra=BASIC)
    """The robot rolls this far for each metre that encoders count; 1 until calibrated [1]."""
    max_wheel_speed: float = Field(default=0.5, ge=0.05, le=0.5, json_schema_extra=BASIC)
    """A wheel is commanded at most this speed at its rim; the base accepts 0.5 at most [m/s]."""
    max_turn_rate: float = Field(default=2.0, ge=0.1, le=4.3, json_schema_extra=BASIC)
    """The base is commanded at most this turn rate; it cannot turn faster than 4.3, with its wheels
    at 0.5 m/s either way [rad/s]."""
    acceleration: float = Field(default=0.8, ge=0.05, le=100.0, json_schema_extra=BASIC)
    """A wheel speeds up by at most this at its rim [m/s^2]."""
    deceleration: float = Field(default=4.0, ge=0.2, le=100.0, json_schema_extra=BASIC)
    """A wheel rim slows down by at most this; commanded stops and reflexes are at once [m/s^2]."""
    command_timeout: float = Field(default=0.3, ge=0.05, le=0.5, json_schema_extra=BASIC)
    """The wheels stop after this time without a drive(); it is 0.5 at most, because a robot whose
    program hangs rolls on for 0.25 m in that time [s]."""
    silence_timeout: float = Field(default=0.18, ge=0.05, le=0.5, json_schema_extra=BASIC)
    """The base counts as silent and a stop is sent after this time without a valid frame; it is 0.5
    at most, because the robot drives without bumper and cliff sensors meanwhile [s]."""
    echo_delay: float = Field(0.1, ge=0.03, le=0.5)
    """The base is stopped where it does not report the commanded speeds within this time; it is 0.5
    at most, because a base that took a corrupt command drives at other speeds meanwhile [s]."""
    echo_tolerance: float = Field(0.0, ge=0, le=0.05)
    """The base is stopped where it reports commanded speeds that differ by more than this; 0.01
    suits firmware that rounds, and beyond 0.05 corrupt commands pass for rounded ones [m/s]."""
    start_timeout: float = Field(default=3.0, ge=0.1, le=60.0)
    """The base has this time to reach Safe mode when opened [s]."""
    reconnect_timeout: float = Field(default=60.0, ge=0.0, le=86400.0, json_schema_extra=BASIC)
    """The base has this time to return after its cable was pulled out [s]."""
    mode_offset: int | None = Field(None, ge=0, le=1)
    """The reported mode has this offset, 1 for some of the 600 series; None detects it [1]."""
    full_mode: bool = Field(default=False, json_schema_extra=BASIC)
    """This selects Full mode, in which the base does not stop itself at cliffs or wheel drops."""
    resume_safe: bool = Field(default=False, json_schema_extra=BASIC)
    """This says whether to return to Safe mode without a request after a cliff, a wheel drop, or a
    silence in which somebody may have moved the base, once no wheel hangs."""
