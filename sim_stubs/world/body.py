"""What the simulated base asks of the world it stands in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True)
class Contacts:
    """What touches the robot, from the true shapes of the world.

    Attributes:
        bump_left: The bumper's left half is pressed.
        bump_right: The bumper's right half is pressed.
        cliffs: Left, front left, front right, right: no floor under that sensor.
        wheel_drops: Left, right: the wheel hangs over an edge.
    """

    bump_left: bool = False
    bump_right: bool = False
    cliffs: tuple[bool, bool, bool, bool] = (False, False, False, False)
    wheel_drops: tuple[bool, bool] = (False, False)


class Body(Protocol):
    """A differential-drive robot in a world."""

    def set_wheel_speeds(self, left: float, right: float) -> None:
        """Turn the wheels at these rim speeds [m/s] until told otherwise."""
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
        """What touches the robot now."""
        ...

    @property
    def T_world_base(self) -> SE3:
        """Where it truly is."""
        ...
