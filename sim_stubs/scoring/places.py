"""Which places of the plan truly show a goal, to fit and examine what a robot believes."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.footprint import PLACE
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.occupancy_slice import PlanGrid, occupied
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.start_pose import things_named

_MARGIN = 4
"""Places around the house that are on the plan, too."""
_PARTS = 5
"""Cells along the edge of a place by which its share is measured."""
_LEAST_SHARE = 0.03
"""Share of a place that a thing covers at least, to be there."""
_EVERY_HEIGHT = (-100.0, 100.0)


def true_places(house: House, text: str) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Where a goal is on the plan.

    A thing is at the places that it covers a part of, and at those beside them, since measured
    points scatter. A room is where most of a place lies on its floor.

    Args:
        house: The house.
        text: The goal in words.

    Returns:
        (rows, cols) whether the goal is at each place, and the column and row (2,) of the first
        one, counted in places from the origin of the world.
    """
    corners = triangles(house.structure)[..., :2].reshape(-1, 2)
    low = np.floor(corners.min(axis=0) / PLACE).astype(np.int64) - _MARGIN
    columns, rows = (np.ceil(corners.max(axis=0) / PLACE).astype(np.int64) + _MARGIN - low).tolist()
    fine = PlanGrid(low * PLACE, PLACE / _PARTS, (rows * _PARTS, columns * _PARTS))
    things, rooms = things_named(house, text)
    covered = np.zeros(fine.shape, np.uint8)
    for room in rooms:
        outline = np.round(fine.to_pixels(room.polygon) * 16).astype(np.int32)
        cv2.fillPoly(covered, [outline], 1, shift=4)
    if not rooms:
        for thing in things:
            covered |= occupied(triangles(thing.parts()), *_EVERY_HEIGHT, fine).astype(np.uint8)
    shares = covered.reshape(rows, _PARTS, columns, _PARTS).mean(axis=(1, 3))
    if rooms:
        return shares > 0.5, low
    there = (shares > _LEAST_SHARE).astype(np.uint8)
    beside = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    return cv2.dilate(there, beside).astype(np.bool_), low


def are_true(
    places: NDArray[np.int64], there: NDArray[np.bool_], low: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Whether the goal is at places (N, 2) column, row; `there` and `low` as of `true_places`."""
    column, row = (places - low).T
    inside = (column >= 0) & (row >= 0) & (row < there.shape[0]) & (column < there.shape[1])
    return np.asarray(inside & there[np.where(inside, row, 0), np.where(inside, column, 0)])
