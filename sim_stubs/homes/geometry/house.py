"""A furnished home: rooms, structure, and pieces of furniture in their places.

World frame: z up, floor at z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.mirror import Mirror
from sim_stubs.homes.geometry.solids import Part, Piece, moved_part
from vizbot.core.geometry import planar
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class Instance:
    """A piece of furniture in its place.

    Attributes:
        name: Unique in the house ("chair#2").
        piece: The model.
        x: Position of the piece's origin [m].
        y: Position of the piece's origin [m].
        yaw: Yaw of the piece; at 0 its front faces -y [rad].
        elevation: Height of its underside [m].
        on: Name of the instance it stands on; empty on the floor, at a wall or ceiling.
    """

    name: str
    piece: Piece
    x: float
    y: float
    yaw: float
    elevation: float = 0.0
    on: str = ""

    @property
    def label(self) -> str:
        """The class it is an instance of."""
        return self.piece.label

    @property
    def T_world_piece(self) -> SE3:
        """Pose of the piece."""
        T = planar(self.x, self.y, self.yaw)
        T[2, 3] = self.elevation
        return T

    @property
    def centre(self) -> NDArray[np.float64]:
        """(3,) middle of its bounding box [m]."""
        return np.array([self.x, self.y, self.elevation + self.piece.size[2] / 2])

    @property
    def footprint(self) -> NDArray[np.float64]:
        """(4, 2) corners of its bounding rectangle on the plan [m], counter-clockwise."""
        w, d = self.piece.size[:2] / 2
        corners = np.array([[-w, -d], [w, -d], [w, d], [-w, d]])
        T = self.T_world_piece
        return np.asarray(corners @ T[:2, :2].T + T[:2, 3])

    def parts(self) -> tuple[Part, ...]:
        """Meshes of the piece in the world frame."""
        return tuple(moved_part(part, self.T_world_piece) for part in self.piece.parts)


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """A room with its name and floor, for scoring and captions.

    Attributes:
        name: "kitchen", "hallway", ...; not unique.
        polygon: (N, 2) float64 corners of its floor on the plan [m], counter-clockwise.
    """

    name: str
    polygon: NDArray[np.float64]

    def contains(self, x: float, y: float) -> bool:
        """Whether a point on the plan lies in the room."""
        return cv2.pointPolygonTest(self.polygon.astype(np.float32), (x, y), False) >= 0


@dataclass(frozen=True, slots=True, eq=False)
class House:
    """A house: everything that a world consists of.

    Attributes:
        rooms: Rooms with their names.
        structure: Walls, floors, ceilings, windows and doors, in the world frame.
        instances: Furniture in its place.
        lights: (N, 3) lamps at the ceiling [m]; the renderer takes seven at most.
        start: x, y [m] and yaw [rad] of the robot.
        mirror: The one mirror that mirrors; None in most houses, where mirrors are plain surfaces.
    """

    rooms: tuple[Room, ...]
    structure: tuple[Part, ...]
    instances: tuple[Instance, ...]
    lights: NDArray[np.float64]
    start: tuple[float, float, float]
    mirror: Mirror | None = None

    def parts(self) -> tuple[Part, ...]:
        """Structure and furniture as meshes in the world."""
        furniture = [part for instance in self.instances for part in instance.parts()]
        return (*self.structure, *furniture)

    def room_at(self, x: float, y: float) -> Room | None:
        """The room around a point on the plan; None in a wall, a doorway or outside."""
        return next((room for room in self.rooms if room.contains(x, y)), None)
