"""Checks a pose by the depth of corners above the floor.

The floor is equally far away wherever the robot stands, and its boards and tiles repeat, so it
says nothing about a pose.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import predicted_pixels
from mapping.relocalisation.config import DepthConsistencyConfig
from vizbot.core.geometry import invert, transform
from vizbot.core.types import SE3, Intrinsics

_FLOOR = 0.1
"""Height up to which a corner may lie on the floor [m]."""
_OFF, _OFF_PER_METRE = 0.1, 0.05
"""Tolerance between measured and expected depth [m], and its growth per metre of depth."""


class DepthConsistency:
    """Compares the depth image of a frame with the corners of another image."""

    def __init__(
        self, intrinsics: Intrinsics, T_base_cam: SE3, config: DepthConsistencyConfig
    ) -> None:
        self._intrinsics = intrinsics
        self._T_base_cam = T_base_cam
        self._config = config

    def above_floor(self, features: Features) -> Features:
        """The corners that are not on the floor; those without depth are kept."""
        kept = self._are_above_floor(features.points) | ~(features.points[:, 2] > 0)
        return Features(features.pixels[kept], features.descriptors[kept], features.points[kept])

    def confirms(self, features: Features, T_features_cam: SE3, depth: NDArray[np.float32]) -> bool:
        """Whether enough corners are as far away as expected from a pose.

        `T_features_cam` is the camera in that of `features`; `depth` (H, W) is its depth image [m],
        0 where nothing was measured.
        """
        fits, off = self._distances(features, T_features_cam, depth)
        return self._are_many(fits, fits + off)

    def contradicts(
        self, features: Features, T_features_cam: SE3, depth: NDArray[np.float32]
    ) -> bool:
        """Whether enough corners are not as far away as expected; arguments as `confirms`.

        Before a plain wall, where depth may be missing, both are False.
        """
        fits, off = self._distances(features, T_features_cam, depth)
        return self._are_many(off, fits + off)

    def _are_above_floor(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.asarray(transform(self._T_base_cam, points)[:, 2] > _FLOOR)

    def _are_many(self, count: int, total: int) -> bool:
        return count >= max(self._config.min_corners, self._config.min_share * total)

    def _distances(
        self, features: Features, T_features_cam: SE3, depth: NDArray[np.float32]
    ) -> tuple[int, int]:
        """How many corners in view are as far away as expected, and how many are not."""
        points = transform(invert(T_features_cam), features.points)
        pixels = predicted_pixels(features, T_features_cam, self._intrinsics)
        seen = _in_view(features, pixels, self._intrinsics)
        seen &= self._are_above_floor(points)
        columns, rows = pixels[seen].round().astype(np.int64).T
        expected, measured = points[seen, 2], depth[rows, columns]
        known = measured > 0
        off = np.abs(measured - expected)[known]
        fits = int(np.count_nonzero(off < _OFF + _OFF_PER_METRE * expected[known]))
        return fits, len(off) - fits


def corners_in_view(features: Features, T_features_cam: SE3, intrinsics: Intrinsics) -> int:
    """Number of corners with depth that a camera at a pose should see, if nothing hides them."""
    pixels = predicted_pixels(features, T_features_cam, intrinsics)
    return int(np.count_nonzero(_in_view(features, pixels, intrinsics)))


def _in_view(
    features: Features, pixels: NDArray[np.float64], intrinsics: Intrinsics
) -> NDArray[np.bool_]:
    last = np.array([intrinsics.width, intrinsics.height]) - 1
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 0) & (pixels <= last)).all(axis=1)
    return np.asarray(inside & (features.points[:, 2] > 0))
