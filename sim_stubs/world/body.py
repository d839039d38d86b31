"""The robot's body in its world, as the simulated base knows it; and a body on an empty floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from vizbot.core.diff_drive import rolled
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
