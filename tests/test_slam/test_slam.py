"""Pose estimation in a textured box room, ray cast, with known truth."""

from collections.abc import Sequence
from itertools import islice

import numpy as np
import pytest

from drivers.tum_sequence import RecordedSequence
from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from mapping.trajectory_error import absolute_trajectory_error
from mapping.tum import read_trajectory
from tests.helpers.box_room import (
    CAMERA,
    T_BASE_CAM,
    dead_reckoning,
    errors,
    follow,
    lap,
    render,
    turns,
    with_gyro,
)
from tests.helpers.checkout import OFFICE_WALK
from tests.test_slam.conftest import Lap
from vizbot.core.geometry import (
    R_BASE_CAM,
    invert,
    planar,
    yaw_of,
)
from vizbot.core.types import (
    SE3,
    PoseEstimate,
    Tracking,
)


def test_the_map_starts_where_the_base_started() -> None:
    _, estimates = follow(lap(100)[:1], None)
    assert np.allclose(estimates[0].T_map_cam, T_BASE_CAM, atol=1e-12)
    assert estimates[0].is_keyframe


@pytest.mark.slow
def test_a_lap_with_wheels_ends_where_it_began(whole_lap: Lap) -> None:
    _, estimates, Ts_map_base = whole_lap
    wheels = dead_reckoning(Ts_map_base)[-1]
    off = errors(estimates, Ts_map_base)
    assert all(estimate.tracking is Tracking.TRACKING for estimate in estimates)
    assert off[:, 0].max() < 0.05
    assert off[:, 1].max() < 0.03
    assert np.linalg.norm(wheels[:2, 3]) > 0.05, "wheels alone would do as well"


def test_keyframes_are_announced_and_frames_hang_on_them(whole_lap: Lap) -> None:
    slam, estimates, _ = whole_lap
    announced = [estimate.keyframe for estimate in estimates if estimate.is_keyframe]
    assert announced == sorted(slam.keyframe_poses())
    for estimate in estimates:
        final = slam.keyframe_poses()[estimate.keyframe] @ estimate.T_keyframe_cam
        assert np.allclose(final, estimate.T_map_cam, atol=0.05)


def test_the_same_frames_give_the_same_poses_bit_for_bit(whole_lap: Lap) -> None:
    _, estimates, Ts_map_base = whole_lap
    _, again = follow(Ts_map_base[:40], dead_reckoning(Ts_map_base)[:40])
    for first, second in zip(estimates, again, strict=False):
        assert np.array_equal(first.T_map_cam, second.T_map_cam)


@pytest.mark.slow
def test_images_alone_follow_a_lap() -> None:
    Ts_map_base = lap(100)
    _, estimates = follow(Ts_map_base, None)
    assert all(estimate.tracking is Tracking.TRACKING for estimate in estimates)
    assert errors(estimates, Ts_map_base)[:, 0].max() < 0.1


@pytest.mark.slow
def test_fast_turns_on_the_spot_are_followed() -> None:
    Ts_map_base = [planar(0, 0, 0.24 * i) for i in range(27)]
    _, estimates = follow(Ts_map_base, dead_reckoning(Ts_map_base, drift=0.1))
    assert errors(estimates, Ts_map_base)[:, 1].max() < 0.03


@pytest.mark.slow
def test_wheels_carry_the_pose_through_the_dark() -> None:
    Ts_map_base = lap(100)[:60]
    _, estimates = follow(Ts_map_base, dead_reckoning(Ts_map_base), dark=range(20, 45))
    states = [estimate.tracking for estimate in estimates]
    assert states[20:45] == [Tracking.WHEELS_ONLY] * 25
    assert states[46:] == [Tracking.TRACKING] * 14
    assert errors(estimates, Ts_map_base)[:, 0].max() < 0.1


def test_wheels_that_spin_against_a_wall_do_not_move_the_pose() -> None:
    Ts_map_base = [planar(0.06 * i, 0, 0) for i in range(8)] + [planar(0.42, 0, 0)] * 15
    Ts_odom_base = [planar(0.06 * i, 0, 0) for i in range(23)]
    _, estimates = follow(Ts_map_base, Ts_odom_base)
    assert errors(estimates, Ts_map_base)[:, 0].max() < 0.05


def test_where_images_fail_the_way_that_they_knew_is_kept() -> None:
    ahead = [planar(0.04 * i - 1.0, 0.0, 0.0) for i in range(6)]
    turning = [ahead[-1] @ planar(0.0, 0.0, 0.1 * i) for i in range(1, 6)]
    Ts_map_base = ahead + turning + [turning[-1] @ planar(0.04 * i, 0.0, 0.0) for i in range(15)]
    Ts_odom_base = [invert(ahead[-1]) @ T for T in Ts_map_base]
    Ts_odom_base[: len(ahead)] = [np.eye(4)] * len(ahead)  # the wheels count nothing at first
    _, estimates = follow(Ts_map_base, Ts_odom_base, range(len(ahead), len(Ts_map_base)))
    assert estimates[-1].keyframe != estimates[5].keyframe
    assert errors(estimates, Ts_map_base)[:, 0].max() < 0.02


