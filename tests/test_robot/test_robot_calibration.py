"""The mount and the wheels from motions of the camera alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mapping.calibration.robot_calibration import (
    axle_in_camera,
    driven_distance,
    floor_plane,
    mount_from_motions,
    turned_about,
)
from vizbot.core.geometry import camera_mount, invert, mount_angles, planar

MOUNT = camera_mount(0.6, 0.05, 0.15)


def seen(T_base_cam, motions, noise=0.0, seed=0):
    """Camera poses in the first one while the base is at `motions`."""
    rng = np.random.default_rng(seed)
    poses = []
    for T_first_now in motions:
        T = invert(T_base_cam) @ T_first_now @ T_base_cam
        off = np.eye(4)
        off[:3, :3] = Rotation.from_rotvec(noise * rng.standard_normal(3)).as_matrix()
        off[:3, 3] = noise * rng.standard_normal(3)
        poses.append(T @ off)
    return np.array(poses)


def spun(T_base_cam, angles, noise=0.0):
    """Camera poses in the first one while the base turns to these angles."""
    return seen(T_base_cam, [planar(0, 0, angle) for angle in angles], noise)


def floor_points(T_base_cam):
    """Points of a floor, and of a chest 0.4 m high on it, in `cam`."""
    x, y = np.meshgrid(np.linspace(0.5, 3.0, 30), np.linspace(-1.0, 1.0, 30))
    z = np.where((x > 2.0) & (y > 0.3), 0.4, 0.0)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return (points - T_base_cam[:3, 3]) @ T_base_cam[:3, :3]


angles = st.floats(-0.4, 0.4)
offsets = st.floats(-0.15, 0.15)


@pytest.mark.slow
@given(st.floats(0.2, 1.4), offsets, offsets, angles, angles, angles)
def test_a_mount_is_found_from_a_spin_and_a_straight_line(height, forward, left, yaw, tilt, roll):
    mount = camera_mount(height, forward, tilt, left, yaw, roll)
    spin = spun(mount, np.linspace(0.1, 12.0, 60))
    arc = planar(1.5, 0.05, 2 * np.arctan2(0.05, 1.5))
    there = seen(mount, [np.eye(4), arc])
    back = seen(mount, [arc, arc @ planar(-1.5, 0.05, -2 * np.arctan2(0.05, 1.5))])
    found = mount_from_motions(spin, there, back, [mount] * 3, [floor_points(mount)] * 3)
    np.testing.assert_allclose(found.T_base_cam, mount, atol=1e-6)
    assert max(found.spin_residual, found.floor_residual, found.height_residual) < 1e-6
    assert found.yaw_residual < 1e-6
    assert mount_angles(mount) == pytest.approx((yaw, tilt, roll), abs=1e-9)


def test_noise_is_averaged_and_shows_in_the_residual():
    mount = camera_mount(0.6, 0.05, 0.15, left=0.02, yaw=0.03)
    spin = spun(mount, np.linspace(0.1, 12.0, 200), noise=0.003)
    way = [planar(x, 0.0, 0.0) for x in np.linspace(0.0, 1.5, 40)]
    ahead, back = seen(mount, way, noise=0.003), seen(mount, way[::-1], noise=0.003)
    found = mount_from_motions(spin, ahead, back, [mount], [floor_points(mount)])
    assert 0.002 < found.spin_residual < 0.01
    assert found.T_base_cam[:3, 3] == pytest.approx(mount[:3, 3], abs=0.002)
    assert mount_angles(found.T_base_cam) == pytest.approx(mount_angles(mount), abs=0.006)


def test_headings_that_differ_are_halved_and_show_in_the_residual():
    spin = spun(MOUNT, np.linspace(0.1, 12.0, 60))
    aside = 1.5 * np.tan(0.02)
    ahead = seen(MOUNT, [np.eye(4), planar(1.5, aside, 0.0)])
    back = seen(MOUNT, [np.eye(4), planar(-1.5, aside, 0.0)])
    found = mount_from_motions(spin, ahead, back, [MOUNT], [floor_points(MOUNT)])
    np.testing.assert_allclose(found.T_base_cam, MOUNT, atol=1e-6)
    assert found.yaw_residual == pytest.approx(0.02, abs=1e-4)


@pytest.mark.parametrize(
    ("angles", "up"), [(-np.linspace(0.1, 6.0, 60), -1), (np.linspace(0.0, 4 * np.pi, 73), 1)]
)
def test_the_axis_points_up_in_turns_to_the_left_and_down_in_those_to_the_right(angles, up):
    _, axis, residual = axle_in_camera(spun(MOUNT, angles))
    assert axis == pytest.approx(up * MOUNT[2, :3], abs=1e-6)
    assert residual < 1e-6


@pytest.mark.parametrize("turn", [-13.0, -3.0, 0.1, 7.5, 12.6])
def test_whole_turns_are_counted_by_a_rough_figure(turn):
    [T] = seen(MOUNT, [planar(0, 0, turn)])
    assert turned_about(T, MOUNT[2, :3], 1.05 * turn) == pytest.approx(turn)


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_the_way_is_as_long_as_the_arc(turn):
    mount = camera_mount(0.6, 0.1, 0.15)
    radius = 1.2 / turn if turn else 0.0
    end = (
        planar(radius * np.sin(turn), radius * (1 - np.cos(turn)), turn)
        if turn
        else planar(1.2, 0, 0)
    )
    assert driven_distance(mount, seen(mount, [end])[0]) == pytest.approx(1.2)


def test_a_base_that_weaves_while_it_drives_does_not_turn_the_mount():
    mount = camera_mount(0.6, 0.05, 0.15, yaw=0.04)
    spin = spun(mount, np.linspace(0.1, 12.0, 60))
    rng = np.random.default_rng(3)
    lines = []
    for step in (0.05, -0.05):
        way = [np.eye(4)]
        for turn in 0.02 * rng.standard_normal(30):
            way.append(way[-1] @ planar(step, 0.5 * step * turn, turn))
        lines.append(seen(mount, way))
    found = mount_from_motions(spin, *lines, [mount], [floor_points(mount)])
    assert mount_angles(found.T_base_cam) == pytest.approx(mount_angles(mount), abs=1e-5)


def test_the_floor_is_not_tilted_by_what_lies_on_it():
    points = floor_points(MOUNT)
    T = invert(MOUNT)
    carpet = points[points[:, 2] > 1.8] + 0.015 * T[:3, 2]
    wrong = MOUNT[2, :3] + [0.0, 0.0, 0.008]
    for around in (points, np.concatenate([points, carpet])):
        normal, height = floor_plane(around, wrong / np.linalg.norm(wrong), 0.61)
        assert height == pytest.approx(0.6, abs=0.001)
        assert normal == pytest.approx(MOUNT[2, :3], abs=0.001)


def test_where_too_few_frames_show_the_floor_no_mount_is_found():
    spin = spun(MOUNT, np.linspace(0.1, 12.0, 60))
    line = seen(MOUNT, [np.eye(4), planar(1.5, 0.0, 0.0)])
    floors, points = [MOUNT] * 3, [floor_points(MOUNT), np.zeros((0, 3)), np.zeros((0, 3))]
    assert mount_from_motions(spin, line, line[::-1], floors, points, least_floors=2) is None
