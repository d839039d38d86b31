"""What the rehearsal looks for: a yellow chair out of the robot's sight, and a decoy elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import hypot, pi

import numpy as np
from numpy.typing import NDArray

from sim_stubs import shapes
from sim_stubs.furnishing import FACING
from sim_stubs.house import House, Instance, Room
from sim_stubs.occupancy_slice import PlanGrid, clearance, grid_around, occupied, reachable
from sim_stubs.piece import Piece
from sim_stubs.solids import triangles
from vizbot.core.errors import ConfigError

YELLOW = (0.95, 0.86, 0.05)
DECOYS = {
    "red": (0.80, 0.08, 0.08),
    "blue": (0.08, 0.20, 0.75),
    "green": (0.05, 0.50, 0.15),
    "purple": (0.45, 0.10, 0.60),
}
"""Saturated colours that no one takes for yellow."""

ROBOT_HEIGHT = 0.65
"""With its mast [m]."""
PASSAGE = 0.25
"""Half the width of every way that must stay free [m]; the robot's own is 0.175."""
DOOR_AREA = 1.0
"""Chairs stand at least this far from the middle of a doorway [m]."""
FIRST_DISTANCE = 3.0
"""The goal is farther than this from the start [m]."""
DRAWS = 500
"""Starts tried; a good one comes after a few."""


def with_goal(
    house: House, chair: Piece, doorways: Sequence[tuple[float, float]], rng: np.random.Generator
) -> House:
    """The house with a start, a yellow chair in another room out of sight, a decoy in a third.

    The robot can get from the start into every room, and within 1 m of both chairs.

    Args:
        house: Furnished.
        chair: Model of both chairs.
        doorways: x, y of the middles of the open doorways [m].
        rng: Draws everything.

    Raises:
        ConfigError: the furniture leaves no free way.
    """
    plan = _Plan.of(house)
    colour = list(DECOYS)[rng.integers(len(DECOYS))]
    goal = shapes.recoloured(chair, "yellow chair", YELLOW)
    decoy = shapes.recoloured(chair, f"{colour} chair", DECOYS[colour])
    rooms = [room for room in house.rooms if room.name not in ("hallway", "bathroom")]
    starts = [room for room in house.rooms if room.name != "bathroom"]
    for _ in range(DRAWS):
        start_room = starts[rng.integers(len(starts))]
        start = _start(start_room, rng)
        if plan.clearance(start[0], start[1]) < PASSAGE + 0.05:
            continue
        others = [room for room in rooms if room is not start_room]
        goal_room, decoy_room = (others[i] for i in rng.permutation(len(others))[:2])
        goal_at = next(_against_walls(goal, goal_room, plan, doorways, rng), None)
        decoy_at = next(_against_walls(decoy, decoy_room, plan, doorways, rng), None)
        if goal_at is None or decoy_at is None:
            continue
        if hypot(goal_at.x - start[0], goal_at.y - start[1]) < FIRST_DISTANCE:
            continue
        if plan.sees(start[0], start[1], goal_at):
            continue
        chairs = (goal_at, decoy_at)
        if plan.is_passable(start[0], start[1], chairs, house.rooms):
            return replace(house, instances=(*house.instances, *chairs), start=start)
    raise ConfigError("the furniture leaves no free way through the flat; use smaller models")


def _start(room: Room, rng: np.random.Generator) -> tuple[float, float, float]:
    """Any x, y [m], yaw [rad] in a room."""
    x, y = rng.uniform(room.polygon.min(axis=0), room.polygon.max(axis=0))
    return float(x), float(y), float(rng.uniform(-pi, pi))


