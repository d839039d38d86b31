"""The goal of a rehearsal: a yellow chair out of the robot's sight, and a decoy elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import hypot, pi

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furniture.paint import COLOURS, painted_plain
from sim_stubs.homes.geometry.bounding_block import FACING
from sim_stubs.homes.geometry.house import House, Instance, Room
from sim_stubs.homes.geometry.occupancy_slice import PASSAGE, FreeSpace, PlanGrid, clearance
from sim_stubs.homes.geometry.solids import Piece

GOAL = "yellow chair"
"""Label of the goal of a rehearsal."""
YELLOW = (0.95, 0.86, 0.05)
DECOYS = {name: COLOURS[name] for name in ("red", "blue", "green", "purple")}
"""Colours of decoys, none of which looks yellow."""

CHAIR_HEIGHT = 1.1
"""Height from which furniture hangs above any chair [m]."""
DOOR_AREA = 1.0
"""Least distance of a chair from the middle of a doorway [m]."""
FIRST_DISTANCE = 3.0
"""Least distance of a start from every instance of the goal [m] (the benchmark's rule)."""
ROOMS = ("living room", "kitchen", "bedroom", "kid's room", "study")
"""Rooms in which a chair may stand."""
DRAWS = 60
"""Most starts tried; a good one comes after a few."""


def with_goal(
    house: House,
    space: FreeSpace,
    chair: Piece,
    doorways: Sequence[tuple[float, float]],
    entered: Sequence[Room],
    rng: np.random.Generator,
) -> tuple[House, FreeSpace] | None:
    """The house with a start, a yellow chair in another room out of sight, a decoy in a third.

    The robot can get from the start into every room, and within 1 m of both chairs.

    Args:
        house: The furnished house.
        space: Free space of the house.
        chair: Model of both chairs.
        doorways: x, y of the middles of the doorways [m].
        entered: Rooms that the robot must be able to enter.
        rng: Source of all draws.

    Returns:
        The house and its free space with the chairs; None when there is no place for them, or
        a path is blocked.
    """
    furnished = replace(space, clear=_from_furniture(house, space.grid))
    colour = list(DECOYS)[rng.integers(len(DECOYS))]
    goal = painted_plain(chair, GOAL, YELLOW)
    decoy = painted_plain(chair, f"{colour} chair", DECOYS[colour])
    rooms = [room for room in house.rooms if room.name in ROOMS]
    starts = [room for room in house.rooms if room.name not in ("bathroom", "laundry room")]
    for _ in range(DRAWS):
        start_room = starts[rng.integers(len(starts))]
        start = _start(start_room, rng)
        if space.clearance(start[0], start[1]) < PASSAGE + 0.05:
            continue
        others = [room for room in rooms if room is not start_room]
        if len(others) < 2:
            continue
        goal_room, decoy_room = (others[i] for i in rng.permutation(len(others))[:2])
        goal_at = next(_against_walls(goal, goal_room, furnished, doorways, rng), None)
        decoy_at = next(_against_walls(decoy, decoy_room, furnished, doorways, rng), None)
        if goal_at is None or decoy_at is None:
            continue
        if hypot(goal_at.x - start[0], goal_at.y - start[1]) < FIRST_DISTANCE + 0.5:
            continue
        if _sees(space, start[0], start[1], goal_at):
            continue
        chairs = (goal_at, decoy_at)
        with_chairs = space.with_pieces(chairs)
        if is_passable(with_chairs, start, entered, chairs):
            return replace(house, instances=(*house.instances, *chairs), start=start), with_chairs
    return None


def is_passable(
    space: FreeSpace,
    start: tuple[float, float, float],
    rooms: Sequence[Room],
    chairs: Sequence[Instance],
) -> bool:
    """Whether the robot gets from `start` into every room and near each chair within its room."""
    reached = space.reached(start[0], start[1])
    for room in rooms:
        rows, columns = np.nonzero(reached & space.inside(room))
        xy = space.grid.pixels_to_xy(np.column_stack([columns, rows]))
        if len(xy) == 0:
            return False
        for chair in chairs:
            distances = np.linalg.norm(xy - (chair.x, chair.y), axis=1)
            if room.contains(chair.x, chair.y) and distances.min() > 1.0:
                return False
    return True


def _start(room: Room, rng: np.random.Generator) -> tuple[float, float, float]:
    """Any x, y [m], yaw [rad] in a room."""
    x, y = rng.uniform(room.polygon.min(axis=0), room.polygon.max(axis=0))
    return float(x), float(y), float(rng.uniform(-pi, pi))


def _against_walls(
    chair: Piece,
    room: Room,
    furnished: FreeSpace,
    doorways: Sequence[tuple[float, float]],
    rng: np.random.Generator,
) -> Iterator[Instance]:
    """Free places for a chair with its back to a wall, a little askew."""
    radius = float(np.hypot(chair.size[0], chair.size[1])) / 2
    for _ in range(60):
        way = list(FACING)[rng.integers(4)]
        yaw = FACING[way] + float(rng.uniform(-0.3, 0.3))
        x, y = rng.uniform(room.polygon.min(axis=0), room.polygon.max(axis=0))
        gap = radius + 0.03
        (x0, y0), (x1, y1) = room.polygon.min(axis=0) + gap, room.polygon.max(axis=0) - gap
        x = {"E": x0, "W": x1}.get(way, float(x))
        y = {"N": y0, "S": y1}.get(way, float(y))
        inside = x0 <= x <= x1 and y0 <= y <= y1
        to_door = min(hypot(x - door_x, y - door_y) for door_x, door_y in doorways)
        if inside and to_door > DOOR_AREA and furnished.clearance(x, y) > radius + 0.02:
            yield Instance(f"{chair.label}#1", chair, float(x), float(y), yaw)


def _sees(space: FreeSpace, x: float, y: float, instance: Instance) -> bool:
    """Whether the instance may be in sight of the camera while the robot turns at x, y.

    Only walls hide things here, so that this errs on the safe side.
    """
    turn = np.linspace(0, 2 * pi, 8, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    radius = float(np.hypot(instance.piece.size[0], instance.piece.size[1])) / 2 + 0.05
    along = np.linspace(0, 1, 1000)[:, None]
    for eye in np.array([x, y]) + 0.08 * ring:
        for target in np.array([instance.x, instance.y]) + radius * ring:
            column, row = np.round(space.grid.to_pixels(eye + along * (target - eye))).T
            if not space.structure[row.astype(int), column.astype(int)].any():
                return True
    return False


def _from_furniture(house: House, grid: PlanGrid) -> NDArray[np.float32]:
    """(rows, cols) distance to the rectangles around what stands below the height of a chair."""
    covered = np.zeros(grid.shape, np.uint8)
    for instance in house.instances:
        if instance.elevation < CHAIR_HEIGHT:
            corners = np.round(grid.to_pixels(instance.footprint) * 16).astype(np.int32)
            cv2.fillConvexPoly(covered, corners, 1, shift=4)
    return clearance(covered > 0, grid)
