"""The wall of a room that an opening is in, and the floor in front of it."""

from __future__ import annotations

from sim_stubs.homes.floor_plan.walls import Opening
from sim_stubs.homes.geometry.bounding_block import Block, wall_span


def wall_of(opening: Opening, room: Block) -> str | None:
    """Direction that the wall of `room` with this opening faces; None where it is in none."""
    hole = Block(opening.x0, opening.y0, opening.x1, opening.y1)
    near = 0.02
    for facing, distance in (
        ("N", abs(hole.y1 - room.y0)),
        ("S", abs(hole.y0 - room.y1)),
        ("E", abs(hole.x1 - room.x0)),
        ("W", abs(hole.x0 - room.x1)),
    ):
        start, end = (hole.x0, hole.x1) if facing in "NS" else (hole.y0, hole.y1)
        low, high = wall_span(room, facing)
        if distance < near and start >= low - near and end <= high + near:
            return facing
    return None


def before_opening(hole: Block, room: Block, facing: str, depth: float) -> Block:
    """The floor of the room in front of an opening."""
    match facing:
        case "N":
            return Block(hole.x0, room.y0, hole.x1, room.y0 + depth)
        case "S":
            return Block(hole.x0, room.y1 - depth, hole.x1, room.y1)
        case "E":
            return Block(room.x0, hole.y0, room.x0 + depth, hole.y1)
        case _:
            return Block(room.x1 - depth, hole.y0, room.x1, hole.y1)