def _against_walls(
    chair: Piece,
    room: Room,
    plan: _Plan,
    doorways: Sequence[tuple[float, float]],
    rng: np.random.Generator,
) -> Iterator[Instance]:
    """Free places for a chair with its back to a wall, a little askew."""
    radius = float(np.hypot(chair.size[0], chair.size[1])) / 2
    for _ in range(40):
        way = list(FACING)[rng.integers(4)]
        yaw = FACING[way] + float(rng.uniform(-0.3, 0.3))
        x, y = rng.uniform(room.polygon.min(axis=0), room.polygon.max(axis=0))
        gap = radius + 0.03
        (x0, y0), (x1, y1) = room.polygon.min(axis=0) + gap, room.polygon.max(axis=0) - gap
        x = {"E": x0, "W": x1}.get(way, float(x))
        y = {"N": y0, "S": y1}.get(way, float(y))
        inside = x0 <= x <= x1 and y0 <= y <= y1
        to_door = min(hypot(x - door_x, y - door_y) for door_x, door_y in doorways)
        if inside and to_door > DOOR_AREA and plan.from_furniture(x, y) > radius + 0.02:
            yield Instance(f"{chair.label}#1", chair, x, y, yaw)


@dataclass(frozen=True, slots=True, eq=False)
class _Plan:
    """The true plan of a furnished house, before the chairs.

    Attributes:
        grid: Of the images.
        obstacles: (rows, cols) what the robot cannot drive through.
        walls: (rows, cols) what hides a thing of any height.
        clear: (rows, cols) distance to the obstacles [m].
        clear_of_furniture: (rows, cols) distance to furniture of any height alone [m].
    """

    grid: PlanGrid
    obstacles: NDArray[np.bool_]
    walls: NDArray[np.bool_]
    clear: NDArray[np.float32]
    clear_of_furniture: NDArray[np.float32]

    @staticmethod
    def of(house: House) -> _Plan:
        structure = triangles(house.structure)
        furniture = triangles([part for it in house.instances for part in it.parts()])
        grid = grid_around(structure, 0.02)
        walls = occupied(structure, 0.02, ROBOT_HEIGHT, grid)
        pieces = occupied(furniture, 0.02, 1.0, grid)
        return _Plan(
            grid=grid,
            obstacles=walls | occupied(furniture, 0.02, ROBOT_HEIGHT, grid),
            walls=walls,
            clear=clearance(walls | pieces, grid),
            clear_of_furniture=clearance(pieces, grid),
        )

    def clearance(self, x: float, y: float) -> float:
        """From anything [m]; 0 outside."""
        cell = self.grid.cell_of(x, y)
        return 0.0 if cell is None else float(self.clear[cell])

    def from_furniture(self, x: float, y: float) -> float:
        """From furniture [m]; 0 outside."""
        cell = self.grid.cell_of(x, y)
        return 0.0 if cell is None else float(self.clear_of_furniture[cell])

    def sees(self, x: float, y: float, instance: Instance) -> bool:
        """Whether a ray on the plan, from where turning takes the camera, meets no wall.

        Furniture hides nothing here, so that this errs on the safe side.
        """
        turn = np.linspace(0, 2 * pi, 8, endpoint=False)
        ring = np.column_stack([np.cos(turn), np.sin(turn)])
        radius = float(np.hypot(instance.piece.size[0], instance.piece.size[1])) / 2 + 0.05
        along = np.linspace(0, 1, 1000)[:, None]
        for eye in np.array([x, y]) + 0.08 * ring:
            for target in np.array([instance.x, instance.y]) + radius * ring:
                column, row = np.round(self.grid.to_cells(eye + along * (target - eye))).T
                if not self.walls[row.astype(int), column.astype(int)].any():
                    return True
        return False

    def is_passable(
        self, x: float, y: float, chairs: Sequence[Instance], rooms: Sequence[Room]
    ) -> bool:
        """Whether the robot gets from x, y into every room and near each chair within its room."""
        standing = triangles([part for chair in chairs for part in chair.parts()])
        blocked = self.obstacles | occupied(standing, 0.02, ROBOT_HEIGHT, self.grid)
        start = self.grid.cell_of(x, y)
        assert start is not None
        rows, columns = np.nonzero(reachable(clearance(blocked, self.grid) > PASSAGE, start))
        xy = self.grid.to_xy(np.column_stack([columns, rows]))
        for room in rooms:
            low, high = room.polygon.min(axis=0), room.polygon.max(axis=0)
            inside = xy[((xy > low) & (xy < high)).all(axis=1)]
            if len(inside) == 0:
                return False
            for chair in chairs:
                if room.contains(chair.x, chair.y):
                    distances = np.linalg.norm(inside - (chair.x, chair.y), axis=1)
                    if distances.min() > 1.0:
                        return False
        return True
