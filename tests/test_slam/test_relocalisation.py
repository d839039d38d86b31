"""A robot that does not know where it is, in a textured box room, ray cast, with known truth."""

import numpy as np
import pytest

from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.occupancy.config import DepthMapperConfig
from mapping.relocalisation.config import LocalMapConfig, RelocalisationConfig
from mapping.relocalisation.local_map import LocalMap
from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from tests.helpers.box_room import (
    CAMERA,
    ELSEWHERE,
    ROOM,
    T_BASE_CAM,
    WALLS,
    dead_reckoning,
    errors,
    follow,
    lap,
    render,
)
from tests.test_slam.conftest import Lap
from vizbot.core.geometry import invert, planar, rotation_angle
from vizbot.core.types import SE3, OccupancyGrid, PoseEstimate, Tracking

pytestmark = pytest.mark.slow


def obstacles(size: float = 1.0, *, closed: bool = False) -> OccupancyGrid:
    """The room in the map of a lap; its wall at the right has never been seen.

    With all four walls, `closed`, it would look the same from the other side.
    """
    (left, bottom), (right, top) = ROOM[:, :2] * size - lap(100)[0][:2, 3]
    grid = OccupancyGrid(np.full((160, 160), 0.5, np.float32), 0.05, np.array([-4.0, -4.0]))
    x, y = np.moveaxis(grid.to_xy(np.stack(np.mgrid[:160, :160], axis=-1)), -1, 0)
    seen_to = right if closed else right - 0.3
    inside = (x > left) & (x < seen_to) & (y > bottom) & (y < top)
    wall = (x > left - 0.1) & (x < seen_to + 0.1 * closed) & (y > bottom - 0.1) & (y < top + 0.1)
    grid.occupancy[wall] = 0.95
    grid.occupancy[inside] = 0.05
    return grid


def resumed(
    slam: Slam, known: OccupancyGrid | None = None, config: SlamConfig | None = None
) -> Slam:
    """A new estimator that begins in the map of another."""
    poses = slam.keyframe_poses()
    around = None
    if known is not None:
        around = LocalMap(lambda: known, DepthMapperConfig(), LocalMapConfig())
    again = Slam(CAMERA, T_BASE_CAM, config or SlamConfig(), around)
    ids = np.array(sorted(poses), np.int32)
    again.start_in_map(
        Keyframes(ids, np.zeros(len(ids)), np.array([poses[i] for i in ids])),
        KeyframeViews.with_features(slam.features()),
    )
    return again


def tracked(
    slam: Slam, path: list[SE3], Ts_odom_base: list[SE3] | list[None], walls: int = WALLS
) -> list[PoseEstimate]:
    """Estimates along a path, on another day."""
    return [
        slam.track(render(T, 100 + 0.2 * i, walls=walls), Ts_odom_base[i])
        for i, T in enumerate(path)
    ]


def assert_at(estimate: PoseEstimate, T_first_base: SE3, metres: float, radians: float) -> None:
    """Check where the robot is, as seen from where the first lap began."""
    off = invert(T_first_base @ T_BASE_CAM) @ estimate.T_map_cam
    assert np.linalg.norm(off[:3, 3]) < metres
    assert rotation_angle(off) < radians


@pytest.mark.sampled
@pytest.mark.parametrize("start", [12, 50, 83])
@pytest.mark.parametrize("wheels", [False, True])
def test_in_a_saved_map_a_camera_recognises_where_it_is(
    whole_lap: Lap, start: int, wheels: bool
) -> None:
    slam, _, Ts_map_base = whole_lap
    again, seen = resumed(slam), Ts_map_base[start : start + 12]
    aside = [T @ planar(0.05, 0.1, 0.1) for T in seen]
    Ts_odom_base = dead_reckoning(aside) if wheels else [None] * len(aside)
    estimates = tracked(again, aside, Ts_odom_base)
    states = [estimate.tracking for estimate in estimates]
    known = states.index(Tracking.RELOCALISED)
    assert known <= 1
    assert states[known + 1 :] == [Tracking.TRACKING] * (11 - known)
    for estimate, T_map_base in zip(estimates[known:], aside[known:], strict=True):
        assert_at(estimate, invert(Ts_map_base[0]) @ T_map_base, 0.05, 0.03)


def test_a_room_that_the_saved_map_does_not_hold_is_not_recognised(whole_lap: Lap) -> None:
    again = resumed(whole_lap[0])
    before = set(again.keyframe_poses())
    frames = (render(T, 0.2 * i, walls=ELSEWHERE) for i, T in enumerate(lap(100)[::5]))
    assert all(again.track(frame, None).tracking is Tracking.LOST for frame in frames)
    assert set(again.keyframe_poses()) == before


def test_a_robot_that_stands_lost_for_long_remembers_only_what_it_guessed_last(
    whole_lap: Lap,
) -> None:
    unsure = RelocalisationConfig(single_frame_inliers=10_000, remembered_frames=3)
    again = resumed(whole_lap[0], config=SlamConfig(relocalisation=unsure))
    T_map_base = whole_lap[2][12]
    states = [again.track(render(T_map_base, 0.2 * i), np.eye(4)).tracking for i in range(6)]
    assert set(states) == {Tracking.LOST}
    assert len(again._relocaliser._hypotheses) == 3


