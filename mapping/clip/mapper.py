"""The CLIP map: features of image patches at several scales, each at a 3D point (paper, III-A)."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.config import ClipMapperConfig
from mapping.keyframes.anchors import points_in_map
from vizbot.core.geometry import transform
from vizbot.core.types import SE3, Intrinsics, RGBDFrame

if TYPE_CHECKING:  # the protocol's module loads torch
    from mapping.clip.encoder import ClipEncoder

logger = logging.getLogger(__name__)


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
        frames: (N,) int32, index of the frame the patch was cut from.
        boxes: (N, 4) int32, u0, v0, u1, v1 of the patch in that frame [px].
    """

    embeddings: NDArray[np.float32]
    points_keyframe: NDArray[np.float64]
    keyframes: NDArray[np.int32]
    frames: NDArray[np.int32]
    boxes: NDArray[np.int32]


@lru_cache(maxsize=16)
def patch_boxes(width: int, height: int, config: ClipMapperConfig) -> NDArray[np.int32]:
    """Split an image into floor(w / s_i) x floor(h / s_i) patches, centred, for every scale.

    Returns:
        (P, 4) int32, read-only: u0, v0, u1, v1 [px], the end not included; scale by scale, row by
        row. A scale whose patches do not fit has none, which is logged once.
    """
    boxes = []
    for size in config.patch_sizes():
        cols, rows = width // size, height // size
        if cols * rows == 0:
            logger.warning(
                "%dx%d images have no patches of %d px: that scale is left out", width, height, size
            )
        u0, v0 = (width - cols * size) // 2, (height - rows * size) // 2
        for row in range(rows):
            for col in range(cols):
                u, v = u0 + col * size, v0 + row * size
                boxes.append((u, v, u + size, v + size))
    grid = np.array(boxes, np.int32).reshape(-1, 4)
    grid.flags.writeable = False
    return grid


def patch_points(
    depth: NDArray[np.float32], intrinsics: Intrinsics, boxes: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean of the back-projected points of each patch (paper, equations 2 and 4).

    Pixels without depth are ignored. The sums over a patch are separable, so they are matrix
    products of the depth image with the patches' rows and columns, and no cloud is built.

    Args:
        depth: (H, W) [m], 0 where nothing was measured.
        intrinsics: Of the depth image.
        boxes: (P, 4) as of `patch_boxes`.

    Returns:
        Points (P, 3) in `cam` [m] (meaningless where nothing was measured), and the share (P,) of
        each patch's pixels that have depth.
    """
    u, v = np.arange(intrinsics.width), np.arange(intrinsics.height)
    spans_u, of_u = np.unique(boxes[:, 0::2], axis=0, return_inverse=True)
    spans_v, of_v = np.unique(boxes[:, 1::2], axis=0, return_inverse=True)
    in_cols = ((spans_u[:, :1] <= u) & (u < spans_u[:, 1:])).astype(np.float64)
    in_rows = ((spans_v[:, :1] <= v) & (v < spans_v[:, 1:])).astype(np.float64)
    x_cols = in_cols * ((u - intrinsics.cx) / intrinsics.fx)
    y_rows = in_rows * ((v - intrinsics.cy) / intrinsics.fy)

    z = depth.astype(np.float64)
    valid = in_rows @ (depth > 0).astype(np.float64) @ in_cols.T
    row_sums = in_rows @ z
    sums = np.stack([row_sums @ x_cols.T, (y_rows @ z) @ in_cols.T, row_sums @ in_cols.T], axis=-1)

    pixels, sums = valid[of_v, of_u], sums[of_v, of_u]
    area = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
    return sums / np.maximum(pixels, 1.0)[:, None], pixels / area


def embed_frame(frame: RGBDFrame, encoder: ClipEncoder, config: ClipMapperConfig) -> FrameElements:
    """Features and points of a frame's patches (paper, equations 1, 2 and 4), in one batch."""
    boxes = patch_boxes(frame.intrinsics.width, frame.intrinsics.height, config)
    points, depth_part = patch_points(frame.depth, frame.intrinsics, boxes)
    kept = depth_part >= config.least_depth
    boxes = boxes[kept]
    embeddings = encoder.embed_images([frame.rgb[v0:v1, u0:u1] for u0, v0, u1, v1 in boxes])
    return FrameElements(points[kept], embeddings, boxes)


class ClipMap:
    """All elements so far (paper, equation 5), each anchored to a keyframe.

    Few frames are keyframes. The elements of a frame are stored in the camera of the keyframe that
    the frame is anchored to, so that the map moves with the pose graph.
    """

    def __init__(self, dimension: int, saved: ClipElements | None = None) -> None:
        """Start empty, for embeddings of length `dimension`, or with a saved map's elements."""
        self._size = 0 if saved is None else len(saved.keyframes)
        self._rows = _rows(0, dimension) if saved is None else saved

    def __len__(self) -> int:
        return self._size

    def add(
        self, keyframe: int, T_keyframe_cam: SE3, elements: FrameElements, frame_index: int
    ) -> None:
        """Add a frame's elements.

        Args:
            keyframe: Id of the keyframe the frame is anchored to.
            T_keyframe_cam: The frame's camera in that keyframe's camera.
            elements: Of the frame.
            frame_index: Of the frame in the run.
        """
        start, end = self._size, self._size + len(elements.points_cam)
        if end > len(self._rows.keyframes):
            self._grow(max(end, 2 * len(self._rows.keyframes), 256))
        self._rows.embeddings[start:end] = elements.embeddings
        self._rows.points_keyframe[start:end] = transform(T_keyframe_cam, elements.points_cam)
        self._rows.keyframes[start:end] = keyframe
        self._rows.frames[start:end] = frame_index
        self._rows.boxes[start:end] = elements.boxes
        self._size = end

    @property
    def elements(self) -> ClipElements:
        """All rows, as views that later additions do not change."""
        size = self._size
        rows = self._rows
        return ClipElements(
            rows.embeddings[:size],
            rows.points_keyframe[:size],
            rows.keyframes[:size],
            rows.frames[:size],
            rows.boxes[:size],
        )

    @property
    def embeddings(self) -> NDArray[np.float32]:
        """(N, D) float32, unit rows."""
        return self._rows.embeddings[: self._size]

    @property
    def keyframes(self) -> NDArray[np.int32]:
        """(N,) ids of the keyframes the elements are anchored to."""
        return self._rows.keyframes[: self._size]

    @property
    def points_keyframe(self) -> NDArray[np.float64]:
        """(N, 3) points in the cameras of those keyframes [m]."""
        return self._rows.points_keyframe[: self._size]

    def points_map(self, keyframe_poses: Mapping[int, SE3]) -> NDArray[np.float64]:
        """(N, 3) points in `map` [m] by the newest T_map_cam of the keyframes (equation 3)."""
        return points_in_map(self.points_keyframe, self.keyframes, keyframe_poses)

    def _grow(self, capacity: int) -> None:
        grown = _rows(capacity, self._rows.embeddings.shape[1])
        for field in fields(ClipElements):
            getattr(grown, field.name)[: self._size] = getattr(self._rows, field.name)[: self._size]
        self._rows = grown


def _rows(count: int, dimension: int) -> ClipElements:
    return ClipElements(
        np.empty((count, dimension), np.float32),
        np.empty((count, 3)),
        np.empty(count, np.int32),
        np.empty(count, np.int32),
        np.empty((count, 4), np.int32),
    )
