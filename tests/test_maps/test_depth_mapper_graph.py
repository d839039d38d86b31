"""The obstacle map follows the pose graph."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mapping.occupancy.config import DepthMapperConfig
from mapping.occupancy.depth_mapper import DepthMapper
from tests.helpers.boxes import INTRINSICS, LOW_BOX, MOUNT, depth_of, occupied_xy, see
from vizbot.core.geometry import invert, planar


@pytest.mark.slow
@settings(max_examples=10)
@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(-np.pi, np.pi))
def test_the_map_moves_with_the_graph(x, y, yaw):
    T_new_old = planar(x, y, yaw)
    followed, expected = DepthMapper(DepthMapperConfig()), DepthMapper(DepthMapperConfig())
    poses = {}
    for i in range(3):
        T_map_base = planar(-0.5 + 0.2 * i, 0.0, 0.4 * i)
        see(followed, T_map_base, [LOW_BOX], keyframe=i, frames=2)
        see(expected, T_new_old @ T_map_base, keyframe=i)
        poses[i] = T_new_old @ T_map_base @ MOUNT
    followed.mark_obstacle(planar(0.0, 1.0, 0.0), np.array([[0.22, 0.02]]))
    before = occupied_xy(followed.grid())
    moved_far = np.hypot(x, y) > 3 or abs(yaw) > 0.01
    assert followed.follow(poses) or not moved_far
    after = occupied_xy(followed.grid())
    wanted = before @ T_new_old[:2, :2].T + T_new_old[:2, 3]
    apart = np.linalg.norm(after[:, None] - wanted[None], axis=-1)
    assert apart.min(axis=0).max() < 0.09
    assert apart.min(axis=1).max() < 0.09


def test_a_graph_that_hardly_moves_changes_nothing():
    mapper = DepthMapper(DepthMapperConfig())
    see(mapper, planar(0.0, 0.0, 0.0), [LOW_BOX], frames=2)
    before = mapper.grid()
    assert not mapper.follow({0: planar(0.02, 0.0, 0.005) @ MOUNT, 7: np.eye(4)})
    np.testing.assert_array_equal(mapper.grid().occupancy, before.occupancy)


def test_a_keyframe_that_moves_is_painted_as_if_it_had_always_been_there():
    followed, expected = DepthMapper(DepthMapperConfig()), DepthMapper(DepthMapperConfig())
    places = [planar(-1.5, 0.0, 0.3), planar(1.0, 0.5, -2.0), planar(0.0, -1.0, 1.5)]
    moved = {1: planar(0.12, -0.07, 0.02) @ places[1] @ MOUNT}
    for keyframe, T_map_base in enumerate(places):
        T_map_cam = T_map_base @ MOUNT
        depth = depth_of(T_map_cam, [LOW_BOX])
        followed.integrate(keyframe, np.eye(4), T_map_cam, depth, INTRINSICS)
        T_moved = moved.get(keyframe, T_map_cam)
        expected.integrate(keyframe, np.eye(4), T_moved, depth, INTRINSICS)
    assert followed.follow(moved)
    a, b = followed.grid(), expected.grid()
    cells = np.argwhere(np.abs(b.occupancy - 0.5) > 1e-6)
    there = a.to_cells(b.to_xy(cells))
    np.testing.assert_allclose(a.occupancy[tuple(there.T)], b.occupancy[tuple(cells.T)], atol=1e-6)
    assert np.count_nonzero(np.abs(a.occupancy - 0.5) > 1e-6) == len(cells)


def test_what_lies_far_from_the_keyframes_that_moved_stays_as_it_is():
    mapper = DepthMapper(DepthMapperConfig())
    for keyframe, x in enumerate((0.0, 30.0)):
        T_map_cam = planar(0.0, 0.0, 0.0) @ MOUNT
        depth = depth_of(T_map_cam, [LOW_BOX])
        T_map_cam = planar(x, 0.0, 0.0) @ T_map_cam
        for _ in range(3):
            mapper.integrate(keyframe, np.eye(4), T_map_cam, depth, INTRINSICS)
    before = mapper.grid()
    assert mapper.follow({1: planar(30.4, 0.0, 0.0) @ MOUNT})
    after = mapper.grid()
    near = before.to_xy(np.argwhere(before.occupancy != 0.5))
    near = near[near[:, 0] < 10.0]
    a, b = after.to_cells(near), before.to_cells(near)
    assert len(near) > 1000
    np.testing.assert_array_equal(after.occupancy[tuple(a.T)], before.occupancy[tuple(b.T)])
    box = occupied_xy(after) - [30.0, 0.0]
    box = box[(box[:, 0] > 0) & (np.abs(box[:, 1]) < 0.2)]
    assert box[:, 0].min() == pytest.approx(1.4, abs=0.06)


def test_a_robot_that_drives_up_and_down_keeps_no_more_than_one_that_did_so_once():
    mapper = DepthMapper(DepthMapperConfig())
    kept = []
    for _ in range(3):
        for x in np.arange(0.0, 0.6, 0.1):
            T_map_base = planar(x, 0.0, 0.0)
            T_map_cam = T_map_base @ MOUNT
            depth = depth_of(T_map_cam, [LOW_BOX])
            mapper.integrate(0, invert(MOUNT) @ T_map_cam, T_map_cam, depth, INTRINSICS)
            mapper.mark_free(T_map_base, 0.17)
        kept.append(mapper.scans)
    assert kept == [6, 6, 6]


def test_painting_again_gives_the_same_map_while_the_robot_stands():
    mapper = DepthMapper(DepthMapperConfig())
    see(mapper, planar(0.0, 0.0, 0.0), [LOW_BOX], frames=8)
    before = mapper.grid()
    there, back = planar(0.5, 0.0, 0.0) @ MOUNT, MOUNT
    assert mapper.follow({0: there})
    assert mapper.follow({0: back})
    np.testing.assert_allclose(mapper.grid().occupancy, before.occupancy, atol=1e-5)
