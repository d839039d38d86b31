import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from vizbot.core import geometry
from vizbot.core.types import Intrinsics, OccupancyGrid

metres = st.floats(-100.0, 100.0)
angles = st.floats(-np.pi, np.pi)
seeds = st.integers(0, 2**32 - 1)


def random_transform(seed):
    rng = np.random.default_rng(seed)
    T = np.eye(4)
    T[:3, :3] = Rotation.random(rng=rng).as_matrix()
    T[:3, 3] = rng.normal(size=3) * 10
    return T


@given(seeds)
def test_a_transform_and_its_inverse_cancel(seed):
    T = random_transform(seed)
    np.testing.assert_allclose(T @ geometry.invert(T), np.eye(4), atol=1e-9)


@given(seeds, seeds)
def test_transforming_twice_is_transforming_by_the_product(seed_a, seed_b):
    T_a_b, T_b_c = random_transform(seed_a), random_transform(seed_b)
    points = np.random.default_rng(seed_a).normal(size=(5, 3))
    np.testing.assert_allclose(
        geometry.transform(T_a_b, geometry.transform(T_b_c, points)),
        geometry.transform(T_a_b @ T_b_c, points),
        atol=1e-9,
    )


@given(seeds)
def test_a_quaternion_brings_its_rotation_back(seed):
    T = random_transform(seed)
    back = geometry.from_quat_xyzw(T[:3, 3], geometry.to_quat_xyzw(T))
    np.testing.assert_allclose(back, T, atol=1e-9)
    assert geometry.to_quat_xyzw(T)[3] >= 0.0


@given(metres, metres, angles)
def test_a_planar_transform_has_the_yaw_it_was_made_with(x, y, yaw):
    T = geometry.planar(x, y, yaw)
    assert abs(geometry.wrap_angle(geometry.yaw_of(T) - yaw)) < 1e-9
    np.testing.assert_allclose(T[:2, 3], [x, y])


@given(st.floats(-1000.0, 1000.0))
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle):
    wrapped = geometry.wrap_angle(angle)
    assert -np.pi <= wrapped < np.pi
    np.testing.assert_allclose(
        [np.cos(wrapped), np.sin(wrapped)], [np.cos(angle), np.sin(angle)], atol=1e-9
    )


def test_a_tilted_camera_sees_the_floor_ahead_where_trigonometry_says():
    tilt, height = 0.3, 0.6
    T_base_cam = geometry.camera_mount(height, 0.1, tilt)
    along_axis = geometry.transform(T_base_cam, np.array([0.0, 0.0, height / np.sin(tilt)]))
    np.testing.assert_allclose(along_axis, [0.1 + height / np.tan(tilt), 0.0, 0.0], atol=1e-12)
    right_of_camera = geometry.transform(T_base_cam, np.array([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(right_of_camera, [0.1, -1.0, height], atol=1e-12)


def test_back_projection_inverts_the_pinhole_projection():
    camera = Intrinsics(8, 6, 10.0, 12.0, 3.5, 2.5)
    depth = np.random.default_rng(0).uniform(0.5, 3.0, (6, 8)).astype(np.float32)
    points = geometry.back_project(depth, camera)
    projected = points @ camera.K.T
    v, u = np.mgrid[:6, :8]
    np.testing.assert_allclose(projected[..., 0] / projected[..., 2], u, atol=1e-5)
    np.testing.assert_allclose(projected[..., 1] / projected[..., 2], v, atol=1e-5)
    np.testing.assert_array_equal(points[..., 2], depth)


@given(st.integers(-50, 50), st.integers(-50, 50))
def test_a_cell_contains_its_own_centre(row, col):
    grid = OccupancyGrid(np.full((4, 7), 0.5, np.float32), 0.05, np.array([-1.3, 2.1]))
    cell = np.array([row, col])
    np.testing.assert_array_equal(grid.to_cells(grid.to_xy(cell)), cell)
    assert bool(grid.contains(cell)) == (0 <= row < 4 and 0 <= col < 7)


def test_rows_of_a_grid_grow_with_y_and_columns_with_x():
    grid = OccupancyGrid(np.full((4, 7), 0.5, np.float32), 0.5, np.array([0.0, 0.0]))
    np.testing.assert_array_equal(grid.to_cells(np.array([3.2, 0.6])), [1, 6])
