"""Corners above the floor, whose depth tells whether the camera is where it seems to be.

The floor is as far away wherever the robot stands, and its boards and tiles repeat.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import predicted_pixels
from vizbot.core.geometry import invert, transform
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics

_FLOOR = 0.1
"""What is no higher may be the floor [m]."""
_OFF, _OFF_PER_METRE = 0.1, 0.05
"""So far off depth and place may be [m], and so much more for each metre away."""


class DepthConsistencyConfig(BaseModel):
    """When depth speaks for or against a place."""

    model_config = SETTINGS

    corners: int = Field(default=20, gt=0)
    """Of the corners above the floor, so many ..."""
    share: float = Field(default=0.5, gt=0.0)
    """... and such a share must be as far away as they should be: then all is in its place; if so
    many are not, nothing is."""


class DepthConsistency:
    """Knows them, and holds depth against those of another image."""

    def __init__(
        self, intrinsics: Intrinsics, T_base_cam: SE3, config: DepthConsistencyConfig
    ) -> None:
        self._intrinsics = intrinsics
        self._T_base_cam = T_base_cam
        self._config = config

    def among(self, features: Features) -> Features:
        """All but those on the floor; what has no depth may be anywhere."""
        kept = self._are_above_floor(features.points) | ~(features.points[:, 2] > 0)
        return Features(features.pixels[kept], features.descriptors[kept], features.points[kept])

    def are_in_place(
        self, features: Features, T_features_cam: SE3, depth: NDArray[np.float32]
    ) -> bool:
        """Whether a camera there sees them as far away as they should be.

        Args:
            features: Of another image.
            T_features_cam: The camera in that one's.
            depth: That it measures (H, W) [m]; 0 where it knows none.
        """
        fits, off = self._distances(features, T_features_cam, depth)
        return self._are_many(fits, fits + off)

    def are_out_of_place(
        self, features: Features, T_features_cam: SE3, depth: NDArray[np.float32]
    ) -> bool:
        """Whether it does not; of a plain wall depth may know nothing, which is neither."""
        fits, off = self._distances(features, T_features_cam, depth)
        return self._are_many(off, fits + off)

    def _are_above_floor(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.asarray(transform(self._T_base_cam, points)[:, 2] > _FLOOR)

    def _are_many(self, count: int, of: int) -> bool:
        return count >= max(self._config.corners, self._config.share * of)

    def _distances(
        self, features: Features, T_features_cam: SE3, depth: NDArray[np.float32]
    ) -> tuple[int, int]:
        """How many are as far away as they should be, and how many not."""
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
    """How many corners with depth a camera there should see, if nothing stands before them."""
    pixels = predicted_pixels(features, T_features_cam, intrinsics)
    return int(np.count_nonzero(_in_view(features, pixels, intrinsics)))


def _in_view(
    features: Features, pixels: NDArray[np.float64], intrinsics: Intrinsics
) -> NDArray[np.bool_]:
    last = np.array([intrinsics.width, intrinsics.height]) - 1
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 0) & (pixels <= last)).all(axis=1)
    return np.asarray(inside & (features.points[:, 2] > 0))