def test_a_robot_that_is_carried_away_notices_and_finds_itself() -> None:
    Ts_map_base = lap(100)[:60]
    away = Ts_map_base[10] @ planar(0.02, 0.05, 0.05)
    driven = [*Ts_map_base, *(away @ planar(0.02 * i, 0.0, 0.02 * i) for i in range(12))]
    wheels = dead_reckoning(Ts_map_base)
    wheels += [wheels[-1] @ planar(0.02 * i, 0.0, 0.02 * i) for i in range(12)]
    _, estimates = follow(driven, wheels)
    states = [estimate.tracking for estimate in estimates[60:]]
    known = states.index(Tracking.RELOCALISED)
    assert Tracking.TRACKING not in states[:known]
    assert states[known + 1 :] == [Tracking.TRACKING] * (11 - known)
    assert errors(estimates, driven)[60 + known :, 0].max() < 0.06


def test_where_all_is_in_its_place_a_few_frames_that_match_nothing_do_not_carry_it_away() -> None:
    Ts_map_base = lap(100)[:66]
    frames = [render(T, 0.2 * i) for i, T in enumerate(Ts_map_base[:60])]
    frames += [render(T, 20.0 + i, walls=ELSEWHERE) for i, T in enumerate(Ts_map_base[60:])]
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    wheels = dead_reckoning(Ts_map_base)
    states = [slam.track(f, T).tracking for f, T in zip(frames, wheels, strict=True)]
    assert set(states[60:]) == {Tracking.WHEELS_ONLY}


def test_a_robot_that_is_carried_away_while_it_turns_notices() -> None:
    Ts_map_base = lap(100)[:20]
    turning = [Ts_map_base[-1] @ planar(0.0, 0.0, 0.15 * i) for i in range(1, 4)]
    away = planar(-1.0, 0.5, 2.0)
    carried = [away @ planar(0.0, 0.0, 0.15 * i) for i in range(6)]
    wheels = dead_reckoning([*Ts_map_base, *turning])
    wheels += [wheels[-1] @ planar(0.0, 0.0, 0.15 * i) for i in range(6)]
    _, estimates = follow([*Ts_map_base, *turning, *carried], wheels)
    states = [estimate.tracking for estimate in estimates]
    assert Tracking.LOST not in states[: len(Ts_map_base) + 3]
    assert states[-3:] == [Tracking.LOST] * 3
    assert not any(estimate.is_keyframe for estimate in estimates[-6:])


def test_where_images_tell_nothing_obstacles_tell_where_the_robot_is(whole_lap: Lap) -> None:
    slam, _, Ts_map_base = whole_lap
    again, before = resumed(slam, obstacles()), len(slam.keyframe_poses())
    start = Ts_map_base[20] @ planar(-0.2, 0.3, 1.0)
    turning = [start @ planar(0.0, 0.0, 0.1 * i) for i in range(63)]
    path = turning + [turning[-1] @ planar(0.04 * i, 0.0, 0.0) for i in range(1, 12)]
    estimates = tracked(again, path, dead_reckoning(path, drift=0.0), ELSEWHERE)
    states = [estimate.tracking for estimate in estimates]
    known = states.index(Tracking.RELOCALISED)
    assert states[:known] == [Tracking.LOST] * known
    assert set(states[known + 1 :]) == {Tracking.TRACKING}
    assert estimates[known].is_keyframe
    assert len(again.keyframe_poses()) > before + 1, "the robot does not map on"
    for estimate, T_map_base in zip(estimates[known:], path[known:], strict=True):
        assert_at(estimate, invert(Ts_map_base[0]) @ T_map_base, 0.1, 0.06)


@pytest.mark.parametrize(("walls", "found"), [(WALLS, True), (ELSEWHERE, False)])
def test_where_obstacles_are_the_same_from_two_sides_one_image_decides(
    whole_lap: Lap, walls: int, found: bool
) -> None:
    slam, _, Ts_map_base = whole_lap
    never_alone = RelocalisationConfig(single_frame_inliers=10_000, agreement=1e-9)
    again = resumed(slam, obstacles(closed=True), SlamConfig(relocalisation=never_alone))
    turning = [Ts_map_base[20] @ planar(0.0, 0.0, 0.1 * i) for i in range(63)]
    estimates = tracked(again, turning, dead_reckoning(turning, drift=0.0), walls)
    assert (Tracking.RELOCALISED in [estimate.tracking for estimate in estimates]) is found
    if found:
        assert_at(estimates[-1], invert(Ts_map_base[0]) @ turning[-1], 0.05, np.pi)


def test_a_place_that_images_suggest_is_refused_when_obstacles_rule_it_out(whole_lap: Lap) -> None:
    slam, _, Ts_map_base = whole_lap
    seen = Ts_map_base[12:20]
    for size, recognised in ((1.0, True), (1.5, False)):
        estimates = tracked(resumed(slam, obstacles(size)), seen, dead_reckoning(seen))
        states = [estimate.tracking for estimate in estimates]
        assert (Tracking.RELOCALISED in states) is recognised


def test_a_robot_that_is_lifted_is_lost_until_it_stands_where_it_knows_the_place() -> None:
    Ts_map_base = lap(100)[:40]
    slam, _ = follow(Ts_map_base, dead_reckoning(Ts_map_base))
    T_odom_base = dead_reckoning(Ts_map_base)[-1]
    before = set(slam.keyframe_poses())
    lifted = [slam.lift(8.0 + 0.2 * i) for i in range(5)]
    assert {estimate.tracking for estimate in lifted} == {Tracking.LOST}
    put_down = Ts_map_base[8] @ planar(0.03, -0.05, 0.05)
    frames = [render(put_down, 9.2 + 0.2 * i) for i in range(3)]
    estimates = [slam.track(frame, T_odom_base) for frame in frames]
    assert Tracking.RELOCALISED in [estimate.tracking for estimate in estimates[:2]]
    off = invert(invert(Ts_map_base[0]) @ put_down @ T_BASE_CAM) @ estimates[-1].T_map_cam
    assert np.linalg.norm(off[:3, 3]) < 0.05
    assert set(slam.keyframe_poses()) == before
