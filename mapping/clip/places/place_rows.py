"""Views of places, as they grow with a CLIP map and move with its poses.

A picture counts for each spot and heading of the camera: a robot that waits, or turns to and fro,
learns nothing new from the same view. Taken again later, it stands for the picture before. And
what a place showed long ago is in doubt once later pictures from near have looked there twice: what
stood there may have gone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import GrowingRows, GrowingTable
from mapping.clip.mapped_frames import MappedFrame, MappedFrames
from mapping.clip.places.footprint import PLACE, Footprint
from mapping.clip.places.view_age import LATER, ViewAge, age_of_views, view_of
from mapping.keyframes.anchors import points_in_map
from vizbot.core.geometry import transform
from vizbot.core.types import SE3, Intrinsics


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
        frames: (R,) int32, numbers of the frames.
    """

    points_keyframe: NDArray[np.float32]
    keyframes: NDArray[np.int32]
    elements: NDArray[np.int32]
    ranges: NDArray[np.float32]
    shares: NDArray[np.float32]
    spots: NDArray[np.int32]
    frames: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.keyframes)

    @classmethod
    def empty(cls) -> PlaceRows:
        """No views."""
        no_ids, nothing = np.zeros(0, np.int32), np.zeros(0, np.float32)
        points = np.zeros((0, 3), np.float32)
        return cls(points, no_ids, np.zeros((0, 3), np.int32), nothing, nothing, no_ids, no_ids)


@dataclass(frozen=True, slots=True, eq=False)
class PlacedRows:
    """Where views of places are by the present poses of the keyframes.

    Attributes:
        places: (R, 2) column, row of the place of each row, counted from the origin of the map.
        heights: (R,) float32, of the mean points above the floor [m].
        cameras_xy: (R, 2) float32, where the camera stood, in `map` [m].
        age: How new they are.
    """

    places: NDArray[np.int64]
    heights: NDArray[np.float32]
    cameras_xy: NDArray[np.float32]
    age: ViewAge


