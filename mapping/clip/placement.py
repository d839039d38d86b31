"""Where the elements of a growing CLIP map are, worked out again only where something changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import GrowingRows
from mapping.clip.mapped_frames import MappedFrames
from mapping.clip.mapper import ClipElements
from mapping.keyframes.anchors import points_in_map, poses_in_map
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class PlacedElements:
    """The elements in `map`, one a row; the arrays do not change when the map does.

    Attributes:
        points: (N, 3) float64 in `map` [m].
        seen_from: (N, 2) float64 x, y where the camera saw them from, in `map` [m].
    """

    points: NDArray[np.float64]
    seen_from: NDArray[np.float64]


class _Block(NamedTuple):
    """Rows start to end of the elements of one frame."""

    start: int
    end: int
    keyframe: int
    frame: int


class Placement:
    """Places elements by the newest poses of their keyframes.

    A row is computed when it is new, and again when its keyframe has moved. A step that adds a
    frame to a map of a million elements costs what it costs in an empty one.
    """

    def __init__(self) -> None:
        self._points = GrowingRows(np.zeros((0, 3)))
        self._seen_from = GrowingRows(np.zeros((0, 2)))
        self._blocks: list[_Block] = []
        self._poses: dict[int, SE3] = {}

    def place(
        self,
        elements: ClipElements,
        frames: MappedFrames,
        keyframe_poses: Mapping[int, SE3],
    ) -> PlacedElements:
        """Where the elements are now.

        Args:
            elements: Those of the previous call, with others behind them.
            frames: Those that the elements were cut from.
            keyframe_poses: T_map_cam of every keyframe.

        Raises:
            KeyError: a keyframe that is referred to has no pose.
        """
        moved = self._moved(keyframe_poses)
        again = [block for block in self._blocks if block.keyframe in moved] if moved else []
        if again:
            rows, points, seen_from = _placed(again, elements, frames, keyframe_poses)
            self._points = self._points.with_changed(rows, points)
            self._seen_from = self._seen_from.with_changed(rows, seen_from)
        fresh = _blocks(elements, len(self._points))
        if fresh:
            _, points, seen_from = _placed(fresh, elements, frames, keyframe_poses)
            self._points.add(points)
            self._seen_from.add(seen_from)
        self._blocks += fresh
        self._poses |= {block.keyframe: keyframe_poses[block.keyframe] for block in again + fresh}
        return PlacedElements(self._points.rows, self._seen_from.rows)

    def _moved(self, keyframe_poses: Mapping[int, SE3]) -> set[int]:
        """Keyframes with elements whose pose has changed since the last call."""
        moved = set()
        for keyframe, T_before in self._poses.items():
            T_now = keyframe_poses[keyframe]
            if T_now is not T_before and not np.array_equal(T_now, T_before):
                moved.add(keyframe)
        return moved


def _placed(
    blocks: Sequence[_Block],
    elements: ClipElements,
    frames: MappedFrames,
    keyframe_poses: Mapping[int, SE3],
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """The rows (M,) of some blocks, their points (M, 3) and where they were seen from (M, 2)."""
    rows = np.concatenate([np.arange(block.start, block.end) for block in blocks])
    points = points_in_map(elements.points_keyframe[rows], elements.keyframes[rows], keyframe_poses)
    cameras = poses_in_map(
        frames.Ts_keyframe_cam[frames.rows_of(np.array([block.frame for block in blocks]))],
        np.array([block.keyframe for block in blocks], np.int32),
        keyframe_poses,
    )
    counts = [block.end - block.start for block in blocks]
    return rows, points, np.repeat(cameras[:, :2, 3], counts, axis=0)


def _blocks(elements: ClipElements, start: int) -> list[_Block]:
    """The frames whose elements begin at row `start` or behind it."""
    frames, keyframes = elements.frames[start:], elements.keyframes[start:]
    if len(frames) == 0:
        return []
    cuts = np.flatnonzero((np.diff(frames) != 0) | (np.diff(keyframes) != 0)) + 1
    starts = np.concatenate([[0], cuts])
    ends = np.concatenate([cuts, [len(frames)]])
    return [
        _Block(start + first, start + end, int(keyframes[first]), int(frames[first]))
        for first, end in zip(starts.tolist(), ends.tolist(), strict=True)
    ]
