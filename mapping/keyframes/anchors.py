"""Keyframes, and data stored in their cameras, so that it moves with the pose graph."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import SE3

if TYPE_CHECKING:  # its module loads OpenCV
    from mapping.odometry.features import Features


@dataclass(frozen=True, slots=True, eq=False)
class Keyframes:
    """Nodes of the pose graph.

    Attributes:
        ids: (K,) int32.
        stamps: (K,) float64 [s].
        Ts_map_cam: (K, 4, 4) float64, after the last optimisation.
    """

    ids: NDArray[np.int32]
    stamps: NDArray[np.float64]
    Ts_map_cam: NDArray[np.float64]

    @classmethod
    def with_poses(
        cls, keyframe_poses: Mapping[int, SE3], stamps: Mapping[int, float]
    ) -> Keyframes:
        """All keyframes that have a pose, with the stamps [s] of their frames."""
        ids = sorted(keyframe_poses)
        return cls(
            np.array(ids, np.int32),
            np.array([stamps[i] for i in ids], np.float64),
            np.array([keyframe_poses[i] for i in ids], np.float64).reshape(-1, 4, 4),
        )

    def poses(self) -> dict[int, SE3]:
        """T_map_cam by id."""
        return dict(zip(self.ids.tolist(), self.Ts_map_cam, strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class KeyframeViews:
    """Corners of keyframes, by which places are recognised.

    Attributes:
        pixels: (N, 2) float32 column, row [px].
        descriptors: (N, 4) uint64, 256 bits each.
        points: (N, 3) float32, each in the camera of its keyframe [m]; (0, 0, 0) without depth.
        keyframes: (N,) int32, ids, in rising order.
    """

    pixels: NDArray[np.float32]
    descriptors: NDArray[np.uint64]
    points: NDArray[np.float32]
    keyframes: NDArray[np.int32]

    @classmethod
    def empty(cls) -> KeyframeViews:
        """The views of no keyframe."""
        return cls(
            np.zeros((0, 2), np.float32),
            np.zeros((0, 4), np.uint64),
            np.zeros((0, 3), np.float32),
            np.zeros(0, np.int32),
        )

    @classmethod
    def with_features(cls, features: Mapping[int, Features]) -> KeyframeViews:
        """Join the corners of keyframes."""
        ids = sorted(features)
        if not ids:
            return cls.empty()
        shown = [features[keyframe] for keyframe in ids]
        return cls(
            np.concatenate([each.pixels for each in shown]).astype(np.float32),
            np.concatenate([each.descriptors for each in shown]),
            np.concatenate([each.points for each in shown]).astype(np.float32),
            np.repeat(ids, [len(each) for each in shown]).astype(np.int32),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """A coloured point cloud.

    Attributes:
        points_keyframe: (P, 3) float32, each in the camera of its keyframe [m].
        rgb: (P, 3) uint8.
        keyframes: (P,) int32, ids.
    """

    points_keyframe: NDArray[np.float32]
    rgb: NDArray[np.uint8]
    keyframes: NDArray[np.int32]

    @classmethod
    def empty(cls) -> Cloud:
        """A cloud without points."""
        return cls(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint8), np.zeros(0, np.int32))


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Poses of all frames of a run, as estimated online and anchored to keyframes.

    Attributes:
        stamps: (F,) float64 [s].
        Ts_map_cam: (F, 4, 4) float64, the online poses.
        keyframes: (F,) int32, ids.
        Ts_keyframe_cam: (F, 4, 4) float64.
    """

    stamps: NDArray[np.float64]
    Ts_map_cam: NDArray[np.float64]
    keyframes: NDArray[np.int32]
    Ts_keyframe_cam: NDArray[np.float64]

    @classmethod
    def empty(cls) -> Trajectory:
        """The trajectory of no frame."""
        return cls(np.zeros(0), np.zeros((0, 4, 4)), np.zeros(0, np.int32), np.zeros((0, 4, 4)))

    def late(self, before: float) -> float:
        """How much earlier [s] the frames have to be taken for them all to be before a time [s].

        Clocks start anew with the robot, but what a saved map holds must be older than what the
        robot sees.
        """
        return max(float(self.stamps.max(initial=-np.inf)) - before + 1.0, 0.0)


_ROWS = 1 << 16
"""Points that are transformed at a time: each takes a matrix, eight times its own memory."""


def points_in_map(
    points_keyframe: NDArray[np.floating],
    keyframes: NDArray[np.int32],
    keyframe_poses: Mapping[int, SE3],
) -> NDArray[np.float64]:
    """Anchored points (N, 3) in `map` [m], by the newest poses of their keyframes.

    Args:
        points_keyframe: (N, 3), each in the camera of its own keyframe [m].
        keyframes: (N,) ids, 0 and up.
        keyframe_poses: T_map_cam of every keyframe that is referred to.

    Raises:
        KeyError: a keyframe that is referred to has no pose.
    """
    Ts_map_keyframe = _poses_by_id(keyframes, keyframe_poses)
    points_map = np.empty((len(keyframes), 3))
    for start in range(0, len(keyframes), _ROWS):
        rows = slice(start, start + _ROWS)
        Ts_map_anchor = Ts_map_keyframe[keyframes[rows]]
        np.einsum(
            "nij,nj->ni", Ts_map_anchor[:, :3, :3], points_keyframe[rows], out=points_map[rows]
        )
        points_map[rows] += Ts_map_anchor[:, :3, 3]
    return points_map


def poses_in_map(
    Ts_keyframe_cam: NDArray[np.float64],
    keyframes: NDArray[np.int32],
    keyframe_poses: Mapping[int, SE3],
) -> NDArray[np.float64]:
    """Poses Ts_map_cam (N, 4, 4) of frames anchored to keyframes; arguments as `points_in_map`."""
    return np.asarray(_poses_by_id(keyframes, keyframe_poses)[keyframes] @ Ts_keyframe_cam)


def _poses_by_id(
    keyframes: NDArray[np.int32], keyframe_poses: Mapping[int, SE3]
) -> NDArray[np.float64]:
    """Poses (largest id + 1, 4, 4), so that a gather replaces a search."""
    used = np.flatnonzero(np.bincount(keyframes))
    Ts_map_keyframe = np.zeros((used[-1] + 1 if len(used) else 0, 4, 4))
    for keyframe in used.tolist():
        Ts_map_keyframe[keyframe] = keyframe_poses[keyframe]
    return Ts_map_keyframe
