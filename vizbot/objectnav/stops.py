"""Where the robot stops before a thing: near by, but where the thing is in the picture.

The camera is low and sees little above the horizontal: from 1.1 m a window with its sill at 0.93 m
is out of the picture. The farther away, the more of a thing is in it, high or low.
"""

from __future__ import annotations

from math import inf, tan

import numpy as np
from numpy.typing import NDArray

from nav.config import Reach
from vizbot.config import Config

WITHIN = 2.0
"""A stop counts within this distance of the thing (paper, section IV-C) [m]."""
NEAR = 1.3
"""The robot stops within this distance of a thing that is in the picture from there [m]. Nearer, it
knows better what it sees and where: a version that stopped up to 1.8 m before any likely part of a
thing reached 32 of 44 goals in homes 1100 to 1102, and not 41."""
FARTHEST = 1.8
"""It stops within this distance of any thing [m]. What is left of `WITHIN` is for the errors, 0.1
to 0.2 m, of where the thing is thought to be, and the robot."""
BAND = 0.3
"""Width of the ring in which the robot stops, at least [m]. A narrower one may hold no cell that
can be reached."""
EXTENT = 0.6
"""An object is mostly within this distance of the point where it is thought to be [m]."""
HALF_HEIGHT = 0.2
"""What a patch shows of a thing lies within this of its mean height [m]."""
ROOM_REACH = Reach(distance=0.9, extent=EXTENT)
"""Where a room counts as arrived at: a robot that looks in from outside has not arrived."""
ROOM_LOOK = Reach(distance=1.3, extent=EXTENT)
"""Where a place is looked at that may be in a room."""


class Stops:
    """How far from a thing the robot stops, by its height."""

    def __init__(self, config: Config) -> None:
        mount, half = config.mount, config.objectnav.search.vertical_field_of_view / 2
        self._height, self._forward = mount.height, mount.forward
        self._up, self._down = tan(half - mount.tilt), tan(half + mount.tilt)

    def least(self, heights: NDArray[np.floating]) -> NDArray[np.float64]:
        """The distances (N,) from which what was seen at these heights is in the picture [m].

        What lies on the floor is looked at from `NEAR` all the same, and what hangs high from
        `FARTHEST`, which may be too near to see it.
        """
        most = np.where(heights > self._height, FARTHEST, NEAR) - BAND
        return np.minimum(self._to_show(heights), most)

    def reach(self, height: float) -> Reach:
        """Where a thing of this height is looked at, and counts as arrived at."""
        needed = float(self.least(np.array([height]))[0])
        return Reach(distance=max(needed + BAND, NEAR), extent=EXTENT)

    def sees(self, height: float) -> bool:
        """Whether some of what a patch shows at a height is in the picture from `WITHIN`."""
        lowest, highest = max(height - HALF_HEIGHT, 0.0), height + HALF_HEIGHT
        nearest = np.clip(self._height, lowest, highest)  # to the height of the camera
        return bool(self._to_show(np.array([nearest]))[0] <= WITHIN)

    def _to_show(self, heights: NDArray[np.floating]) -> NDArray[np.float64]:
        """The least distances (N,) of the robot from points at these heights that it sees [m]."""
        above = heights - self._height
        up = above / self._up if self._up > 0.0 else np.where(above > 0.0, inf, 0.0)
        down = -above / self._down if self._down > 0.0 else np.where(above < 0.0, inf, 0.0)
        return np.asarray(np.maximum(up, down) + self._forward, np.float64)