class PlaceMap:
    """The frames of a CLIP map, and the views of places that they give."""

    def __init__(
        self,
        intrinsics: Intrinsics,
        saved: PlaceRows | None = None,
        frames: MappedFrames | None = None,
    ) -> None:
        """Start empty, or with the views and the frames of a saved map, all by this camera."""
        self._intrinsics = intrinsics
        self._rows = GrowingTable(PlaceRows.empty() if saved is None else saved)
        self._frames = GrowingTable(MappedFrames.empty() if frames is None else frames)
        self._points = GrowingRows(np.zeros((0, 3), np.float32))
        self._poses: dict[int, SE3] = {}
        self._frames_placed = 0
        self._placed: PlacedRows | None = None
        self._taken: dict[tuple[int, int, int], float] = {}
        self._spots: dict[tuple[int, int], int] = {}
        self._first_spot = int(self.rows.spots.max(initial=-1)) + 1

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def rows(self) -> PlaceRows:
        """All rows, as views that later additions do not change."""
        return self._rows.rows

    @property
    def frames(self) -> MappedFrames:
        """All frames, likewise."""
        return self._frames.rows

    def retaken_frames(self, keyframe_poses: Mapping[int, SE3]) -> NDArray[np.int32]:
        """Numbers (M,) of frames that were taken again later, by T_map_cam of every keyframe."""
        return np.unique(self.rows.frames[self.placed(keyframe_poses).age.retaken])

    def compacted(self, rows: PlaceRows, frames: MappedFrames) -> PlaceMap:
        """This map with fewer rows and frames; new pictures have the views that they have here."""
        compact = PlaceMap(self._intrinsics, rows, frames)
        compact._taken, compact._spots = self._taken, self._spots
        compact._first_spot = self._first_spot
        return compact

    def add_rows(self, rows: PlaceRows, frames: MappedFrames) -> None:
        """Add rows and frames whose views are known."""
        self._rows.add(rows)
        self._frames.add(frames)

    def is_new_view(self, T_map_cam: SE3, time: float) -> bool:
        """Whether a picture from here is the first from this spot with this heading for long.

        `time` is when it is taken, as of `MappedFrame`. Every view of a saved map is to be taken
        again.
        """
        return time - self._taken.get(view_of(T_map_cam), -np.inf) >= LATER

    def add(
        self, frame: MappedFrame, T_map_cam: SE3, footprint: Footprint, first_element: int
    ) -> None:
        """Add a frame and the places that it shows; one that shows none does not count as a view.

        `T_map_cam` is where the frame was taken by the poses of then; `first_element` is the row of
        its first element in the CLIP map.
        """
        self._frames.add(frame.row())
        count = len(footprint.shares)
        if count == 0:  # depth may be back in the next picture from here
            return
        column, row, _ = view = view_of(T_map_cam)
        self._taken[view] = frame.time
        spot = self._spots.setdefault((column, row), self._first_spot + len(self._spots))
        offsets = transform(T_map_cam, footprint.points_cam)[:, :2] - T_map_cam[:2, 3]
        self._rows.add(
            PlaceRows(
                transform(frame.T_keyframe_cam, footprint.points_cam).astype(np.float32),
                np.full(count, frame.keyframe, np.int32),
                footprint.patches.astype(np.int32) + np.int32(first_element),
                np.linalg.norm(offsets, axis=1).astype(np.float32),
                footprint.shares,
                np.full(count, spot, np.int32),
                np.full(count, frame.number, np.int32),
            )
        )

    def placed(self, keyframe_poses: Mapping[int, SE3]) -> PlacedRows:
        """Where the rows are now, by T_map_cam of every keyframe."""
        rows, known = self.rows, len(self._points)
        again = [
            keyframe
            for keyframe, T_before in self._poses.items()
            if (T_now := keyframe_poses[keyframe]) is not T_before
            and not np.array_equal(T_now, T_before)
        ]
        if self._placed is not None and not again and self._frames_placed == len(self._frames):
            return self._placed
        moved = np.flatnonzero(np.isin(rows.keyframes[:known], again)) if again else None
        if moved is not None:
            points = _points(rows, moved, keyframe_poses)
            self._points = self._points.with_changed(moved, points)
        self._points.add(_points(rows, np.arange(known, len(rows)), keyframe_poses))
        frames = self.frames
        ids = np.unique(frames.keyframes).tolist()
        self._poses = {keyframe: keyframe_poses[keyframe] for keyframe in ids}
        self._frames_placed = len(frames)
        Ts_map_cam = frames.Ts_map_cam(keyframe_poses)
        frame_of = frames.rows_of(rows.frames)
        places = np.floor(self._points.rows[:, :2] / PLACE).astype(np.int64)
        age = age_of_views(
            places,
            self._points.rows,
            rows.ranges,
            frame_of,
            Ts_map_cam,
            frames.times,
            self._intrinsics,
        )
        self._placed = PlacedRows(
            places,
            np.ascontiguousarray(self._points.rows[:, 2]),
            Ts_map_cam[frame_of, :2, 3].astype(np.float32),
            age,
        )
        return self._placed


def _points(
    rows: PlaceRows, chosen: NDArray[np.int64], keyframe_poses: Mapping[int, SE3]
) -> NDArray[np.float32]:
    """The mean point (M, 3) of each of the chosen rows (M,), in `map` [m]."""
    points, keyframes = rows.points_keyframe[chosen], rows.keyframes[chosen]
    return points_in_map(points, keyframes, keyframe_poses).astype(np.float32)


def places_of(rows: PlaceRows, keyframe_poses: Mapping[int, SE3]) -> NDArray[np.int64]:
    """The place (R, 2) column, row of each row, by T_map_cam of every keyframe."""
    points = points_in_map(rows.points_keyframe, rows.keyframes, keyframe_poses)
    return np.floor(points[:, :2] / PLACE).astype(np.int64)
