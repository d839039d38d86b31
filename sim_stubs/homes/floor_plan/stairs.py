"""Places for the stairs of a home.

World frame: z up, the home's floor at z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal

YAWS = {"S": 0.0, "E": pi / 2, "N": pi, "W": -pi / 2}
"""Yaw of a piece whose front looks that way [rad]."""


@dataclass(frozen=True, slots=True)
class Stairs:
    """A place for stairs.

    Attributes:
        kind: "up" for stairs on the floor, "down" for stairs in a hole of it.
        shape: "straight", "quarter-turn" or "spiral"; those downwards are straight.
        x: Middle of the place [m].
        y: Middle of the place [m].
        facing: Direction of their front, from which one steps onto them: N, E, S or W.
        width: Along their front [m].
        depth: From front to back [m].
        open_sides: Those of "left", "right" and "back" without a wall beside them, seen by someone
            who steps onto them.
    """

    kind: Literal["up", "down"]
    shape: Literal["straight", "quarter-turn", "spiral"]
    x: float
    y: float
    facing: Literal["N", "E", "S", "W"]
    width: float
    depth: float
    open_sides: tuple[Literal["left", "right", "back"], ...] = ()

    @property
    def yaw(self) -> float:
        """Yaw of the piece of the stairs [rad]."""
        return YAWS[self.facing]

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """West, south, east and north edge of the place [m]."""
        across = self.facing in "NS"
        w, d = (self.width, self.depth) if across else (self.depth, self.width)
        return self.x - w / 2, self.y - d / 2, self.x + w / 2, self.y + d / 2

    @property
    def approach(self) -> tuple[float, float, float, float]:
        """West, south, east and north edge of the floor before their front, to keep free [m]."""
        x0, y0, x1, y1 = self.bounds
        return {
            "N": (x0, y1, x1, y1 + 0.9),
            "S": (x0, y0 - 0.9, x1, y0),
            "E": (x1, y0, x1 + 0.9, y1),
            "W": (x0 - 0.9, y0, x0, y1),
        }[self.facing]
