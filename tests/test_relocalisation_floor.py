"""Floors look alike from room to room: a lost robot is not where the floor alone says."""

from dataclasses import replace

import numpy as np

from mapping.anchors import Keyframes
from mapping.slam import Slam
from mapping.slam_config import SlamConfig
from tests.box_room import CAMERA, ELSEWHERE, RAYS, T_BASE_CAM, WALLS, follow, render
from vizbot.core.geometry import planar, transform
from vizbot.core.types import Tracking

TURNS = [planar(-1.2, 0.0, 0.15 * i) for i in range(12)]


def on_floor(frame):
    """Which pixels (H, W) show it."""
    return transform(T_BASE_CAM, RAYS * frame.depth[..., None])[..., 2] < 0.05


def recognised(walls):
    """Whether a robot that is put down knows the place in a room with the same floor."""
    known, _ = follow(TURNS, TURNS)
    poses = known.keyframe_poses()
    ids = np.array(sorted(poses), np.int32)
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    slam.know(Keyframes(ids, np.zeros(len(ids)), np.array([poses[i] for i in ids])), known.views())
    for i, T in enumerate(TURNS):
        room, other = render(T, 0.2 * i), render(T, 0.2 * i, walls=walls)
        rgb = np.where(on_floor(room)[..., None], room.rgb, other.rgb)
        estimate = slam.track(replace(room, rgb=rgb), T)
        if estimate.tracking is Tracking.RELOCALISED:
            return True
    return False


def test_the_same_floor_in_another_room_is_not_the_same_place():
    assert recognised(WALLS)
    assert not recognised(ELSEWHERE)
