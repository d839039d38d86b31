"""The robot's body in its world: settings, what the simulated base knows of it, an empty floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from pydantic import BaseModel, Field

from vizbot.core.diff_drive import rolled
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True)
class Outline:
    """A round base with a mast [m].

    Attributes:
        radius: Radius of the base with its bumper.
        wheel_base: Distance of the wheels.
        mast_height: Height of the top of the mast.
        mast_forward: Distance of the mast ahead of the axle.
        mast_radius: Radius of mast and camera.
    """

    radius: float
    wheel_base: float
    mast_height: float
    mast_forward: float
    mast_radius: float


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


@dataclass(frozen=True, slots=True)
class Contacts:
    """Contacts of the robot with the true shapes of the world.

    Attributes:
        bump_left: Whether the bumper's left half is pressed.
        bump_right: Whether the bumper's right half is pressed.
        cliffs: Whether there is no floor under the left, front left, front right, right sensor.
        wheel_drops: Whether the left, right wheel hangs over an edge.
    """

    bump_left: bool = False
    bump_right: bool = False
    cliffs: tuple[bool, bool, bool, bool] = (False, False, False, False)
    wheel_drops: tuple[bool, bool] = (False, False)


class Body(Protocol):
    """A differential-drive robot in a world."""

    def set_wheel_speeds(self, left: float, right: float) -> None:
        """Turn the wheels at these rim speeds [m/s] until the next command."""
        ...

    def advance(self, seconds: float) -> None:
        """Let `seconds` pass: the wheels turn, the body moves, slips and bumps."""
        ...

    @property
    def wheel_travel(self) -> tuple[float, float]:
        """Signed rim travel of the left and right wheel since the start [m], slip included."""
        ...

    @property
    def contacts(self) -> Contacts:
        """Current contacts."""
        ...

    @property
    def T_world_base(self) -> SE3:
        """True pose of the base."""
        ...


class FreeFloor:
    """A `Body` on an infinite empty floor, which goes where its wheels roll and touches nothing."""

    def __init__(self, wheel_base: float = 0.235, T_world_base: SE3 | None = None) -> None:
        """Stand at a pose, or the origin; `wheel_base` is the track width [m]."""
        self._wheel_base = wheel_base
        self._speeds = (0.0, 0.0)
        self._travel = (0.0, 0.0)
        self._T_world_base = np.eye(4) if T_world_base is None else T_world_base

    @property
    def T_world_base(self) -> SE3:
        """True pose."""
        return self._T_world_base

    def set_wheel_speeds(self, left: float, right: float) -> None:
        """Turn the wheels at these rim speeds [m/s] until the next command."""
        self._speeds = left, right

    def advance(self, seconds: float) -> None:
        """Let the wheels roll for `seconds`."""
        left, right = (speed * seconds for speed in self._speeds)
        self._travel = self._travel[0] + left, self._travel[1] + right
        self._T_world_base = self._T_world_base @ rolled(left, right, self._wheel_base)

    def place(self, T_world_base: SE3) -> None:
        """Move the robot to another pose."""
        self._T_world_base = T_world_base

    @property
    def wheel_travel(self) -> tuple[float, float]:
        """Signed rim travel of the left and right wheel since the start [m]."""
        return self._travel

    @property
    def contacts(self) -> Contacts:
        """No contacts."""
        return Contacts()
