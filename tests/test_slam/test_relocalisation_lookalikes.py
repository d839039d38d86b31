"""What looks alike in several places does not tell a lost robot where it is."""

from dataclasses import replace

import numpy as np
import pytest

from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from tests.helpers.box_room import CAMERA, ELSEWHERE, RAYS, T_BASE_CAM, WALLS, follow, render
from vizbot.core.geometry import planar, transform
from vizbot.core.types import Tracking

pytestmark = pytest.mark.slow

TURNS = [planar(-1.2, 0.0, 0.15 * i) for i in range(12)]


def on_floor(frame):
    """Which pixels (H, W) show it."""
    return transform(T_BASE_CAM, RAYS * frame.depth[..., None])[..., 2] < 0.05


def map_of(known, T_map_again=None):
    """Keyframes and views of what a robot has seen, perhaps a second time elsewhere."""
    poses, views = known.keyframe_poses(), KeyframeViews.with_features(known.features())
    ids = np.array(sorted(poses), np.int32)
    Ts_map_cam = np.array([poses[i] for i in ids])
    if T_map_again is not None:
        ids, Ts_map_cam = (
            np.concatenate([ids, ids + 1000]),
            np.concatenate([Ts_map_cam, T_map_again @ Ts_map_cam]),
        )
        views = KeyframeViews(
            np.tile(views.pixels, (2, 1)),
            np.tile(views.descriptors, (2, 1)),
            np.tile(views.points, (2, 1)),
            np.concatenate([views.keyframes, views.keyframes + 1000]),
        )
    return Keyframes(ids, np.zeros(len(ids)), Ts_map_cam), views


def recognised(keyframes, views, walls=WALLS):
    """Whether a robot that is put down knows the place in a room with the same floor."""
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    slam.start_in_map(keyframes, views)
    for i, T in enumerate(TURNS):
        room, other = render(T, 0.2 * i), render(T, 0.2 * i, walls=walls)
        rgb = np.where(on_floor(room)[..., None], room.rgb, other.rgb)
        estimate = slam.track(replace(room, rgb=rgb), T)
        if estimate.tracking is Tracking.RELOCALISED:
            return True
    return False


@pytest.fixture(scope="module")
def known():
    return follow(TURNS, TURNS)[0]


def test_the_same_floor_in_another_room_is_not_the_same_place(known):
    assert recognised(*map_of(known))
    assert not recognised(*map_of(known), walls=ELSEWHERE)


def test_a_room_that_the_map_has_twice_is_not_recognised(known):
    assert not recognised(*map_of(known, planar(5.0, 0.0, 0.0)))
