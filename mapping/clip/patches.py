"""Patches of a frame at several scales: where they are, and what they show (paper, III-A)."""

from __future__ import annotations

import logging
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.config import ClipMapperConfig
from mapping.clip.mapper import FrameElements
from vizbot.core.camera_limits import FARTHEST_DEPTH
from vizbot.core.program.kernels import kernel
from vizbot.core.types import Intrinsics, RGBDFrame

if TYPE_CHECKING:  # the protocol's module loads torch
    from mapping.clip.encoder import ClipEncoder

logger = logging.getLogger(__name__)

NEAR_MEDIAN = 3.0
"""Standard deviations of depth from the median within which a patch's pixels give its point."""
ALL_PIXELS = np.inf
"""The same for the paper's mean of all pixels."""
_DEPTH_STEP = 0.01
"""Step within which medians of depth are found [m]."""
_SIGMA_OF_MAD = 1.4826
"""Standard deviation of a normal distribution, in median absolute deviations."""
_LEAST_SPREAD = 0.02
"""Least spread, as a fraction of depth: the noise of a stereo camera on a plain wall."""


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
    depth: NDArray[np.float32],
    intrinsics: Intrinsics,
    boxes: NDArray[np.int32],
    spreads: float = NEAR_MEDIAN,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean of the back-projected points of each patch (paper, equations 2 and 4).

    Pixels without depth, or beyond `FARTHEST_DEPTH`, are ignored, and so are those far from the
    patch's median depth: a stereo camera's false matches would move the mean.

    Args:
        depth: (H, W) [m], 0 where nothing was measured.
        intrinsics: Of the depth image.
        boxes: (P, 4) as of `patch_boxes`.
        spreads: How far from the median depth a pixel may be, in standard deviations by the median
            absolute deviation; infinite for the paper's mean of all pixels.

    Returns:
        Points (P, 3) in `cam` [m] (meaningless where nothing was measured), and the share (P,) of
        each patch's pixels that have depth.
    """
    x = (np.arange(intrinsics.width) - intrinsics.cx) / intrinsics.fx
    y = (np.arange(intrinsics.height) - intrinsics.cy) / intrinsics.fy
    points, shares = np.zeros((len(boxes), 3)), np.zeros(len(boxes))
    _mean_points(np.ascontiguousarray(depth), boxes, x, y, spreads, points, shares)
    return points, shares


@kernel(
    "void(f4[:,::1], Array(i4, 2, 'C', readonly=True), f8[::1], f8[::1], f8, f8[:,::1], f8[::1])"
)
def _mean_points(
    depth: NDArray[np.float32],
    boxes: NDArray[np.int32],
    x: NDArray[np.floating],
    y: NDArray[np.floating],
    spreads: float,
    points: NDArray[np.float64],
    shares: NDArray[np.float64],
) -> None:
    """Fill in what `patch_points` returns; `x` (W,) and `y` (H,) are a pixel's at depth 1."""
    pixels_at = np.zeros(int(FARTHEST_DEPTH / _DEPTH_STEP) + 1, np.int64)
    for patch in range(len(boxes)):
        u0, v0, u1, v1 = boxes[patch]
        pixels_at[:] = 0
        for v in range(v0, v1):
            for u in range(u0, u1):
                if 0.0 < depth[v, u] <= FARTHEST_DEPTH:
                    pixels_at[int(depth[v, u] / _DEPTH_STEP)] += 1
        measured = pixels_at.sum()
        if measured == 0:
            continue
        shares[patch] = measured / ((u1 - u0) * (v1 - v0))
        middle, below = 0, pixels_at[0]
        while 2 * below < measured:
            middle += 1
            below += pixels_at[middle]
        reach, around = 0, pixels_at[middle]
        while 2 * around < measured:
            reach += 1
            if middle >= reach:
                around += pixels_at[middle - reach]
            if middle + reach < len(pixels_at):
                around += pixels_at[middle + reach]
        median = (middle + 0.5) * _DEPTH_STEP
        spread = max(_SIGMA_OF_MAD * reach * _DEPTH_STEP, _LEAST_SPREAD * median)
        most = spreads * spread + _DEPTH_STEP
        count = 0
        for v in range(v0, v1):
            for u in range(u0, u1):
                z = depth[v, u]
                if 0.0 < z <= FARTHEST_DEPTH and abs(z - median) <= most:
                    count += 1
                    points[patch, 0] += z * x[u]
                    points[patch, 1] += z * y[v]
                    points[patch, 2] += z
        points[patch] /= count


def embed_frame(
    frame: RGBDFrame,
    encoder: ClipEncoder,
    config: ClipMapperConfig,
    spreads: float = NEAR_MEDIAN,
) -> FrameElements:
    """Features and points of a frame's patches (paper, equations 1, 2 and 4), in one batch.

    `spreads` is that of `patch_points`.
    """
    boxes = patch_boxes(frame.intrinsics.width, frame.intrinsics.height, config)
    points, depth_part = patch_points(frame.depth, frame.intrinsics, boxes, spreads)
    kept = depth_part >= config.min_depth_share
    boxes = boxes[kept]
    embeddings = encoder.embed_images([frame.rgb[v0:v1, u0:u1] for u0, v0, u1, v1 in boxes])
    return FrameElements(points[kept], embeddings, boxes)
