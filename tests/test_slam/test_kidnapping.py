"""Who carries the robot away is noticed, though at first it sees what it has never seen."""

from itertools import pairwise

import numpy as np
import pytest

from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from tests.helpers.box_room import CAMERA, ELSEWHERE, T_BASE_CAM, WALLS, errors, lap, render
from vizbot.core.geometry import invert, planar
from vizbot.core.types import SE3, PoseEstimate, Tracking

pytestmark = pytest.mark.slow

OUT, BACK = lap(100)[:40], lap(100)[15:40]
TURNS = [OUT[-1] @ planar(0, 0, 0.2 * i) for i in range(20)]
DARK = range(len(OUT) + 1, len(OUT) + 6)


def track(slam: Slam, Ts_room_base: list[SE3], start: int, T_odom_base: SE3, walls: int):
    """Estimates, and where the wheels have the robot then; they feel what it drives itself."""
    steps = [np.eye(4), *(invert(a) @ b for a, b in pairwise(Ts_room_base))]
    estimates = list[PoseEstimate]()
    for i, (T_room_base, step) in enumerate(zip(Ts_room_base, steps, strict=True), start):
        T_odom_base = T_odom_base @ step
        frame = render(T_room_base, 0.2 * i, dark=i in DARK, walls=walls)
        estimates.append(slam.track(frame, T_odom_base))
    return estimates, T_odom_base


@pytest.fixture(scope="module")
def runs():
    """Out, turned away in the dark in another room or in the same, and back in the first one."""
    made = {}
    for walls, T_room_map in ((WALLS, np.eye(4)), (ELSEWHERE, planar(1.0, -0.5, 2.0))):
        slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
        out, T_odom_base = track(slam, OUT, 0, np.eye(4), WALLS)
        turns = [T_room_map @ T for T in TURNS]
        away, T_odom_base = track(slam, turns, len(out), T_odom_base, walls)
        made[walls] = away, len(slam.keyframe_poses())
        back, _ = track(slam, BACK, len(out + away), T_odom_base, WALLS)
        made[walls] = out, away, back
    return made


def test_a_new_room_after_a_break_is_not_put_where_the_robot_was_carried_from(runs):
    _, away, _ = runs[ELSEWHERE]
    assert not any(estimate.is_keyframe for estimate in away)
    assert away[-1].tracking is Tracking.LOST


def test_the_robot_knows_where_it_is_once_it_is_carried_back(runs):
    out, _, back = runs[ELSEWHERE]
    assert back[-1].tracking.by_images
    off = errors([out[0], *back], [OUT[0], *BACK])
    assert off[-5:].max() < 0.05


def test_who_turns_in_the_dark_to_what_is_new_is_not_lost(runs):
    _, away, _ = runs[WALLS]
    assert all(estimate.tracking is not Tracking.LOST for estimate in away)
    assert away[-1].tracking is Tracking.TRACKING
    assert errors([runs[WALLS][0][0], *away], [OUT[0], *TURNS])[-1].max() < 0.1


@pytest.mark.parametrize(("frames", "lost"), [(5, False), (20, True)])
def test_where_all_was_in_its_place_at_the_break_it_takes_longer_to_believe(frames, lost):
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    _, T_odom_base = track(slam, OUT, 0, np.eye(4), WALLS)
    for i in range(frames):  # pushed, as wheels do not feel
        T_room_base = OUT[-1] @ planar(min(0.15 * i, 0.6), 0, 0)
        pushed = slam.track(render(T_room_base, 10.0 + 0.2 * i, walls=ELSEWHERE), T_odom_base)
    assert (pushed.tracking is Tracking.LOST) == lost
    if not lost:
        back = slam.track(render(OUT[-1], 20.0), T_odom_base)
        assert back.tracking is Tracking.TRACKING
