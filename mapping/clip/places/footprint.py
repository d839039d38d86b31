"""Footprints: which places of the plan a frame's patches show, by the depth of their pixels.

A patch that shows a chair before a wall has a mean point between the two, where nothing is. Its
pixels say better what it shows: each row of a footprint is a place of the plan, with the patch of
the finest scale that shows most of it, and the coarser ones around that. Of more than three scales
the coarsest three count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vizbot.core.camera_limits import FARTHEST_DEPTH
from vizbot.core.geometry import back_project, transform
from vizbot.core.types import SE3, Intrinsics

PLACE = 0.25
"""Edge of a place, a cell of the plan [m]."""
_STRIDE = 4
"""Every n-th pixel of every n-th row is used, and this is n."""
_LEAST_SHARE = 0.08
"""Least share of its patch that a place must take."""


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """What a frame's patches show, one place a row.

    Attributes:
        points_cam: (R, 3) float32, mean point of the pixels that show the place, in `cam` [m].
        patches: (R, 3) int16, indices of the frame's elements: the finest patch that shows most of
            the place, and the patch of the middle and of the coarsest scale nearest to it.
        shares: (R,) float32, share of the finest patch's pixels that show the place.
    """

    points_cam: NDArray[np.float32]
    patches: NDArray[np.int16]
    shares: NDArray[np.float32]

    @staticmethod
    def nothing() -> Footprint:
        """No places."""
        return Footprint(
            np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int16), np.zeros(0, np.float32)
        )


def footprint(
    depth: NDArray[np.float32], intrinsics: Intrinsics, T_map_cam: SE3, boxes: NDArray[np.int32]
) -> Footprint:
    """The footprint of a frame.

    Args:
        depth: (H, W) [m], 0 where nothing was measured.
        intrinsics: Of the depth image.
        T_map_cam: Where the camera was; places are cells of the map.
        boxes: (M, 4) of the frame's elements: u0, v0, u1, v1 [px], the end not included.
    """
    if len(boxes) == 0:
        return Footprint.nothing()
    widths, (width, _, _) = boxes[:, 2] - boxes[:, 0], _scales(boxes)
    points_cam = back_project(depth, intrinsics)[::_STRIDE, ::_STRIDE]
    measured = (points_cam[..., 2] > 0) & (points_cam[..., 2] <= FARTHEST_DEPTH)
    cells = np.floor(transform(T_map_cam, points_cam.reshape(-1, 3))[:, :2] / PLACE).astype(
        np.int64
    )
    finest = np.flatnonzero(widths == width)
    of_pixel = np.full(measured.shape, -1, np.int64)
    for i in finest:
        u0, v0, u1, v1 = -(-boxes[i] // _STRIDE)
        of_pixel[v0:v1, u0:u1] = i
    shown = np.flatnonzero(measured.ravel() & (of_pixel.ravel() >= 0))
    if len(shown) == 0:
        return Footprint.nothing()
    cells, patch = cells[shown], of_pixel.ravel()[shown]
    low = cells.min(axis=0)
    span = cells.max(axis=0) - low + 1
    place = (cells[:, 1] - low[1]) * span[0] + cells[:, 0] - low[0]
    _, first, row_of, pixels = np.unique(
        place * len(boxes) + patch, return_index=True, return_inverse=True, return_counts=True
    )
    area = (width / _STRIDE) ** 2
    kept = _most_shown(place[first], pixels, _LEAST_SHARE * area)
    of_rows = points_cam.reshape(-1, 3)[shown]
    sums = np.stack([np.bincount(row_of, of_rows[:, axis]) for axis in range(3)], axis=1)
    return Footprint(
        (sums[kept] / pixels[kept, None]).astype(np.float32),
        _around(boxes, finest)[patch[first[kept]]],
        np.minimum(pixels[kept] / area, 1.0).astype(np.float32),
    )


def _most_shown(
    place: NDArray[np.int64], pixels: NDArray[np.int64], least: float
) -> NDArray[np.int64]:
    """Indices of the rows to keep: of each place the one with most pixels, if that has enough."""
    order = np.lexsort((-pixels, place))
    order = order[np.diff(place[order], prepend=-1) != 0]
    return np.asarray(order[pixels[order] >= least])


def _scales(boxes: NDArray[np.int32]) -> tuple[int, int, int]:
    """Widths of the finest, middle and coarsest patches (M, 4) that count, M at least one [px].

    With fewer than three scales a scale stands in for its neighbour.
    """
    widths = np.unique(boxes[:, 2] - boxes[:, 0])[-3:].tolist()
    return widths[0], widths[len(widths) // 2], widths[-1]


def _around(boxes: NDArray[np.int32], finest: NDArray[np.int64]) -> NDArray[np.int16]:
    """For each element (M, 3): itself, the middle and the coarsest patch whose centre is nearest.

    Rows of elements that are no finest patch mean nothing.
    """
    centres = (boxes[:, :2] + boxes[:, 2:]) / 2.0
    widths, (_, middle, coarsest) = boxes[:, 2] - boxes[:, 0], _scales(boxes)
    around = np.tile(np.arange(len(boxes), dtype=np.int16)[:, None], (1, 3))
    for column, width in ((1, middle), (2, coarsest)):
        coarser = np.flatnonzero(widths == width)
        away = np.linalg.norm(centres[finest, None] - centres[coarser], axis=2)
        around[finest, column] = coarser[np.argmin(away, axis=1)]
    return around
