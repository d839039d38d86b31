"""Pose estimation in a textured box room, ray cast, with known truth."""

import json
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from mapping.anchors import Keyframes
from mapping.slam import Slam, SlamConfig
from mapping.trajectory_error import absolute_trajectory_error
from mapping.tum import read_trajectory
from vizbot.core.geometry import (
    R_BASE_CAM,
    camera_mount,
    invert,
    planar,
    rotation_angle,
    transform,
    yaw_of,
)
from vizbot.core.types import (
    SE3,
    ImuSamples,
    Intrinsics,
    PoseEstimate,
    RGBDFrame,
    Tracking,
)

CAMERA = Intrinsics(320, 240, 307.0, 307.0, 159.5, 119.5)
T_BASE_CAM = camera_mount(height=0.6, forward=0.1, tilt=0.1)
ROOM = np.array([[-2.5, -2.0, 0.0], [2.5, 2.0, 2.4]])
TEXELS = 150.0
OFFICE = Path(__file__).parents[2] / "shared" / "data" / "hololens_office"


def textures(seed: int) -> list[NDArray[np.uint8]]:
    """Six walls of coloured rectangles on noise: lower and upper along x, then y, then z."""
    rng = np.random.default_rng(seed)
    walls = []
    for _ in range(6):
        wall = rng.normal(150, 12, (64, 64, 3))
        wall = cv2.resize(wall, (800, 800), interpolation=cv2.INTER_CUBIC)
        for _ in range(150):
            (u, v), (w, h) = rng.integers(0, 780, 2), rng.integers(8, 60, 2)
            wall[v : v + h, u : u + w] = rng.uniform(40, 230, 3)
        walls.append(cv2.GaussianBlur(np.clip(wall, 0, 255), (0, 0), 1.0).astype(np.uint8))
    return walls


WALLS, ELSEWHERE = textures(7), textures(8)


