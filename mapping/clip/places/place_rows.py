"""Views of places, as they grow with a CLIP map and move with its poses.

A frame counts once for each spot and heading of the camera: a robot that waits, or turns to and
fro, learns nothing new from the same view.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import GrowingRows
from mapping.clip.places.footprint import PLACE, Footprint
from mapping.keyframes.anchors import points_in_map
from vizbot.core.geometry import transform
from vizbot.core.types import SE3

SPOT = 0.5
"""Edge of a spot, a cell of the plan on which the camera stands [m]."""
HEADINGS = 12
"""Headings of the camera on a spot that count as different views."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaceRows:
    """Views of places, one a row, in the order in which they were taken.

    Attributes:
        points_keyframe: (R, 3) float32, mean point of what shows the place, in the camera of the
            row's keyframe [m].
        keyframes: (R,) int32, ids.
        elements: (R, 3) int32, rows of the map's elements: the finest patch that shows the place,
            and the middle and the coarsest one around it.
        ranges: (R,) float32, distance of the place from the camera on the plan [m].
        shares: (R,) float32, share of the finest patch that shows the place.
        spots: (R,) int32, number of the spot on which the camera stood.
    """

    points_keyframe: NDArray[np.float32]
    keyframes: NDArray[np.int32]
    elements: NDArray[np.int32]
    ranges: NDArray[np.float32]
    shares: NDArray[np.float32]
    spots: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.keyframes)


@dataclass(frozen=True, slots=True, eq=False)
class PlacedRows:
    """Where views of places are by the present poses of the keyframes.

    Attributes:
        places: (R, 2) column, row of the place of each row, counted from the origin of the map.
        heights: (R,) float32, of the mean points above the floor [m].
        cameras_xy: (R, 2) float32, where the camera stood, in `map` [m].
        moved: How often rows have moved to other places because keyframes moved.
    """

    places: NDArray[np.int64]
    heights: NDArray[np.float32]
    cameras_xy: NDArray[np.float32]
    moved: int


class PlaceMap:
    """The views of places of a CLIP map."""

    def __init__(self, saved: PlaceRows | None = None) -> None:
        """Start empty, or with the views of a saved map.

        For its views the camera is taken to have stood where that of the keyframe did.
        """
        self._moved = 0
        first = _no_rows() if saved is None else saved
        self._columns = [GrowingRows(getattr(first, field.name)) for field in fields(PlaceRows)]
        self._cameras_keyframe = GrowingRows(np.zeros((len(first), 3), np.float32))
        self._cameras_xy = GrowingRows(np.zeros((0, 2), np.float32))
        self._places = GrowingRows(np.zeros((0, 2), np.int64))
        self._heights = GrowingRows(np.zeros(0, np.float32))
        self._poses: dict[int, SE3] = {}
        self._spots: dict[tuple[int, int], int] = {}
        self._views: set[tuple[int, int]] = set()
        self._first_spot = int(first.spots.max(initial=-1)) + 1

    def __len__(self) -> int:
        return len(self._cameras_keyframe)

    @property
    def rows(self) -> PlaceRows:
        """All rows, as views that later additions do not change."""
        return PlaceRows(*(column.rows for column in self._columns))

    def is_new_view(self, T_map_cam: SE3) -> bool:
        """Whether a picture from here is the first from this spot with this heading."""
        return self._view(T_map_cam) not in self._views

    def add(
        self,
        keyframe: int,
        T_keyframe_cam: SE3,
        T_map_cam: SE3,
        footprint: Footprint,
        first_element: int,
    ) -> None:
        """Add the places that a frame shows; a frame that shows none does not count as a view.

        `T_keyframe_cam` is the frame's camera in that of `keyframe`, `T_map_cam` where it is now;
        `first_element` is the row of the frame's first element in the CLIP map.
        """
        if len(footprint.shares) == 0:  # depth may be back in the next picture from here
            return
        view = self._view(T_map_cam)
        self._views.add(view)
        count = len(footprint.shares)
        offsets = transform(T_map_cam, footprint.points_cam)[:, :2] - T_map_cam[:2, 3]
        points, keyframes, elements, ranges, shares, spots = self._columns
        points.add(transform(T_keyframe_cam, footprint.points_cam))
        keyframes.add_same(keyframe, count)
        elements.add(footprint.patches.astype(np.int32) + first_element)
        ranges.add(np.linalg.norm(offsets, axis=1))
        shares.add(footprint.shares)
        spots.add_same(view[0], count)
        self._cameras_keyframe.add_same(T_keyframe_cam[:3, 3].astype(np.float32), count)

    def placed(self, keyframe_poses: Mapping[int, SE3]) -> PlacedRows:
        """Where the rows are now, by T_map_cam of every keyframe."""
        rows, known = self.rows, len(self._places)
        again = [
            keyframe
            for keyframe, T_before in self._poses.items()
            if (T_now := keyframe_poses[keyframe]) is not T_before
            and not np.array_equal(T_now, T_before)
        ]
        if again:
            moved = np.flatnonzero(np.isin(rows.keyframes[:known], again))
            cells, heights = _located(rows, moved, keyframe_poses)
            if not np.array_equal(cells, self._places.rows[moved]):
                self._moved += 1
                self._places = self._places.with_changed(moved, cells)
            self._heights = self._heights.with_changed(moved, heights)
            cameras_xy = self._cameras(moved, keyframe_poses)
            self._cameras_xy = self._cameras_xy.with_changed(moved, cameras_xy)
        fresh = np.arange(known, len(rows))
        cells, heights = _located(rows, fresh, keyframe_poses)
        self._places.add(cells)
        self._heights.add(heights)
        self._cameras_xy.add(self._cameras(fresh, keyframe_poses))
        ids = np.unique(rows.keyframes[fresh]).tolist() + again
        self._poses |= {keyframe: keyframe_poses[keyframe] for keyframe in ids}
        return PlacedRows(self._places.rows, self._heights.rows, self._cameras_xy.rows, self._moved)

    def _cameras(
        self, chosen: NDArray[np.int64], keyframe_poses: Mapping[int, SE3]
    ) -> NDArray[np.float32]:
        """Where the camera of each of the chosen rows (M,) stood (M, 2), in `map` [m]."""
        cameras, keyframes = self._cameras_keyframe.rows[chosen], self.rows.keyframes[chosen]
        return points_in_map(cameras, keyframes, keyframe_poses)[:, :2].astype(np.float32)

    def _view(self, T_map_cam: SE3) -> tuple[int, int]:
        """Spot and heading of a picture."""
        column, row = np.floor(T_map_cam[:2, 3] / SPOT).astype(int).tolist()
        number = self._first_spot + len(self._spots)
        heading = np.arctan2(T_map_cam[1, 2], T_map_cam[0, 2])
        turn = round(float(heading) / (2 * np.pi / HEADINGS)) % HEADINGS
        return self._spots.setdefault((column, row), number), turn


def _located(
    rows: PlaceRows, chosen: NDArray[np.int64], keyframe_poses: Mapping[int, SE3]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """The place (M, 2) column, row and the height (M,) [m] of each of the chosen rows (M,)."""
    points = points_in_map(rows.points_keyframe[chosen], rows.keyframes[chosen], keyframe_poses)
    return np.floor(points[:, :2] / PLACE).astype(np.int64), points[:, 2].astype(np.float32)


def _no_rows() -> PlaceRows:
    return PlaceRows(
        np.empty((0, 3), np.float32),
        np.empty(0, np.int32),
        np.empty((0, 3), np.int32),
        np.empty(0, np.float32),
        np.empty(0, np.float32),
        np.empty(0, np.int32),
    )
