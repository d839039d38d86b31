"""Rectangular rooms on the plan: their fit sizes, and whether a set of them makes a home."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np

WALL = 0.1
"""Thickness between rooms [m]."""
AREAS = {
    "living room": (16.0, 30.0),
    "kitchen": (9.0, 16.0),
    "bathroom": (4.0, 8.0),
    "bedroom": (10.0, 16.0),
    "kid's room": (9.0, 15.0),
    "laundry room": (4.0, 8.0),
    "study": (7.0, 13.0),
}
"""Smallest and largest floor [m^2]."""
NARROWEST = {
    "living room": 3.3,
    "kitchen": 2.3,
    "bathroom": 1.65,
    "bedroom": 2.6,
    "kid's room": 2.5,
    "laundry room": 1.6,
    "study": 2.2,
}
"""Least width [m]."""
LONGEST = 2.1
"""Largest ratio of a room's sides."""


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A room's floor on the plan.

    Attributes:
        name: "kitchen", ...; "hallway" for its legs, "stairs" for a niche that opens onto it.
        x0: West wall [m].
        y0: South wall [m].
        x1: East wall [m].
        y1: North wall [m].
    """

    name: str
    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width(self) -> float:
        """Along x [m]."""
        return self.x1 - self.x0

    @property
    def length(self) -> float:
        """Along y [m]."""
        return self.y1 - self.y0

    @property
    def area(self) -> float:
        """Area of the floor [m^2]."""
        return self.width * self.length

    def gap(self, other: Rectangle) -> tuple[float, float]:
        """Free distance to another along x and y [m]; negative where the two overlap."""
        return (
            max(self.x0, other.x0) - min(self.x1, other.x1),
            max(self.y0, other.y0) - min(self.y1, other.y1),
        )


def sound(rectangles: Sequence[Rectangle]) -> bool:
    """Whether nothing overlaps, no chink is left between rooms and no yard is closed in."""
    for one, other in combinations(rectangles, 2):
        dx, dy = one.gap(other)
        if max(dx, dy) < WALL - 1e-6:
            return False
        chink = max(dx, dy)
        if min(dx, dy) < -0.3 and WALL + 0.01 < chink < 0.9:
            return False
    scale = 20.0
    low = np.min([(r.x0, r.y0) for r in rectangles], axis=0) - 0.5
    high = np.max([(r.x1, r.y1) for r in rectangles], axis=0) + 0.5
    columns, rows = np.ceil((high - low) * scale).astype(int)
    outside = np.ones((rows, columns), np.uint8)
    for r in rectangles:
        a, b = ((np.array([r.x0, r.y0]) - low - WALL) * scale).astype(int)
        c, d = ((np.array([r.x1, r.y1]) - low + WALL) * scale).astype(int)
        outside[b : d + 1, a : c + 1] = 0
    return cv2.connectedComponents(outside, connectivity=4)[0] == 2


def kitchen_beside_living_room(rectangles: Sequence[Rectangle]) -> bool:
    """Whether the two share a wall wide enough for a passage."""
    (kitchen,) = (r for r in rectangles if r.name == "kitchen")
    (living,) = (r for r in rectangles if r.name == "living room")
    dx, dy = kitchen.gap(living)
    return max(dx, dy) < WALL + 0.01 and min(dx, dy) < -1.9
