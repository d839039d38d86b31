"""Turns on the spot and ways straight ahead, by an angle or a distance that somebody named."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees

FARTHEST = 5.0
"""Longest way that may be asked for [m]."""


@dataclass(frozen=True, slots=True)
class ShortMove:
    """A turn or a way, one of them.

    Attributes:
        turn: Counterclockwise, -2 pi to 2 pi [rad].
        forward: 0 to `FARTHEST` [m].
    """

    turn: float = 0.0
    forward: float = 0.0

    @property
    def text(self) -> str:
        """In plain words."""
        if self.turn:
            return f"turn {'left' if self.turn > 0.0 else 'right'} {degrees(abs(self.turn)):.0f}°"
        return f"go forward {self.forward:.1f} m"
