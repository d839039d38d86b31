"""The frames that a CLIP map has taken in: where they were taken, and when."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.anchors import poses_in_map
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class MappedFrame:
    """One frame.

    Attributes:
        number: Of the frame, counted over all runs of the map.
        keyframe: Id of the keyframe that it is anchored to.
        T_keyframe_cam: Its camera in that of the keyframe.
        time: When it was taken, UTC [s since 1970]; it never falls from frame to frame.
    """

    number: int
    keyframe: int
    T_keyframe_cam: SE3
    time: float

    def row(self) -> MappedFrames:
        """The table of this frame alone."""
        return MappedFrames(
            np.array([self.number], np.int32),
            np.array([self.keyframe], np.int32),
            self.T_keyframe_cam[None],
            np.array([self.time]),
        )


@dataclass(frozen=True, slots=True, eq=False)
class MappedFrames:
    """Frames, one a row, in the order in which they were taken.

    Attributes:
        numbers: (F,) int32, rising.
        keyframes: (F,) int32, ids.
        Ts_keyframe_cam: (F, 4, 4) float64.
        times: (F,) float64, UTC [s since 1970], not falling.
    """

    numbers: NDArray[np.int32]
    keyframes: NDArray[np.int32]
    Ts_keyframe_cam: NDArray[np.float64]
    times: NDArray[np.float64]

    @classmethod
    def empty(cls) -> MappedFrames:
        """No frames."""
        no_ids = np.zeros(0, np.int32)
        return cls(no_ids, no_ids, np.zeros((0, 4, 4)), np.zeros(0))

    def __len__(self) -> int:
        return len(self.numbers)

    def rows_of(self, numbers: NDArray[np.int32]) -> NDArray[np.intp]:
        """The rows (N,) of frames of the table, by their numbers (N,)."""
        return np.searchsorted(self.numbers, numbers)

    def Ts_map_cam(self, keyframe_poses: Mapping[int, SE3]) -> NDArray[np.float64]:
        """Where the frames were taken (F, 4, 4), by T_map_cam of every keyframe."""
        return poses_in_map(self.Ts_keyframe_cam, self.keyframes, keyframe_poses)
