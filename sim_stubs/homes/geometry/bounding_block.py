"""Axis-aligned blocks of space: the room that furniture takes, and where it can stand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, pi

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import Instance

FACING = {"S": 0.0, "E": pi / 2, "N": pi, "W": -pi / 2}
"""Yaw of a piece whose front looks that way."""
AHEAD = {"S": (0, -1), "E": (1, 0), "N": (0, 1), "W": (-1, 0)}
"""Unit vector on the plan that way."""
OPPOSITE = {"S": "N", "N": "S", "E": "W", "W": "E"}


@dataclass(frozen=True, slots=True)
class Block:
    """A block of space [m]."""

    x0: float
    y0: float
    x1: float
    y1: float
    z0: float = 0.0
    z1: float = inf

    @staticmethod
    def around(instance: Instance) -> Block:
        """The bounding block of an instance."""
        (x0, y0), (x1, y1) = instance.footprint.min(axis=0), instance.footprint.max(axis=0)
        top = instance.elevation + float(instance.piece.size[2])
        return Block(float(x0), float(y0), float(x1), float(y1), instance.elevation, top)

    @property
    def centre(self) -> tuple[float, float]:
        """x, y of its middle [m]."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    def overlaps(self, other: Block, slack: float = 1e-6) -> bool:
        """Whether they share space."""
        return (
            self.x0 < other.x1 - slack
            and other.x0 < self.x1 - slack
            and self.y0 < other.y1 - slack
            and other.y0 < self.y1 - slack
            and self.z0 < other.z1 - slack
            and other.z0 < self.z1 - slack
        )

    def inside(self, other: Block) -> bool:
        """Whether it lies within `other` on the plan."""
        return (
            self.x0 >= other.x0 - 1e-6
            and self.x1 <= other.x1 + 1e-6
            and self.y0 >= other.y0 - 1e-6
            and self.y1 <= other.y1 + 1e-6
        )

    def grown(self, margin: float) -> Block:
        """Larger by `margin` [m] to the four sides."""
        return replace(
            self,
            x0=self.x0 - margin, y0=self.y0 - margin, x1=self.x1 + margin, y1=self.y1 + margin,
        )  # fmt: skip

    def ahead(self, facing: str, depth: float, start: float = 0.0) -> Block:
        """The floor in front of it, as wide as it is, from `start` to `depth` [m]."""
        dx, dy = AHEAD[facing]
        if dx:
            edge = self.x1 if dx > 0 else self.x0
            near, far = sorted((edge + dx * start, edge + dx * depth))
            return Block(near, self.y0, far, self.y1)
        edge = self.y1 if dy > 0 else self.y0
        near, far = sorted((edge + dy * start, edge + dy * depth))
        return Block(self.x0, near, self.x1, far)


def at_wall(
    room: Block, facing: str, along: float, size: NDArray[np.float64], gap: float, z0: float
) -> Block:
    """A block with its back to the wall of `room` from which `facing` looks away.

    Args:
        room: The floor.
        facing: Direction of the front.
        along: Middle of the block along the wall: x or y [m].
        size: (3,) width along the wall, depth, height [m].
        gap: Between wall and back [m].
        z0: Height of its underside [m].
    """
    w, d, h = (float(v) for v in size)
    z1, a, b = z0 + h, along - w / 2, along + w / 2
    match facing:
        case "N":
            return Block(a, room.y0 + gap, b, room.y0 + gap + d, z0, z1)
        case "S":
            return Block(a, room.y1 - gap - d, b, room.y1 - gap, z0, z1)
        case "E":
            return Block(room.x0 + gap, a, room.x0 + gap + d, b, z0, z1)
        case _:
            return Block(room.x1 - gap - d, a, room.x1 - gap, b, z0, z1)


def wall_span(room: Block, facing: str) -> tuple[float, float]:
    """The ends of that wall: x or y [m]."""
    return (room.x0, room.x1) if facing in "NS" else (room.y0, room.y1)


def facing_of(instance: Instance) -> str:
    """Direction of its front, to the nearest of N, E, S, W."""
    ahead = np.array([np.sin(instance.yaw), -np.cos(instance.yaw)])
    return max(AHEAD, key=lambda way: float(ahead @ AHEAD[way]))


def centred(x: float, y: float, size: NDArray[np.float64], facing: str) -> Block:
    """The block of a piece that stands on the floor around a point."""
    w, d = (float(v) / 2 for v in (size[:2] if facing in "NS" else size[1::-1]))
    return Block(x - w, y - d, x + w, y + d, 0.0, float(size[2]))


def beyond(
    before: Block, facing: str, size: NDArray[np.float64], gap: float, shift: float
) -> Block:
    """The block of a piece `gap` ahead of another block, moved sideways by `shift` [m]."""
    x, y = before.centre
    dx, dy = AHEAD[facing]
    reach = gap + float(size[1]) / 2
    half = (before.x1 - before.x0) / 2 if dx else (before.y1 - before.y0) / 2
    x += dx * (half + reach) + abs(dy) * shift
    y += dy * (half + reach) + abs(dx) * shift
    return centred(x, y, size, facing)
