"""The poses and coloured points that a run has recorded; it grows without moving earlier ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import GrowingRows
from mapping.keyframes.anchors import Cloud, Keyframes, Trajectory
from vizbot.core.types import PoseEstimate

_CLOUD_ROOM = 1 << 28
"""Number of points that have addresses: some 17 hours of driving give as many."""


class RunRecord:
    """Poses of all frames and a coloured cloud. Later additions do not change returned arrays."""

    def __init__(self, trajectory: Trajectory | None = None, cloud: Cloud | None = None) -> None:
        """Begin empty, or with trajectory and cloud of a saved map."""
        first = Trajectory.empty() if trajectory is None else trajectory
        self._stamps = GrowingRows(first.stamps)
        self._Ts_map_cam = GrowingRows(first.Ts_map_cam)
        self._keyframes = GrowingRows(first.keyframes)
        self._Ts_keyframe_cam = GrowingRows(first.Ts_keyframe_cam)
        shown = Cloud.empty() if cloud is None else cloud
        self._points = GrowingRows(shown.points_keyframe, _CLOUD_ROOM)
        self._rgb = GrowingRows(shown.rgb, _CLOUD_ROOM)
        self._anchors = GrowingRows(shown.keyframes, _CLOUD_ROOM)
        self._keyframe_stamps: dict[int, float] = {}

    @classmethod
    def going_on(
        cls, trajectory: Trajectory, cloud: Cloud, keyframes: Keyframes, before: float
    ) -> RunRecord:
        """Continue the record of a saved map, as if all of it were from before a time [s]."""
        late = trajectory.late(before)
        shifted = Trajectory(
            trajectory.stamps - late,
            trajectory.Ts_map_cam,
            trajectory.keyframes,
            trajectory.Ts_keyframe_cam,
        )
        record = cls(shifted, cloud)
        stamps = (keyframes.stamps - late).tolist()
        record._keyframe_stamps |= zip(keyframes.ids.tolist(), stamps, strict=True)
        return record

    def __len__(self) -> int:
        """Number of frames."""
        return len(self._stamps)

    def add(self, estimate: PoseEstimate) -> None:
        """Add the pose of a frame."""
        self._stamps.add_same(estimate.stamp, 1)
        self._Ts_map_cam.add_same(estimate.T_map_cam, 1)
        self._keyframes.add_same(estimate.keyframe, 1)
        self._Ts_keyframe_cam.add_same(estimate.T_keyframe_cam, 1)
        if estimate.is_keyframe:
            self._keyframe_stamps[estimate.keyframe] = estimate.stamp

    def add_points(
        self, keyframe: int, points: NDArray[np.float32], rgb: NDArray[np.uint8]
    ) -> None:
        """Add points (P, 3) in a keyframe's camera [m], with their colours (P, 3)."""
        self._points.add(points)
        self._rgb.add(rgb)
        self._anchors.add_same(keyframe, len(points))

    @property
    def Ts_keyframe_cam(self) -> NDArray[np.float64]:
        """(F, 4, 4) of all frames, each in the camera of its keyframe."""
        return self._Ts_keyframe_cam.rows

    @property
    def trajectory(self) -> Trajectory:
        """Poses of all frames so far."""
        return Trajectory(
            self._stamps.rows, self._Ts_map_cam.rows, self._keyframes.rows, self.Ts_keyframe_cam
        )

    @property
    def cloud(self) -> Cloud:
        """All points so far."""
        return Cloud(self._points.rows, self._rgb.rows, self._anchors.rows)

    @property
    def keyframe_stamps(self) -> dict[int, float]:
        """When the frame of each keyframe was taken [s], by its id."""
        return dict(self._keyframe_stamps)
