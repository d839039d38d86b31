"""Where the elements of a growing CLIP map are, worked out again only where something changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapping.clip.mapper import ClipElements
from mapping.keyframes.anchors import points_in_map, poses_in_map
from vizbot.core.types import SE3, PoseEstimate


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
        """Begin without elements."""
        self._size = 0
        self._rows = _rows(0)
        self._blocks: list[_Block] = []
        self._poses: dict[int, SE3] = {}

    def place(
        self,
        elements: ClipElements,
        estimates: Sequence[PoseEstimate],
        keyframe_poses: Mapping[int, SE3],
    ) -> PlacedElements:
        """Where the elements are now.

        Args:
            elements: Those of the previous call, with others behind them.
            estimates: Of all frames of the map; `elements.frames` are indices of it.
            keyframe_poses: T_map_cam of every keyframe.

        Raises:
            KeyError: a keyframe that is referred to has no pose.
        """
        moved = self._moved(keyframe_poses)
        known, size = len(self._blocks), len(elements.keyframes)
        self._blocks += _blocks(elements, self._size)
        again = (
            [block for block in self._blocks[:known] if block.keyframe in moved] if moved else []
        )
        self._make_room(size, copy=bool(again))
        self._size = size
        for blocks in (again, self._blocks[known:]):
            self._compute(blocks, elements, estimates, keyframe_poses)
        rows = self._rows
        return PlacedElements(rows.points[:size], rows.seen_from[:size])

    def _moved(self, keyframe_poses: Mapping[int, SE3]) -> set[int]:
        """Keyframes with elements whose pose has changed since the last call."""
        moved = set()
        for keyframe, T_before in self._poses.items():
            T_now = keyframe_poses[keyframe]
            if T_now is not T_before and not np.array_equal(T_now, T_before):
                moved.add(keyframe)
        return moved

    def _make_room(self, size: int, *, copy: bool) -> None:
        """Have rows for `size` elements; `copy` where given ones would change."""
        capacity = len(self._rows.points)
        if size > capacity:
            capacity, copy = max(size, 2 * capacity, 256), True
        if copy:
            rows = _rows(capacity)
            for field in fields(PlacedElements):
                getattr(rows, field.name)[: self._size] = getattr(self._rows, field.name)[
                    : self._size
                ]
            self._rows = rows

    def _compute(
        self,
        blocks: Sequence[_Block],
        elements: ClipElements,
        estimates: Sequence[PoseEstimate],
        keyframe_poses: Mapping[int, SE3],
    ) -> None:
        if not blocks:
            return
        self._poses |= {block.keyframe: keyframe_poses[block.keyframe] for block in blocks}
        rows = np.concatenate([np.arange(block.start, block.end) for block in blocks])
        self._rows.points[rows] = points_in_map(
            elements.points_keyframe[rows], elements.keyframes[rows], keyframe_poses
        )
        cameras = poses_in_map(
            np.array([estimates[block.frame].T_keyframe_cam for block in blocks]),
            np.array([block.keyframe for block in blocks], np.int32),
            keyframe_poses,
        )
        counts = [block.end - block.start for block in blocks]
        self._rows.seen_from[rows] = np.repeat(cameras[:, :2, 3], counts, axis=0)


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


def _rows(count: int) -> PlacedElements:
    return PlacedElements(np.empty((count, 3)), np.empty((count, 2)))
