"""Keyframes, and data stored in their cameras, so that it moves with the pose graph."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import SE3, PoseEstimate, Tracking


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
    def from_estimates(
        cls, keyframe_poses: Mapping[int, SE3], estimates: Iterable[PoseEstimate]
    ) -> Keyframes:
        """Join the poses of all keyframes with their stamps, from the estimates of a run."""
        stamps = {e.keyframe: e.stamp for e in estimates if e.is_keyframe}
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
    def from_parts(
        cls, parts: Sequence[tuple[int, NDArray[np.float32], NDArray[np.uint8]]]
    ) -> Cloud:
        """Join parts: keyframe id, points (n, 3) in its camera [m], rgb (n, 3) uint8."""
        return cls(
            np.concatenate([np.zeros((0, 3), np.float32)] + [points for _, points, _ in parts]),
            np.concatenate([np.zeros((0, 3), np.uint8)] + [rgb for _, _, rgb in parts]),
            np.repeat([i for i, _, _ in parts], [len(p) for _, p, _ in parts]).astype(np.int32),
        )

    def parts(self) -> list[tuple[int, NDArray[np.float32], NDArray[np.uint8]]]:
        """Split the cloud into the parts that `from_parts` joins."""
        cuts = np.flatnonzero(np.diff(self.keyframes)) + 1
        columns = (np.split(c, cuts) for c in (self.keyframes, self.points_keyframe, self.rgb))
        return [
            (int(ids[0]), points, rgb)
            for ids, points, rgb in zip(*columns, strict=True)
            if len(ids)
        ]


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
    def from_estimates(cls, estimates: Sequence[PoseEstimate]) -> Trajectory:
        """Collect the estimates of a run."""
        return cls(
            np.array([e.stamp for e in estimates], np.float64),
            np.array([e.T_map_cam for e in estimates], np.float64).reshape(-1, 4, 4),
            np.array([e.keyframe for e in estimates], np.int32),
            np.array([e.T_keyframe_cam for e in estimates], np.float64).reshape(-1, 4, 4),
        )

    def estimates(self, keyframes: Keyframes, before: float) -> list[PoseEstimate]:
        """The estimates of the run that made `keyframes`, with stamps shifted to before a time [s].

        Clocks start anew with the robot, but what a saved map holds must be older than what the
        robot sees.
        """
        late = max(float(self.stamps.max(initial=-np.inf)) - before + 1.0, 0.0)
        made_at = dict(zip(keyframes.ids.tolist(), keyframes.stamps.tolist(), strict=True))
        return [
            PoseEstimate(
                stamp - late, T_map_cam, keyframe, T_keyframe_cam, made_at[keyframe] == stamp,
                Tracking.TRACKING,
            )
            for stamp, T_map_cam, keyframe, T_keyframe_cam in zip(
                self.stamps.tolist(), self.Ts_map_cam, self.keyframes.tolist(),
                self.Ts_keyframe_cam, strict=True,
            )
        ]  # fmt: skip


_ROWS = 1 << 16
"""Points that are transformed at a time: each takes a matrix, eight times its own memory."""


def points_in_map(
    points_keyframe: NDArray[np.floating],
    keyframes: NDArray[np.int32],
    keyframe_poses: Mapping[int, SE3],
) -> NDArray[np.float64]:
    """Transform anchored points to `map` by the newest poses of their keyframes.

    Args:
        points_keyframe: (N, 3), each in the camera of its own keyframe [m].
        keyframes: (N,) ids, 0 and up.
        keyframe_poses: T_map_cam of every keyframe that is referred to.

    Returns:
        (N, 3) float64 [m].

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
