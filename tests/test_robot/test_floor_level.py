"""The floor below a camera without a base."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drivers.tum_sequence import RecordedSequence
from mapping.calibration.floor_level import GRAVITY, estimate_mount
from tests.helpers.checkout import OFFICE_WALK
from vizbot.core.geometry import R_BASE_CAM, camera_mount
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

INTRINSICS = Intrinsics(160, 120, 140.0, 140.0, 79.5, 59.5)


def mount(height: float, pitch: float, roll: float) -> np.ndarray:
    """T_base_cam, `pitch` downwards; no yaw."""
    T_base_cam = np.eye(4)
    T_base_cam[:3, :3] = (
        Rotation.from_euler("y", pitch).as_matrix()
        @ Rotation.from_euler("x", roll).as_matrix()
        @ R_BASE_CAM
    )
    T_base_cam[2, 3] = height
    return T_base_cam


def frame_of(T_base_cam, heights, noise=0.0, accel=None) -> RGBDFrame:
    """Floor at the first of `heights`, a wall 4 m ahead, and, for a second, a desk to the left."""
    v, u = np.mgrid[:120, :160]
    rays = np.stack([(u - 79.5) / 140, (v - 59.5) / 140, np.ones((120, 160))], -1)
    rays = rays @ T_base_cam[:3, :3].T
    down = np.where(rays[..., 2] < -1e-6, rays[..., 2], -1e-6)
    depth = np.where(rays[..., 0] > 1e-6, 4.0 / np.maximum(rays[..., 0], 1e-6), np.inf)
    for i, height in enumerate(heights):
        reaches = (height - T_base_cam[2, 3]) / down
        desk = (rays[..., 1] * reaches > -0.1) & (rays[..., 0] * reaches < 2.5)
        depth = np.where(desk | (i == 0), np.minimum(depth, reaches), depth)
    depth += noise * depth**2 * np.random.default_rng(0).standard_normal(depth.shape)
    depth = np.where(np.isfinite(depth) & (depth < 10), depth, 0.0).astype(np.float32)
    imu = ImuSamples.none()
    if accel is not None:
        imu = ImuSamples(np.zeros(0), np.zeros((0, 3)), np.arange(len(accel)) / 100, accel)
    return RGBDFrame(0.0, np.zeros((120, 160, 3), np.uint8), depth, INTRINSICS, imu)


def angle_between(a, b) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@settings(max_examples=25)
@given(st.floats(0.4, 1.8), st.floats(0.35, 0.7), st.floats(-0.25, 0.25))
def test_the_floor_gives_height_roll_and_pitch(height, pitch, roll):
    truth = mount(height, pitch, roll)
    found = estimate_mount(frame_of(truth, [0.0], noise=0.002))
    assert found is not None
    assert found[2, 3] == pytest.approx(height, abs=0.03)
    assert angle_between(found[2, :3], truth[2, :3]) < 1.0
    np.testing.assert_allclose(found[:3, :3] @ found[:3, :3].T, np.eye(3), atol=1e-9)
    assert found[0, 2] > 0 and found[1, 2] == pytest.approx(0.0, abs=1e-9)
    assert (found[:2, 3] == 0).all()


@pytest.mark.parametrize(
    ("height", "tilt", "heights", "noise", "accel"),
    [
        (1.5, 0.6, [0.0, 0.75], 0.002, None),
        (0.6, 0.5, [0.0], 0.0, np.tile([14.0, 0.0, 0.0], (10, 1))),
    ],
    ids=["a larger desk", "a shaken accelerometer"],
)
def test_the_floor_wins_over_a_larger_desk_and_a_shaken_accelerometer(
    height, tilt, heights, noise, accel
):
    found = estimate_mount(frame_of(camera_mount(height, 0.0, tilt), heights, noise, accel))
    assert found is not None
    assert found[2, 3] == pytest.approx(height, abs=0.03)


@pytest.mark.parametrize("why", ["a wall", "no depth", "an accelerometer across the only plane"])
def test_where_no_level_plane_is_seen_there_is_no_floor(why):
    truth = camera_mount(1.5, 0.0, 0.0 if why == "a wall" else 0.5)
    across = np.tile(GRAVITY * truth[1, :3], (10, 1)) if "accelerometer" in why else None
    frame = frame_of(truth, [-50.0 if why == "a wall" else 0.0], accel=across)
    if why == "no depth":
        frame.depth[:] = 0.0
    assert estimate_mount(frame) is None


def test_at_rest_the_accelerometer_says_which_way_is_up():
    truth = mount(0.6, 0.9, 0.5)
    up = truth[2, :3]
    rng = np.random.default_rng(0)
    accel = GRAVITY * up + 0.05 * rng.standard_normal((40, 3))
    found = estimate_mount(frame_of(truth, [0.0], noise=0.004, accel=accel))
    assert found is not None
    assert angle_between(found[2, :3], up) < 0.2
    assert found[2, 3] == pytest.approx(0.6, abs=0.03)


@pytest.mark.skipif(not OFFICE_WALK.is_dir(), reason="the office recording is not here")
@pytest.mark.parametrize("index", [0, 9, 30, 45, 60])
def test_a_recorded_walk_is_at_head_height_with_gravity_along_one_axis(index):
    with RecordedSequence(OFFICE_WALK) as camera:
        *_, frame = (camera.read() for _ in range(index + 1))
    found = estimate_mount(frame)
    assert found is not None
    assert 1.5 < found[2, 3] < 1.8
    truth = np.loadtxt(OFFICE_WALK / "groundtruth.txt")[index]
    up = Rotation.from_quat(truth[4:]).as_matrix() @ found[2, :3]
    assert angle_between(up, np.array([0.0, 1.0, 0.0])) < 2.0
