"""Settings of the simulated robot's body."""

from __future__ import annotations

from pydantic import BaseModel, Field

from sim_stubs.world.body import Outline
from vizbot.core.settings import SETTINGS


class WorldConfig(BaseModel):
    """The body of the simulated robot."""

    model_config = SETTINGS

    robot_radius: float = Field(default=0.175, ge=0.1, le=0.5)
    """The base with its bumper has this radius [m]."""
    mast_radius: float = Field(default=0.06, ge=0.005, le=0.3)
    """The mast with the camera has this radius [m]."""
    wheel_base: float = Field(default=0.235, ge=0.15, le=0.35)
    """The wheels are truly this far apart [m]."""
    wheel_acceleration: float = Field(default=2.0, ge=0.1, le=50.0)
    """A wheel accelerates to its commanded speed by this [m/s^2]."""
    wheel_scale: float = Field(default=1.0, ge=0.5, le=2.0)
    """The robot truly rolls this many metres for each metre that a wheel counts [1]."""
    wheel_scale_noise: float = Field(default=0.003, ge=0.0, le=0.5)
    """Each wheel's scale errs by this standard deviation, as a fraction, drawn for a run [1]."""
    slip_noise: float = Field(default=0.003, ge=0.0, le=1.0)
    """A wheel slips by this standard deviation over 1 m, which grows with the square root [m]."""
    step: float = Field(default=0.015, ge=0.001, le=0.1)
    """One step of the motion is at most this long [s]."""

    def outline(self, height: float, forward: float) -> Outline:
        """The robot with a camera at this height and so far ahead of the axle [m]."""
        return Outline(self.robot_radius, self.wheel_base, height + 0.05, forward, self.mast_radius)
