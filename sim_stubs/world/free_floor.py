"""An infinite empty floor: a `Body` that goes where its wheels roll and touches nothing."""

from __future__ import annotations

import numpy as np

from sim_stubs.world.body import Contacts
from vizbot.core.diff_drive import rolled
from vizbot.core.types import SE3


class FreeFloor:
    """A robot on that floor."""

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
