"""The poses and coloured points that a run has recorded; it grows without moving earlier ones.

Both grow with what the robot has seen, not with the time that it takes: poses are kept where the
camera moved, points where none is yet.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import GrowingTable
from mapping.keyframes.anchors import Cloud, Keyframes, Trajectory, points_in_map
from vizbot.core.geometry import invert, rotation_angle, transform
from vizbot.core.types import SE3, PoseEstimate

_CLOUD_ROOM = 1 << 28
"""Number of points that have addresses."""
_DISTANCE, _TURN = 0.1, 0.2
"""A pose is kept where the camera moved or turned more than this since the last one [m, rad]."""
_VOXEL = 0.03
"""Edge of a cube of space that has one point of the cloud [m]."""
_MOST_VOXELS = 1 << 20
"""Voxels along an axis whose numbers differ: 31 km of them."""


class RunRecord:
    """Poses of the camera and a coloured cloud. Later additions do not change returned arrays.

    Attributes:
        frames: Number of frames so far, those of a saved map included.
    """

    def __init__(
        self,
        trajectory: Trajectory | None = None,
        cloud: Cloud | None = None,
        *,
        every_pose: bool = False,
    ) -> None:
        """Begin empty, or with trajectory and cloud of a saved map.

        With `every_pose` the pose of every frame is kept.
        """
        self._every_pose = every_pose
        self._trajectory = GrowingTable(Trajectory.empty() if trajectory is None else trajectory)
        self._cloud = GrowingTable(Cloud.empty() if cloud is None else cloud, _CLOUD_ROOM)
        self._voxels = np.zeros(0, np.int64)
        self._keyframe_stamps: dict[int, float] = {}
        self._T_map_kept: SE3 | None = None
        self.frames = len(self._trajectory)

    @classmethod
    def going_on(
        cls,
        trajectory: Trajectory,
        cloud: Cloud,
        keyframes: Keyframes,
        before: float,
        frames: int = 0,
        *,
        every_pose: bool = False,
    ) -> RunRecord:
        """Continue the record of a saved map, as if all of it were from before a time [s].

        `frames` is the number of frames of the map, as far as that is known.
        """
        late = trajectory.late(before)
        shifted = Trajectory(
            trajectory.stamps - late,
            trajectory.Ts_map_cam,
            trajectory.keyframes,
            trajectory.Ts_keyframe_cam,
        )
        record = cls(shifted, cloud, every_pose=every_pose)
        record.frames = max(record.frames, frames)
        stamps = (keyframes.stamps - late).tolist()
        record._keyframe_stamps |= zip(keyframes.ids.tolist(), stamps, strict=True)
        points = points_in_map(cloud.points_keyframe, cloud.keyframes, keyframes.poses())
        record._voxels = np.unique(_voxels_of(points))
        return record

    def add(self, estimate: PoseEstimate) -> None:
        """Add the pose of a frame, which is kept where it is a keyframe's or the camera moved."""
        self.frames += 1
        if estimate.is_keyframe:
            self._keyframe_stamps[estimate.keyframe] = estimate.stamp
        elif not (self._every_pose or self._moved(estimate.T_map_cam)):
            return
        self._T_map_kept = estimate.T_map_cam
        self._trajectory.add(
            Trajectory(
                np.array([estimate.stamp]),
                estimate.T_map_cam[None],
                np.array([estimate.keyframe], np.int32),
                estimate.T_keyframe_cam[None],
            )
        )

    def _moved(self, T_map_cam: SE3) -> bool:
        """Whether the camera is elsewhere than where the last kept pose was."""
        if self._T_map_kept is None:
            return True
        T_kept_cam = invert(self._T_map_kept) @ T_map_cam
        return bool(
            np.linalg.norm(T_kept_cam[:3, 3]) > _DISTANCE or rotation_angle(T_kept_cam) > _TURN
        )

    def add_points(
        self, keyframe: int, T_map_cam: SE3, points: NDArray[np.float32], rgb: NDArray[np.uint8]
    ) -> None:
        """Add points (P, 3) in a keyframe's camera [m] with their colours (P, 3), one a voxel.

        `T_map_cam` is where the keyframe is; voxels that have a point already get no other.
        """
        voxels, first = np.unique(_voxels_of(transform(T_map_cam, points)), return_index=True)
        slots = np.searchsorted(self._voxels, voxels)
        last = len(self._voxels) - 1
        fresh = (
            self._voxels[np.minimum(slots, last)] != voxels
            if last >= 0
            else np.ones(len(voxels), np.bool_)
        )
        self._voxels = np.insert(self._voxels, slots[fresh], voxels[fresh])
        chosen = first[fresh]
        anchors = np.full(len(chosen), keyframe, np.int32)
        self._cloud.add(Cloud(points[chosen].astype(np.float32), rgb[chosen], anchors))

    @property
    def trajectory(self) -> Trajectory:
        """Poses of the keyframes, and of the frames between which the camera moved."""
        return self._trajectory.rows

    @property
    def cloud(self) -> Cloud:
        """All points so far."""
        return self._cloud.rows

    @property
    def keyframe_stamps(self) -> dict[int, float]:
        """When the frame of each keyframe was taken [s], by its id."""
        return dict(self._keyframe_stamps)


def _voxels_of(points: NDArray[np.floating]) -> NDArray[np.int64]:
    """The number (P,) of the voxel that each point (P, 3) in `map` [m] is in."""
    column, row, layer = (np.floor(points / _VOXEL).astype(np.int64) % _MOST_VOXELS).T
    return np.asarray((layer * _MOST_VOXELS + row) * _MOST_VOXELS + column)
