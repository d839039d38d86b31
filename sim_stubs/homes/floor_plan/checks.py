"""Checks of a floor plan: every room can be reached, and a place is far from every window."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.floor_plan.room_rectangle import Rectangle
from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.floor_plan.walls import Opening
from vizbot.core.distance import distance_to_zero

CELL = 0.05
"""Edge of a cell of the plan [m]."""


def all_reached(
    rooms: Sequence[Rectangle],
    openings: Sequence[Opening],
    stairs: Stairs | None,
    clearance: float = 0.25,
) -> bool:
    """Whether a disc gets from the first room into every other one.

    Args:
        rooms: Rooms by their inner faces.
        openings: Openings, of which windows and the outer door are closed.
        stairs: Stairs, which block their place.
        clearance: Radius of the disc [m].
    """
    low = np.min([(room.x0, room.y0) for room in rooms], axis=0) - 0.5
    high = np.max([(room.x1, room.y1) for room in rooms], axis=0) + 0.5
    columns, rows = np.ceil((high - low) / CELL).astype(int)

    def cells(x0: float, y0: float, x1: float, y1: float) -> tuple[slice, slice]:
        (a, b), (c, d) = (
            np.round((np.array(corner) - low) / CELL).astype(int) for corner in ((x0, y0), (x1, y1))
        )
        return slice(int(b), int(d)), slice(int(a), int(c))

    free = np.zeros((rows, columns), np.uint8)
    for room in rooms:
        free[cells(room.x0, room.y0, room.x1, room.y1)] = 1
    for opening in openings:
        if opening.kind == "doorway":
            free[cells(opening.x0, opening.y0, opening.x1, opening.y1)] = 1
    if stairs is not None:
        free[cells(*stairs.bounds)] = 0
    wide = distance_to_zero(free) * CELL > clearance
    _, labels = cv2.connectedComponents(wide.astype(np.uint8), connectivity=4)
    first = labels[cells(rooms[0].x0, rooms[0].y0, rooms[0].x1, rooms[0].y1)]
    home = int(np.bincount(first[first > 0], minlength=1).argmax())
    for room in rooms:
        if room.name == "stairs":
            continue
        inside = labels[cells(room.x0, room.y0, room.x1, room.y1)]
        if home == 0 or (inside == home).mean() < 0.3:
            return False
    return True


def free_spots(rooms: Sequence[Rectangle], stairs: Stairs | None) -> NDArray[np.float64]:
    """Points (N, 2) every 0.1 m that are 0.3 m or more from walls and stairs [m]."""
    spots = []
    for room in rooms:
        x, y = np.meshgrid(
            np.arange(room.x0 + 0.3, room.x1 - 0.29, 0.1),
            np.arange(room.y0 + 0.3, room.y1 - 0.29, 0.1),
        )
        spots.append(np.column_stack([x.ravel(), y.ravel()]))
    points = np.concatenate(spots)
    if stairs is None:
        return points
    x0, y0, x1, y1 = stairs.bounds
    return points[away_from(points, x0, y0, x1, y1) > 0.3]


def away_from(
    points: NDArray[np.float64], x0: float, y0: float, x1: float, y1: float
) -> NDArray[np.float64]:
    """Distance (N,) of points (N, 2) on the plan to an upright rectangle [m]."""
    nearest = np.clip(points, (x0, y0), (x1, y1))
    return np.asarray(np.linalg.norm(points - nearest, axis=1))
