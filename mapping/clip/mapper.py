"""The CLIP map: features of image patches at several scales, each at a 3D point (paper, III-A)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import GrowingTable
from mapping.clip.mapped_frames import MappedFrame
from mapping.keyframes.anchors import points_in_map
from vizbot.core.geometry import transform
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class FrameElements:
    """The elements that one frame adds to the CLIP map.

    Attributes:
        points_cam: (M, 3) float64, mean of each patch's back-projected points in `cam` [m].
        embeddings: (M, D) float32, unit rows.
        boxes: (M, 4) int32, u0, v0, u1, v1 of each patch [px], the end not included.
    """

    points_cam: NDArray[np.float64]
    embeddings: NDArray[np.float32]
    boxes: NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class ClipElements:
    """Elements of a CLIP map, one a row.

    Attributes:
        embeddings: (N, D) float32, unit rows.
        points_keyframe: (N, 3) float64, in the camera of the element's keyframe [m].
        keyframes: (N,) int32, ids.
        frames: (N,) int32, number of the frame the patch was cut from.
        boxes: (N, 4) int32, u0, v0, u1, v1 of the patch in that frame [px].
    """

    embeddings: NDArray[np.float32]
    points_keyframe: NDArray[np.float64]
    keyframes: NDArray[np.int32]
    frames: NDArray[np.int32]
    boxes: NDArray[np.int32]


class ClipMap:
    """All elements so far (paper, equation 5), each anchored to a keyframe.

    Few frames are keyframes. The elements of a frame are stored in the camera of the keyframe that
    the frame is anchored to, so that the map moves with the pose graph.
    """

    def __init__(self, dimension: int, saved: ClipElements | None = None) -> None:
        """Start empty, for embeddings of length `dimension`, or with a saved map's elements."""
        self._table = GrowingTable(_no_rows(dimension) if saved is None else saved)

    def __len__(self) -> int:
        return len(self._table)

    def add(self, frame: MappedFrame, elements: FrameElements) -> None:
        """Add the elements of a frame, anchored to its keyframe."""
        count = len(elements.points_cam)
        self._table.add(
            ClipElements(
                elements.embeddings,
                transform(frame.T_keyframe_cam, elements.points_cam),
                np.full(count, frame.keyframe, np.int32),
                np.full(count, frame.number, np.int32),
                elements.boxes,
            )
        )

    def add_rows(self, elements: ClipElements) -> None:
        """Add elements that are anchored already."""
        self._table.add(elements)

    @property
    def elements(self) -> ClipElements:
        """All rows, as views that later additions do not change."""
        return self._table.rows

    @property
    def embeddings(self) -> NDArray[np.float32]:
        """(N, D) float32, unit rows."""
        return self.elements.embeddings

    @property
    def keyframes(self) -> NDArray[np.int32]:
        """(N,) ids of the keyframes the elements are anchored to."""
        return self.elements.keyframes

    @property
    def points_keyframe(self) -> NDArray[np.float64]:
        """(N, 3) points in the cameras of those keyframes [m]."""
        return self.elements.points_keyframe

    def points_map(self, keyframe_poses: Mapping[int, SE3]) -> NDArray[np.float64]:
        """(N, 3) points in `map` [m] by the newest T_map_cam of the keyframes (equation 3)."""
        return points_in_map(self.points_keyframe, self.keyframes, keyframe_poses)


def _no_rows(dimension: int) -> ClipElements:
    return ClipElements(
        np.empty((0, dimension), np.float32),
        np.empty((0, 3)),
        np.empty(0, np.int32),
        np.empty(0, np.int32),
        np.empty((0, 4), np.int32),
    )
