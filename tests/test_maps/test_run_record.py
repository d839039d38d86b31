"""What a run keeps of its poses and points."""

import numpy as np

from mapping.keyframes.anchors import Keyframes
from vizbot.core.geometry import planar
from vizbot.core.types import PoseEstimate, Tracking
from vizbot.perception.run_record import RunRecord


def estimate(stamp, x, yaw=0.0, is_keyframe=False):
    T_map_cam = planar(x, 0.0, yaw)
    return PoseEstimate(stamp, T_map_cam, 0, T_map_cam, is_keyframe, Tracking.TRACKING)


def test_poses_are_kept_where_the_camera_moved_and_all_frames_are_counted():
    record = RunRecord()
    moves = (0.0, 0.0), (0.05, 0.0), (0.12, 0.0), (0.15, 0.0), (0.15, 0.3), (0.15, 0.4), (0.2, 0.4)
    for stamp, (x, yaw) in enumerate(moves):
        record.add(estimate(float(stamp), x, yaw, is_keyframe=stamp in (0, 6)))
    assert record.frames == 7
    assert record.trajectory.stamps.tolist() == [0.0, 2.0, 4.0, 6.0]
    assert record.keyframe_stamps == {0: 6.0}


def test_the_cloud_has_one_point_a_voxel_whichever_keyframe_shows_it():
    record, grey = RunRecord(), np.zeros((3, 3), np.uint8)
    points = np.array([[1.0, 0.0, 0.0], [1.001, 0.001, 0.001], [2.0, 0.0, 0.0]], np.float32)
    record.add_points(0, np.eye(4), points, grey)
    assert len(record.cloud.points_keyframe) == 2
    record.add_points(1, planar(1.0, 0.0, 0.0), points, grey)
    assert record.cloud.points_keyframe[2:, 0].tolist() == [2.0], "at 3 m; at 2 m one is"
    assert record.cloud.keyframes.tolist() == [0, 0, 1]


def test_a_saved_map_has_its_points_already():
    record, grey = RunRecord(), np.zeros((1, 3), np.uint8)
    point = np.array([[1.0, 0.0, 0.01]], np.float32)
    record.add(estimate(0.0, 0.0, is_keyframe=True))
    record.add_points(0, np.eye(4), point, grey)
    kept = Keyframes.with_poses({0: np.eye(4)}, record.keyframe_stamps)
    onward = RunRecord.going_on(record.trajectory, record.cloud, kept, before=9.0, frames=40)
    onward.add_points(1, np.eye(4), point, grey)
    assert len(onward.cloud.points_keyframe) == 1 and onward.frames == 40