@pytest.mark.slow
def test_without_wheels_darkness_is_lost_and_light_is_found_again() -> None:
    Ts_map_base = lap(100)[:20] + [lap(100)[19]] * 10 + lap(100)[19:30]
    _, estimates = follow(Ts_map_base, None, dark=range(20, 28))
    states = [estimate.tracking for estimate in estimates]
    assert states[20:28] == [Tracking.LOST] * 8
    assert states[28:] == [Tracking.RELOCALISED] + [Tracking.TRACKING] * 12
    assert errors(estimates, Ts_map_base)[28:, 0].max() < 0.05


def followed_with_gyro(
    Ts_map_base: list[SE3],
    Ts_odom_base: list[SE3],
    reads: float = 1.0,
    dark_from: int = 1000,
    stuck: Sequence[int] = (),
) -> list[PoseEstimate]:
    """Estimates where the gyroscope reads so many times the turn, of nothing if that is 0.

    While images are `stuck` they show what was seen as that began.
    """
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    estimates = []
    for i, turn in enumerate(turns(Ts_map_base)):
        seen_from = Ts_map_base[stuck[0] if i in stuck else i]
        frame = render(seen_from, 0.2 * i, dark=i >= dark_from)
        frame = with_gyro(frame, reads * turn) if reads else frame
        estimates.append(slam.track(frame, Ts_odom_base[i]))
    return estimates


@pytest.mark.parametrize("gyro", [False, True])
def test_in_the_dark_the_gyroscope_keeps_the_heading_of_wheels_that_slip(gyro: bool) -> None:
    Ts_map_base = [np.eye(4)] * 8 + [planar(0, 0, 0.1 * i) for i in range(30)]
    Ts_odom_base = dead_reckoning(Ts_map_base, drift=0.1)
    estimates = followed_with_gyro(Ts_map_base, Ts_odom_base, 1.0 if gyro else 0.0, dark_from=8)
    assert estimates[-1].tracking is Tracking.WHEELS_ONLY
    wrong = errors(estimates, Ts_map_base)[-1, 1]
    assert wrong < 0.02 if gyro else wrong > 0.2


@pytest.mark.slow
def test_a_gyroscope_that_reads_too_much_is_known_for_it_when_it_gets_dark() -> None:
    Ts_map_base = [lap(100)[0]] * 8 + lap(100)[:60]
    Ts_odom_base = dead_reckoning(Ts_map_base)
    *_, estimate = followed_with_gyro(Ts_map_base, Ts_odom_base, 1.03, dark_from=40)
    assert sum(turns(Ts_map_base)[40:]) > 1.5
    T_end = invert(Ts_map_base[-1]) @ estimate.T_map_cam @ invert(T_BASE_CAM)
    assert abs(yaw_of(T_end)) < 0.01 * sum(turns(Ts_map_base)[40:])


@pytest.mark.slow
def test_images_that_stand_still_do_not_stop_a_robot_that_turns() -> None:
    Ts_map_base = [lap(100)[0]] * 8 + lap(100)[:40]
    estimates = followed_with_gyro(Ts_map_base, dead_reckoning(Ts_map_base), stuck=range(20, 30))
    states = [estimate.tracking for estimate in estimates]
    assert states[21:30] == [Tracking.WHEELS_ONLY] * 9
    assert states[35:] == [Tracking.TRACKING] * (len(states) - 35)
    assert errors(estimates, Ts_map_base)[:, 0].max() < 0.05


def test_a_camera_without_wheels_that_starts_in_the_dark_starts_with_the_light() -> None:
    Ts_map_base = [np.eye(4)] * 5 + [planar(0.05 * i, 0, 0) for i in range(10)]
    _, estimates = follow(Ts_map_base, None, dark=range(5))
    states = [estimate.tracking for estimate in estimates[6:]]
    assert states == [Tracking.RELOCALISED] + [Tracking.TRACKING] * 8
    assert errors(estimates, Ts_map_base)[-1, 0] < 0.05


@pytest.mark.long
@pytest.mark.skipif(not OFFICE_WALK.exists(), reason=f"needs the recording {OFFICE_WALK}")
@pytest.mark.parametrize("stride", [1, 2])
def test_a_walk_through_an_office_is_followed_within_30_cm(stride: int) -> None:
    T_base_cam = np.eye(4)
    T_base_cam[:3, :3] = R_BASE_CAM
    with RecordedSequence(OFFICE_WALK) as camera:
        slam = Slam(camera.intrinsics, T_base_cam, SlamConfig())
        frames = islice(iter(camera.read, None), 0, None, stride)
        estimates = [slam.track(frame, None) for frame in frames]
    online = np.array([estimate.T_map_cam for estimate in estimates])
    stamps = np.array([estimate.stamp for estimate in estimates])
    assert all(estimate.tracking is Tracking.TRACKING for estimate in estimates)
    truth = read_trajectory(OFFICE_WALK / "groundtruth.txt")
    assert absolute_trajectory_error(stamps, online, *truth) < 0.30
