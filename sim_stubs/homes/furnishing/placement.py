"""Placement of furniture in one room, without overlaps and with every path free.

A room is furnished piece by piece. Each piece is tried in places that make sense for it and stands
where it fits: inside the room, clear of other pieces, of doorways and windows, and so that the
robot still gets from every doorway to every other one and to the front of pieces that are used from
it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

import cv2
import numpy as np

from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom, before_opening, wall_of
from sim_stubs.homes.geometry.bounding_block import FACING, Block, at_wall, centred, wall_span
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.occupancy_slice import DRIVEN_OVER, PASSAGE, ROBOT_HEIGHT
from sim_stubs.homes.geometry.solids import Piece
from vizbot.core.distance import distance_to_zero

GAP = 0.03
"""Gap between a wall with its skirting and a piece at it [m]."""
DOOR_DEPTH = 0.9
"""Depth of the floor that stays free in front of a doorway [m]."""
CELL = 0.05
"""Edge of a cell for the check of paths [m]."""
TRIES = 60
"""Most places tried for a piece."""


class RoomLayout:
    """One room as it is being furnished."""

    def __init__(
        self,
        room: RectangularRoom,
        openings: Sequence[Opening],
        stairs: Stairs | None,
        rng: np.random.Generator,
        count: Counter[str],
    ) -> None:
        """An empty room; `count`, of the instances of each label in the home, is updated."""
        self.room = Block(room.x0, room.y0, room.x1, room.y1)
        self.windows: list[tuple[Opening, str]] = []
        self.instances: list[Instance] = []
        self.rng, self._count = rng, count
        self._solid: list[Block] = []
        self._kept: list[Block] = []
        self._reached: list[Block] = []
        if stairs is not None and Block(*stairs.bounds).overlaps(self.room):
            self._solid.append(Block(*stairs.bounds))
            self._keep(Block(*stairs.approach))
        for opening in openings:
            facing = wall_of(opening, self.room)
            if facing is not None:
                self._cut(opening, facing)

    def row(
        self,
        pieces: Sequence[Piece],
        *,
        front: float = 0.0,
        elevation: float = 0.0,
        facings: str = "NESW",
        spot: str = "any",
    ) -> tuple[Instance, ...] | None:
        """Pieces side by side with their backs to a wall; None where no wall takes them.

        Args:
            pieces: Pieces from left to right, seen from the front.
            front: Depth of the floor in front that is kept free and reachable [m].
            elevation: Height of their undersides [m].
            facings: Directions that they may face.
            spot: Part of the wall: "any", "middle", or "corner".
        """
        width = sum(float(piece.size[0]) for piece in pieces)
        for facing, along in self._spots(width, facings, spot):
            rightwards = 1.0 if facing in "SE" else -1.0
            at, blocks = along - rightwards * width / 2, []
            for piece in pieces:
                half = rightwards * float(piece.size[0]) / 2
                blocks.append(at_wall(self.room, facing, at + half, piece.size, GAP, elevation))
                at += 2 * half
            if self.fits(blocks, facing, front):
                return tuple(
                    self.put(piece, block, facing, front)
                    for piece, block in zip(pieces, blocks, strict=True)
                )
        return None

    def against_wall(
        self,
        piece: Piece,
        *,
        front: float = 0.0,
        elevation: float = 0.0,
        facings: str = "NESW",
        spot: str = "any",
    ) -> Instance | None:
        """One piece with its back to a wall; see `row`."""
        placed = self.row([piece], front=front, elevation=elevation, facings=facings, spot=spot)
        return placed[0] if placed else None

    def at_wall(
        self, piece: Piece, facing: str, along: float, elevation: float = 0.0
    ) -> Instance | None:
        """A piece at that wall, its middle at x or y `along` [m]."""
        block = at_wall(self.room, facing, along, piece.size, GAP, elevation)
        return self.put(piece, block, facing) if self.fits([block], facing, 0.0) else None

    def in_the_open(self, piece: Piece, margin: float) -> Instance | None:
        """A piece anywhere with `margin` [m] of floor all around."""
        for _ in range(TRIES):
            facing = "NESW"[self.rng.integers(4)]
            x, y = self.rng.uniform((self.room.x0, self.room.y0), (self.room.x1, self.room.y1))
            block = centred(float(x), float(y), piece.size, facing)
            around = replace(block.grown(margin), z0=DRIVEN_OVER)
            if self.free([around], kept=False) and self.fits([block], facing, 0.0):
                return self.put(piece, block, facing)
        return None

    def under_ceiling(self, piece: Piece, height: float) -> Instance | None:
        """A piece that hangs from the ceiling, near the middle of the room."""
        for k in range(10):
            x, y = np.array(self.room.centre) + self.rng.uniform(-0.1, 0.1, 2) * k
            block = centred(float(x), float(y), piece.size, "S")
            block = replace(block, z0=height - float(piece.size[2]) - 0.002, z1=height)
            if self.free([block]):
                return self.put(piece, block, "S")
        return None

    def on_floor(self, piece: Piece) -> Instance | None:
        """A flat piece on free floor."""
        for _ in range(TRIES):
            facing = "NESW"[self.rng.integers(4)]
            x, y = self.rng.uniform((self.room.x0, self.room.y0), (self.room.x1, self.room.y1))
            block = centred(float(x), float(y), piece.size, facing)
            if self.free([block.grown(0.04)]):
                return self.put(piece, block, facing)
        return None

    def passable(self, blocks: Iterable[Block] = ()) -> bool:
        """Whether all paths are free with `blocks` in the room."""
        room = self.room
        shape = np.ceil(np.array([room.y1 - room.y0, room.x1 - room.x0]) / CELL).astype(int)
        image = np.ones(shape + 2, np.uint8)
        image[[0, -1]], image[:, [0, -1]] = 0, 0
        for block in (*self._solid, *blocks):
            if block.z0 < ROBOT_HEIGHT and block.z1 > DRIVEN_OVER:
                image[self._cells(block)] = 0
        wide = distance_to_zero(image) * CELL
        _, regions = cv2.connectedComponents((wide > PASSAGE + 0.03).astype(np.uint8))
        common: set[int] | None = None
        for zone in self._reached:
            here = {int(region) for region in np.unique(regions[self._cells(zone)])} - {0}
            common = here if common is None else common & here
        return common is None or bool(common)

    def _cells(self, block: Block) -> tuple[slice, slice]:
        """Rows and columns that a block touches, in an image with a border of one cell."""
        x, y = self.room.x0, self.room.y0
        low = np.floor(np.array([block.y0 - y, block.x0 - x]) / CELL + 1e-6).astype(int) + 1
        high = np.ceil(np.array([block.y1 - y, block.x1 - x]) / CELL - 1e-6).astype(int) + 1
        low, high = low.clip(1), high.clip(1)
        return slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))

    def _spots(self, width: float, facings: str, spot: str) -> list[tuple[str, float]]:
        """Walls and places along them for something `width` [m] long, best first."""
        found = []
        for facing in facings:
            start, end = wall_span(self.room, facing)
            low, high = start + width / 2 + GAP, end - width / 2 - GAP
            if high < low:
                continue
            for along in np.linspace(low, high, max(2, int((high - low) / 0.08))):
                from_corner = min(along - low, high - along)
                from_middle = abs(along - (low + high) / 2)
                rank = {"any": 0.0, "corner": from_corner, "middle": from_middle}[spot]
                found.append((rank + self.rng.random() * 0.8, facing, float(along)))
        return [(facing, along) for _, facing, along in sorted(found)][:TRIES]

    def fits(self, blocks: list[Block], facing: str, front: float, *, kept: bool = True) -> bool:
        """Whether pieces can stand in these blocks.

        Args:
            blocks: One for each.
            facing: Direction that they face.
            front: Depth of the floor in front that is to be free and reachable [m].
            kept: Whether they stay off the floor that is kept free for others.
        """
        zones = [block.ahead(facing, front) for block in blocks] if front else []
        if not all(block.inside(self.room) for block in blocks):
            return False
        if not self.free(blocks, kept=kept):
            return False
        # The floor in front must be free of furniture; it may be another piece's front too.
        zones = [replace(zone, z0=DRIVEN_OVER, z1=ROBOT_HEIGHT) for zone in zones]
        if not self.free(zones, kept=False):
            return False
        if all(block.z0 >= ROBOT_HEIGHT or block.z1 <= DRIVEN_OVER for block in blocks):
            return True
        self._reached += zones
        passable = self.passable(blocks)
        del self._reached[len(self._reached) - len(zones) :]
        return passable

    def free(self, blocks: Sequence[Block], *, kept: bool = True) -> bool:
        """Whether these blocks are free; with `kept`, also of floor that is kept free."""
        others = [*self._solid, *self._kept] if kept else self._solid
        return all(block.inside(self.room) for block in blocks) and not any(
            block.overlaps(other) for block in blocks for other in others
        )

    def put(
        self, piece: Piece, block: Block, facing: str, front: float = 0.0, on: str = ""
    ) -> Instance:
        """Place a piece in a block; see `fits`. `on` is the name of the instance it stands on."""
        self._count[piece.label] += 1
        name = f"{piece.label}#{self._count[piece.label]}"
        instance = Instance(name, piece, *block.centre, FACING[facing], block.z0, on)
        self.instances.append(instance)
        self._solid.append(Block.around(instance))
        if front:
            self._keep(block.ahead(facing, front))
        return instance

    def _keep(self, floor: Block) -> None:
        """Keep a part of the floor free and reachable."""
        zone = replace(floor, z0=DRIVEN_OVER, z1=ROBOT_HEIGHT)
        self._kept.append(zone)
        self._reached.append(zone)

    def _cut(self, opening: Opening, facing: str) -> None:
        """Keep an opening free."""
        hole = Block(opening.x0, opening.y0, opening.x1, opening.y1)
        if opening.kind == "window":
            self.windows.append((opening, facing))
            frame = before_opening(hole, self.room, facing, 0.15)
            self._solid.append(replace(frame, z0=opening.sill - 0.06, z1=opening.head + 0.06))
            return
        floor = before_opening(hole, self.room, facing, DOOR_DEPTH)
        self._kept.append(replace(floor.grown(0.06), z0=DRIVEN_OVER, z1=opening.head + 0.1))
        self._reached.append(before_opening(hole, self.room, facing, 0.5))
