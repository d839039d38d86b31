"""Places for the stairs of a home.

World frame: z up, the home's floor at z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np

from sim_stubs.homes.floor_plan.room_layout import Rectangle

YAWS = {"S": 0.0, "E": pi / 2, "N": pi, "W": -pi / 2}
"""Yaw of a piece whose front looks that way [rad]."""
Random = np.random.Generator
Side = Literal["N", "E", "S", "W"]
BEHIND: dict[Side, Side] = {"N": "S", "S": "N", "E": "W", "W": "E"}
LEFT: dict[Side, Side] = {"N": "E", "S": "W", "E": "S", "W": "N"}
"""Left of someone who steps onto stairs that face there."""
_FRONTS: dict[tuple[bool, bool], Side] = {
    (True, True): "S",
    (True, False): "N",
    (False, True): "W",
    (False, False): "E",
}
"""Front of a niche: beside a hallway along y or along x, and on which side of it."""


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


@dataclass(frozen=True, slots=True)
class StairChoice:
    """The stairs of a home, chosen before there is a plan.

    Attributes:
        kind: "up" or "down".
        shape: As in `Stairs`.
        width: Along their front [m].
        depth: Largest depth from front to back [m].
        in_niche: Whether they have a niche of the hallway, else they stand in the living room.
    """

    kind: Literal["up", "down"]
    shape: Literal["straight", "quarter-turn", "spiral"]
    width: float
    depth: float
    in_niche: bool


def stair_choice(rng: Random, held_out: bool) -> StairChoice:
    """Stairs up or down, with a size; a benchmark home leads up by a spiral, the catalogue's."""
    in_niche = bool(rng.random() < 0.7)
    width = round(float(rng.uniform(0.88, 1.05)), 2)
    if rng.random() < 0.5:
        depth = float(rng.uniform(2.3, 3.2))
        return StairChoice("down", "straight", width, round(depth, 2), in_niche)
    shape = 2 if held_out else int(rng.integers(3))
    if shape == 0:
        depth = float(rng.uniform(2.9, 3.5))
        return StairChoice("up", "straight", width, round(depth, 2), in_niche)
    if shape == 1:
        side = round(float(rng.uniform(2.25, 2.5)), 2)
        return StairChoice("up", "quarter-turn", side, side, in_niche)
    side = round(float(rng.uniform(1.5, 1.7)), 2)
    return StairChoice("up", "spiral", side, side, in_niche)


def in_niche(rng: Random, choice: StairChoice, niche: Rectangle, hall: Rectangle) -> Stairs | None:
    """Stairs at the back of a niche of their width; None where it is not deep enough."""
    dx, dy = niche.gap(hall)
    north_or_east = niche.y0 > hall.y0 if dy > dx else niche.x0 > hall.x0
    facing = _FRONTS[dy > dx, north_or_east]
    room = niche.length if facing in "NS" else niche.width
    depth = min(choice.depth, room - 0.1)
    if depth < (2.8 if (choice.kind, choice.shape) == ("up", "straight") else 1.5):
        return None
    if choice.kind == "down" and depth < 2.25:
        return None
    across = niche.width if facing in "NS" else niche.length
    return _at_back(choice, niche, facing, across, depth)


def in_living_room(rng: Random, choice: StairChoice, room: Rectangle) -> Stairs | None:
    """Stairs in a corner, the back and one side to walls; None where the room is too small."""
    sides: tuple[Side, ...] = ("N", "E", "S", "W")
    options = []
    for facing in sides:
        along, across = room.length, room.width
        if facing in "EW":
            along, across = across, along
        if along >= choice.depth + 1.5 and across >= choice.width + 2.2:
            options.append(facing)
    if not options:
        return None
    facing = options[int(rng.integers(len(options)))]
    at_left = bool(rng.random() < 0.5)
    wall = LEFT[facing] if at_left else BEHIND[LEFT[facing]]
    x0, y0, x1, y1 = room.x0, room.y0, room.x1, room.y1
    w = choice.width
    strip = {
        "N": Rectangle("", x0, y1 - w, x1, y1),
        "S": Rectangle("", x0, y0, x1, y0 + w),
        "E": Rectangle("", x1 - w, y0, x1, y1),
        "W": Rectangle("", x0, y0, x0 + w, y1),
    }[wall]
    return _at_back(choice, strip, facing, w, choice.depth, ("right" if at_left else "left",))


def _at_back(
    choice: StairChoice,
    strip: Rectangle,
    facing: Side,
    width: float,
    depth: float,
    open_sides: tuple[Literal["left", "right", "back"], ...] = (),
) -> Stairs:
    """Stairs across a strip of floor, at the end away from where they face."""
    x, y = (strip.x0 + strip.x1) / 2, (strip.y0 + strip.y1) / 2
    x = {"E": strip.x0 + depth / 2, "W": strip.x1 - depth / 2}.get(facing, x)
    y = {"N": strip.y0 + depth / 2, "S": strip.y1 - depth / 2}.get(facing, y)
    return Stairs(choice.kind, choice.shape, x, y, facing, width, depth, open_sides)
