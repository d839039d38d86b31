"""Corners with upright binary descriptors and depth.

Corners are Shi and Tomasi's, refined below a pixel; descriptors are ORB's, taken upright because
a robot's camera does not roll.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.odometry.config import FeatureConfig
from vizbot.core.program.kernels import kernel
from vizbot.core.types import RGBDFrame


@dataclass(frozen=True, slots=True, eq=False)
class Features:
    """Corners of one image.

    Attributes:
        pixels: (N, 2) float64 column, row [px].
        descriptors: (N, 4) uint64, 256 bits each.
        points: (N, 3) float64 in `cam` [m]; (0, 0, 0) without depth.
    """

    pixels: NDArray[np.float64]
    descriptors: NDArray[np.uint64]
    points: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.pixels)


NO_FEATURES = Features(np.zeros((0, 2)), np.zeros((0, 4), np.uint64), np.zeros((0, 3)))
"""The features of an image without corners."""


def detect(frame: RGBDFrame, config: FeatureConfig) -> Features:
    """Corners of a frame, spread over the image; none where there is nothing to see."""
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
    corners = strongest_corners(grey, config)
    if len(corners) == 0:
        return NO_FEATURES
    # Corners are strong relative to the image's strongest: in the dark that is noise.
    contrast = cv2.morphologyEx(cv2.blur(grey, (3, 3)), cv2.MORPH_GRADIENT, np.ones((7, 7)))
    columns, rows = corners.astype(np.intp).T
    corners = corners[contrast[rows, columns] >= config.contrast]
    if len(corners) == 0:
        return NO_FEATURES
    stop = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 5, 0.03)
    columns, rows = cv2.cornerSubPix(grey, corners, (3, 3), (-1, -1), stop).T.tolist()
    keypoints = [cv2.KeyPoint(u, v, 31.0, 0.0) for u, v in zip(columns, rows, strict=True)]
    orb = cv2.ORB.create(config.count, nlevels=1, edgeThreshold=16)
    keypoints, descriptors = orb.compute(grey, keypoints)
    if len(keypoints) == 0:
        return NO_FEATURES
    pixels = np.asarray(cv2.KeyPoint.convert(keypoints), np.float64)
    depths = depth_at(frame.depth, pixels, config.depth_spread, config.max_depth)
    camera = frame.intrinsics
    rays = np.column_stack(
        (
            (pixels[:, 0] - camera.cx) / camera.fx,
            (pixels[:, 1] - camera.cy) / camera.fy,
            np.ones(len(pixels)),
        )
    )
    return Features(
        pixels, np.ascontiguousarray(descriptors).view(np.uint64), rays * depths[:, None]
    )


def strongest_corners(grey: NDArray[np.uint8], config: FeatureConfig) -> NDArray[np.float32]:
    """Column, row (N, 2) [px] of corners (Shi and Tomasi 1994), the strongest first.

    They are those of `cv2.goodFeaturesToTrack`, which takes twice as long: it sorts pointers.
    """
    strength = cv2.cornerMinEigenVal(grey, 3)
    least = np.float32(float(strength.max()) * config.quality)
    maxima = (strength == cv2.dilate(strength, None)) & (strength > least)
    maxima[[0, -1]] = maxima[:, [0, -1]] = False
    pixels = np.flatnonzero(maxima)
    # Sorted as whole numbers: bits of positive floats are in the order of their values.
    ascending = np.sort(strength.ravel()[pixels].view(np.int32).astype(np.int64) << 32 | pixels)
    corners = np.empty((config.count, 2), np.float32)
    return corners[: _apart(ascending, strength.shape, config.spacing, corners)]


@kernel("i8(i8[::1], UniTuple(i8, 2), f8, f4[:,::1])")
def _apart(
    ascending: NDArray[np.int64],
    shape: tuple[int, int],
    spacing: float,
    corners: NDArray[np.float32],
) -> int:
    """Write corners (N, 2), the last key first, none nearer than `spacing` to one before it.

    Returns how many they are, at most as many as there is room for.
    """
    rows, columns = shape
    edge = max(int(np.rint(spacing)), 1)
    # A cell of this edge holds a few corners: each chain leads through those of one cell.
    first = np.full((rows // edge + 1, columns // edge + 1), -1)
    following = np.empty(len(corners), np.int64)
    count = 0
    for k in range(len(ascending) - 1, -1, -1):
        if count == len(corners):
            break
        pixel = ascending[k] & 0xFFFFFFFF
        row, column = pixel // columns, pixel % columns
        cell_row, cell_column = row // edge, column // edge
        apart = True
        for r in range(max(cell_row - 1, 0), min(cell_row + 2, first.shape[0])):
            for c in range(max(cell_column - 1, 0), min(cell_column + 2, first.shape[1])):
                other = first[r, c]
                while other >= 0 and apart:
                    dx, dy = column - corners[other, 0], row - corners[other, 1]
                    apart = dx * dx + dy * dy >= spacing * spacing
                    other = following[other]
        if apart:
            corners[count, 0], corners[count, 1] = column, row
            following[count] = first[cell_row, cell_column]
            first[cell_row, cell_column] = count
            count += 1
    return count


def depth_at(
    depth: NDArray[np.float32], pixels: NDArray[np.float64], spread: float, max_depth: float
) -> NDArray[np.float64]:
    """Depth (N,) [m] at pixels (N, 2): the median of the 3 x 3 around, 0 where it is not sure.

    A corner on the edge of an object has either surface's depth, so it gets none.
    """
    columns, rows = np.rint(pixels).astype(np.intp).T
    offsets = np.arange(-1, 2)
    rows = np.clip(rows[:, None] + offsets, 0, depth.shape[0] - 1)
    columns = np.clip(columns[:, None] + offsets, 0, depth.shape[1] - 1)
    around = depth[rows[:, :, None], columns[:, None, :]].reshape(-1, 9).astype(np.float64)
    missing = (around <= 0) | (around > max_depth)
    around[missing] = max_depth + 1.0
    around.sort(axis=1)
    last = np.maximum((~missing).sum(axis=1) - 1, 0)
    row = np.arange(len(around))
    median = around[row, last // 2]
    sure = (last >= 4) & (around[row, last] - around[:, 0] <= spread * median)
    return np.where(sure, median, 0.0)