def render(
    T_map_base: SE3,
    stamp: float,
    *,
    dark: bool = False,
    walls: Sequence[NDArray[np.uint8]] = WALLS,
) -> RGBDFrame:
    """What the camera sees, with noise of sensor and depth that a stamp repeats."""
    rng = np.random.default_rng(round(stamp * 1000))
    T_map_cam = T_map_base @ T_BASE_CAM
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = np.stack(
        ((u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)), axis=-1
    )
    directions = rays @ T_map_cam[:3, :3].T
    with np.errstate(divide="ignore"):
        reach = (np.where(directions > 0, ROOM[1], ROOM[0]) - T_map_cam[:3, 3]) / directions
    axis = reach.argmin(axis=-1)
    depth = reach.min(axis=-1)
    points = transform(T_map_cam, rays * depth[..., None]) - ROOM[0]
    side = np.take_along_axis(directions > 0, axis[..., None], axis=-1)[..., 0]
    rgb = np.zeros((*depth.shape, 3), np.float64)
    for wall, texture in enumerate(walls):
        on = axis * 2 + side == wall
        a, b = (
            points[..., k].astype(np.float32) * np.float32(TEXELS)
            for k in range(3)
            if k != wall // 2
        )
        looked_up = cv2.remap(texture, a, b, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        rgb[on] = looked_up[on]
    if dark:
        rgb[:] = 3.0
    rgb += rng.normal(0, 3, rgb.shape)
    depth = depth + rng.normal(0, 1, depth.shape) * 0.003 * depth**2
    depth[rng.random(depth.shape) < 0.05] = 0.0
    return RGBDFrame(
        stamp,
        np.clip(rgb, 0, 255).astype(np.uint8),
        depth.astype(np.float32),
        CAMERA,
        ImuSamples.none(),
    )


def lap(frames: int) -> list[SE3]:
    """T_map_base of one loop by 5 Hz frames, up to 0.3 m/s, back to the start."""
    angles = np.linspace(0, 2 * np.pi, frames)
    return [planar(0.9 * np.sin(a), 0.9 * (1 - np.cos(a)) - 0.9, a) for a in angles]


def dead_reckoning(
    Ts_map_base: Sequence[SE3], scale: float = 1.02, drift: float = 0.02
) -> list[SE3]:
    """Wheels that roll `scale` too far and turn by a fraction `drift` too far."""
    Ts_odom_base = [np.eye(4)]
    for T_map_last, T_map_base in pairwise(Ts_map_base):
        step = invert(T_map_last) @ T_map_base
        turn = np.arctan2(step[1, 0], step[0, 0]) * (1 + drift)
        Ts_odom_base.append(Ts_odom_base[-1] @ planar(step[0, 3] * scale, step[1, 3] * scale, turn))
    return Ts_odom_base


def follow(
    Ts_map_base: Sequence[SE3],
    Ts_odom_base: Sequence[SE3] | None,
    dark: range = range(0),
) -> tuple[Slam, list[PoseEstimate]]:
    """Poses estimated along a path, in the dark for some of its frames."""
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    estimates = [
        slam.track(
            render(T_map_base, 0.2 * i, dark=i in dark),
            None if Ts_odom_base is None else Ts_odom_base[i],
        )
        for i, T_map_base in enumerate(Ts_map_base)
    ]
    return slam, estimates


def errors(estimates: Sequence[PoseEstimate], Ts_map_base: Sequence[SE3]) -> NDArray[np.float64]:
    """(N, 2) distance [m] and angle [rad] between estimate and truth, from the common start."""
    T_map_start = Ts_map_base[0]
    rows = []
    for estimate, T_map_base in zip(estimates, Ts_map_base, strict=True):
        T_true = invert(T_map_start) @ T_map_base @ T_BASE_CAM
        T = invert(T_true) @ estimate.T_map_cam
        rows.append((np.linalg.norm(T[:3, 3]), rotation_angle(T)))
    return np.array(rows)


@pytest.fixture(scope="module")
def whole_lap() -> tuple[Slam, list[PoseEstimate], list[SE3]]:
    Ts_map_base = lap(100)
    return *follow(Ts_map_base, dead_reckoning(Ts_map_base)), Ts_map_base


def test_the_map_starts_where_the_base_started() -> None:
    _, estimates = follow(lap(100)[:1], None)
    assert np.allclose(estimates[0].T_map_cam, T_BASE_CAM, atol=1e-12)
    assert estimates[0].is_keyframe


def test_a_lap_with_wheels_ends_where_it_began(
    whole_lap: tuple[Slam, list[PoseEstimate], list[SE3]],
) -> None:
    _, estimates, Ts_map_base = whole_lap
    wheels = dead_reckoning(Ts_map_base)[-1]
    off = errors(estimates, Ts_map_base)
    assert all(estimate.tracking is Tracking.TRACKING for estimate in estimates)
    assert off[:, 0].max() < 0.05
    assert off[:, 1].max() < 0.03
    assert np.linalg.norm(wheels[:2, 3]) > 0.05, "wheels alone would do as well"


def test_keyframes_are_announced_and_frames_hang_on_them(
    whole_lap: tuple[Slam, list[PoseEstimate], list[SE3]],
) -> None:
    slam, estimates, _ = whole_lap
    announced = [estimate.keyframe for estimate in estimates if estimate.is_keyframe]
    assert announced == sorted(slam.keyframe_poses())
    for estimate in estimates:
        final = slam.keyframe_poses()[estimate.keyframe] @ estimate.T_keyframe_cam
        assert np.allclose(final, estimate.T_map_cam, atol=0.05)


def test_the_same_frames_give_the_same_poses_bit_for_bit(
    whole_lap: tuple[Slam, list[PoseEstimate], list[SE3]],
) -> None:
    _, estimates, Ts_map_base = whole_lap
    _, again = follow(Ts_map_base[:40], dead_reckoning(Ts_map_base)[:40])
    for first, second in zip(estimates, again, strict=False):
        assert np.array_equal(first.T_map_cam, second.T_map_cam)


def test_images_alone_follow_a_lap() -> None:
    Ts_map_base = lap(100)
    _, estimates = follow(Ts_map_base, None)
    assert all(estimate.tracking is Tracking.TRACKING for estimate in estimates)
    assert errors(estimates, Ts_map_base)[:, 0].max() < 0.1


def test_fast_turns_on_the_spot_are_followed() -> None:
    Ts_map_base = [planar(0, 0, 0.24 * i) for i in range(27)]
    _, estimates = follow(Ts_map_base, dead_reckoning(Ts_map_base, drift=0.1))
    assert errors(estimates, Ts_map_base)[:, 1].max() < 0.03


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


def test_without_wheels_darkness_is_lost_and_light_is_found_again() -> None:
    Ts_map_base = lap(100)[:20] + [lap(100)[19]] * 10 + lap(100)[19:30]
    _, estimates = follow(Ts_map_base, None, dark=range(20, 28))
    states = [estimate.tracking for estimate in estimates]
    assert states[20:28] == [Tracking.LOST] * 8
    assert states[28:] == [Tracking.RELOCALISED] + [Tracking.TRACKING] * 12
    assert errors(estimates, Ts_map_base)[28:, 0].max() < 0.05


def with_gyro(frame: RGBDFrame, turn: float) -> RGBDFrame:
    """The frame of a camera that turned by `turn` [rad] about the base's z axis in 0.2 s."""
    stamps = frame.stamp - 0.2 + np.arange(1, 41) * 0.005
    rates = np.tile(turn / 0.2 * T_BASE_CAM[2, :3], (40, 1))
    return replace(frame, imu=ImuSamples(stamps, rates, np.zeros(0), np.zeros((0, 3))))


@pytest.mark.parametrize("gyro", [False, True])
def test_in_the_dark_the_gyroscope_keeps_the_heading_of_wheels_that_slip(gyro: bool) -> None:
    Ts_map_base = [np.eye(4)] * 8 + [planar(0, 0, 0.1 * i) for i in range(30)]
    Ts_odom_base = dead_reckoning(Ts_map_base, drift=0.1)
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    turns = [0.0, *(yaw_of(invert(a) @ b) for a, b in pairwise(Ts_map_base))]
    estimates = []
    for i, turn in enumerate(turns):
        frame = render(Ts_map_base[i], 0.2 * i, dark=i >= 8)
        frame = with_gyro(frame, turn) if gyro else frame
        estimates.append(slam.track(frame, Ts_odom_base[i]))
    assert estimates[-1].tracking is Tracking.WHEELS_ONLY
    wrong = errors(estimates, Ts_map_base)[-1, 1]
    assert wrong < 0.02 if gyro else wrong > 0.2


def test_images_that_stand_still_do_not_stop_a_robot_that_turns() -> None:
    Ts_map_base = [lap(100)[0]] * 8 + lap(100)[:40]
    stuck = range(20, 30)
    Ts_odom_base = dead_reckoning(Ts_map_base)
    turns = [0.0, *(yaw_of(invert(a) @ b) for a, b in pairwise(Ts_map_base))]
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    estimates = []
    for i, turn in enumerate(turns):
        seen_from = Ts_map_base[stuck[0] if i in stuck else i]
        frame = with_gyro(render(seen_from, 0.2 * i), turn)
        estimates.append(slam.track(frame, Ts_odom_base[i]))
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


def resumed(slam: Slam) -> Slam:
    """A new estimator that begins in the map of another."""
    poses = slam.keyframe_poses()
    again = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    ids = np.array(sorted(poses), np.int32)
    again.know(Keyframes(ids, np.zeros(len(ids)), np.array([poses[i] for i in ids])), slam.views())
    return again


@pytest.mark.parametrize("start", [12, 50, 83])
@pytest.mark.parametrize("wheels", [False, True])
def test_in_a_saved_map_a_camera_recognises_where_it_is(
    whole_lap: tuple[Slam, list[PoseEstimate], list[SE3]], start: int, wheels: bool
) -> None:
    slam, _, Ts_map_base = whole_lap
    again, seen = resumed(slam), Ts_map_base[start : start + 12]
    aside = [T @ planar(0.05, 0.1, 0.1) for T in seen]
    Ts_odom_base = dead_reckoning(aside) if wheels else [None] * len(aside)
    estimates = [
        again.track(render(T, 100 + 0.2 * i), Ts_odom_base[i]) for i, T in enumerate(aside)
    ]
    states = [estimate.tracking for estimate in estimates]
    known = states.index(Tracking.RELOCALISED)
    assert known <= 1
    assert states[known + 1 :] == [Tracking.TRACKING] * (11 - known)
    for estimate, T_map_base in zip(estimates[known:], aside[known:], strict=True):
        off = invert(invert(Ts_map_base[0]) @ T_map_base @ T_BASE_CAM) @ estimate.T_map_cam
        assert np.linalg.norm(off[:3, 3]) < 0.05
        assert rotation_angle(off) < 0.03


def test_a_room_that_the_saved_map_does_not_hold_is_not_recognised(
    whole_lap: tuple[Slam, list[PoseEstimate], list[SE3]],
) -> None:
    again = resumed(whole_lap[0])
    before = set(again.keyframe_poses())
    frames = (render(T, 0.2 * i, walls=ELSEWHERE) for i, T in enumerate(lap(100)[::5]))
    assert all(again.track(frame, None).tracking is Tracking.LOST for frame in frames)
    assert set(again.keyframe_poses()) == before


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


@pytest.mark.long
@pytest.mark.skipif(not OFFICE.exists(), reason=f"needs the recording {OFFICE}")
@pytest.mark.parametrize("stride", [1, 2])
def test_a_walk_through_an_office_is_followed_within_30_cm(stride: int) -> None:
    camera = json.loads((OFFICE / "camera.json").read_text())
    scale = camera["depth_scale"]
    intrinsics = Intrinsics(*(camera[k] for k in ("width", "height", "fx", "fy", "cx", "cy")))
    T_base_cam = np.eye(4)
    T_base_cam[:3, :3] = R_BASE_CAM
    slam = Slam(intrinsics, T_base_cam, SlamConfig())
    estimates = []
    for line in (OFFICE / "associations.txt").read_text().splitlines()[::stride]:
        stamp, rgb, _, depth = line.split()
        frame = RGBDFrame(
            float(stamp),
            cv2.cvtColor(cv2.imread(str(OFFICE / rgb)), cv2.COLOR_BGR2RGB),
            (cv2.imread(str(OFFICE / depth), cv2.IMREAD_UNCHANGED) / scale).astype(np.float32),
            intrinsics,
            ImuSamples.none(),
        )
        estimates.append(slam.track(frame, None))
    online = np.array([estimate.T_map_cam for estimate in estimates])
    stamps = np.array([estimate.stamp for estimate in estimates])
    assert all(estimate.tracking is Tracking.TRACKING for estimate in estimates)
    truth = read_trajectory(OFFICE / "groundtruth.txt")
    assert absolute_trajectory_error(stamps, online, *truth) < 0.30
