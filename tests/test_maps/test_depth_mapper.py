"""The obstacle map from ray-cast rooms whose walls and boxes are known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapping.occupancy.config import DepthMapperConfig
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.occupancy.planar_scan import BEARINGS, bearing_bin, level_pose
from tests.helpers.boxes import (
    INTRINSICS,
    LOW_BOX,
    MOUNT,
    SHELF,
    at,
    depth_of,
    occupied_xy,
    see,
    stairwell,
)
from vizbot.core.geometry import camera_mount, invert, planar


@pytest.fixture
def mapper():
    return DepthMapper(DepthMapperConfig())


def test_a_map_of_nothing_is_unknown():
    grid = DepthMapper(DepthMapperConfig()).grid()
    assert grid.occupancy.size
    assert (grid.occupancy == 0.5).all()


@pytest.mark.parametrize("noisy", [False, True])
def test_walls_are_where_they_are_and_the_floor_before_them_is_free(mapper, noisy):
    rng = np.random.default_rng(0) if noisy else None
    for i in range(12):
        see(mapper, planar(-0.5, 0.3, i * np.pi / 6), keyframe=i, frames=6, rng=rng)
    grid = mapper.grid()
    walls = occupied_xy(grid)
    assert np.abs(np.abs(walls).max(axis=1) - 3.0).max() < (0.16 if noisy else 0.051)
    # Whatever wall is within range is drawn, without a gap.
    for side in np.arange(-2.8, 2.8, 0.1):
        for place in ((side, 3.0), (side, -3.0), (3.0, side), (-3.0, side)):
            if np.hypot(place[0] + 0.5, place[1] - 0.3) < 4.3:
                assert np.linalg.norm(walls - place, axis=1).min() < 0.11
    x, y = np.meshgrid(np.arange(-2.6, 2.6, 0.05), np.arange(-2.6, 2.6, 0.05))
    seen = np.hypot(x + 0.5, y - 0.3) > 1.3
    cells = grid.to_cells(np.stack([x[seen], y[seen]], axis=-1))
    assert (grid.occupancy[tuple(cells.T)] < 0.35).mean() > 0.99


def test_one_frame_alone_makes_no_obstacle(mapper):
    see(mapper, planar(0.0, 0.0, 0.0), [LOW_BOX])
    assert not len(occupied_xy(mapper.grid()))
    see(mapper, planar(0.0, 0.0, 0.0), [LOW_BOX])
    assert at(mapper.grid(), 1.01, 0.0) > 0.65


CUPBOARD = ((1.5, -0.5, 0.0), (1.9, 0.5, 1.8))


@pytest.mark.parametrize(
    ("x", "views", "free", "occupied"),
    [
        (0.0, [([CUPBOARD], 3)], 1.2, None),
        (-0.5, [([LOW_BOX], 3)], 2.6, 1.02),
        (-0.9, [([SHELF], 4)], 1.1, None),
        (-0.5, [([LOW_BOX], 30), ([], 15)], 1.02, None),
        (-0.5, [([], 50), ([LOW_BOX], 5)], None, 1.02),
    ],
    ids=["before a cupboard", "behind a low box", "beneath a shelf", "gone", "appears"],
)
def test_what_is_seen_is_free_or_occupied(mapper, x, views, free, occupied):
    for boxes, frames in views:
        see(mapper, planar(x, 0.0, 0.0), boxes, frames=frames)
    assert free is None or at(mapper.grid(), free, 0.0) < 0.35
    assert occupied is None or at(mapper.grid(), occupied, 0.0) > 0.65


def test_what_lies_behind_an_obstacle_stays_unknown(mapper):
    see(mapper, planar(0.0, 0.0, 0.0), [CUPBOARD], frames=3)
    assert at(mapper.grid(), 2.4, 0.0) == 0.5


def test_rays_above_a_low_obstacle_in_the_blind_zone_do_not_clear_it(mapper):
    see(mapper, planar(-0.5, 0.0, 0.0), [LOW_BOX], frames=5)
    before = at(mapper.grid(), 1.02, 0.0)
    assert before > 0.65
    see(mapper, planar(0.75, 0.0, 0.0), [LOW_BOX], frames=40)
    assert at(mapper.grid(), 1.02, 0.0) == before
    assert at(mapper.grid(), 2.6, 0.0) < 0.35


def test_a_floor_without_depth_is_passed_but_weakly(mapper):
    rows = np.arange(INTRINSICS.height)[:, None]

    def glossy(depth):
        height = 0.6 - depth * (np.sin(0.25) + np.cos(0.25) * (rows - 119.5) / 303.0)
        return height < 0.02

    see(mapper, planar(0.0, 0.0, 0.0), frames=3, holes=glossy)
    assert 0.35 < at(mapper.grid(), 2.0, 0.0) < 0.5
    see(mapper, planar(0.0, 0.0, 0.0), frames=10, holes=glossy)
    assert at(mapper.grid(), 2.0, 0.0) < 0.35
    assert at(mapper.grid(), 3.02, 0.0) > 0.65


def test_a_flying_pixel_between_two_surfaces_is_no_obstacle(mapper):
    depth = np.full((INTRINSICS.height, INTRINSICS.width), 2.0, np.float32)
    depth[:, 160:] = 3.0
    depth[:, 159:161] = 2.4, 2.7
    for _ in range(4):
        mapper.integrate(0, np.eye(4), camera_mount(1.2, 0.0, 0.0), depth, INTRINSICS)
    x = occupied_xy(mapper.grid())[:, 0]
    assert ((np.abs(x - 2.0) < 0.06) | (np.abs(x - 3.0) < 0.06)).all()
    assert (np.abs(x - 2.0) < 0.06).any() and (np.abs(x - 3.0) < 0.06).any()


def test_depth_never_clears_what_the_bumper_felt(mapper):
    see(mapper, planar(-0.5, 0.0, 0.0), frames=2)
    mapper.mark_obstacle(planar(1.0, 0.0, 0.0), np.array([[0.22, 0.02]]))
    see(mapper, planar(-0.5, 0.0, 0.0), frames=20)
    assert at(mapper.grid(), 1.22, 0.02) == 1.0
    assert at(mapper.grid(), 1.1, 0.0) < 0.35


def test_standing_on_a_contact_removes_it_and_standing_beside_it_does_not(mapper):
    mapper.mark_obstacle(planar(0.0, 0.0, 0.0), np.array([[0.22, 0.02]]))
    mapper.mark_free(planar(0.0, 0.0, 0.0), 0.175)
    assert at(mapper.grid(), 0.22, 0.02) == 1.0
    assert at(mapper.grid(), 0.0, 0.0) < 0.35
    mapper.mark_free(planar(0.15, 0.0, 0.0), 0.175)
    assert at(mapper.grid(), 0.22, 0.02) < 0.35


def test_what_was_only_touched_can_be_forgotten_and_an_edge_cannot(mapper):
    mapper.mark_obstacle(planar(0.0, 0.0, 0.0), np.array([[0.22, 0.02]]), touched=True)
    mapper.mark_obstacle(planar(0.0, 0.0, 0.0), np.array([[0.22, 0.32]]))
    assert mapper.forget_touched()
    grid = mapper.grid()
    assert at(grid, 0.22, 0.02) == 0.5 and at(grid, 0.22, 0.32) == 1.0
    assert not mapper.forget_touched()


def test_the_grid_grows_and_keeps_what_it_holds(mapper):
    mapper.mark_obstacle(planar(0.0, 0.0, 0.0), np.array([[0.22, 0.02]]))
    mapper.mark_free(planar(-0.5, 0.3, 0.0), 0.175)
    small = mapper.grid()
    for x, y in ((-20.0, 1.0), (3.0, 30.0)):
        mapper.mark_free(planar(x, y, 0.0), 0.175)
        grid = mapper.grid()
        assert at(grid, x, y) < 0.35
        assert at(grid, -0.5, 0.3) == at(small, -0.5, 0.3) < 0.35
        assert at(grid, 0.22, 0.02) == 1.0
        offset = (grid.origin - small.origin) / grid.resolution
        np.testing.assert_allclose(offset, np.round(offset), atol=1e-6)


@given(
    st.floats(-5, 5), st.floats(-5, 5), st.floats(-np.pi, np.pi), st.floats(0.2, 2), st.floats(0, 1)
)
def test_the_level_frame_is_on_the_floor_below_the_camera_and_looks_its_way(x, y, yaw, h, tilt):
    T_map_cam = planar(x, y, yaw) @ camera_mount(h, 0.1, tilt)
    T_level_cam = invert(level_pose(T_map_cam)) @ T_map_cam
    np.testing.assert_allclose(T_level_cam[:3, 3], [0.0, 0.0, h], atol=1e-9)
    assert T_level_cam[1, 2] == pytest.approx(0.0, abs=1e-9)
    assert T_level_cam[0, 2] == pytest.approx(np.cos(tilt), abs=1e-9)


@given(
    edge=st.integers(0, BEARINGS),
    off=st.floats(-1, 1) | st.floats(-1e-6, 1e-6) | st.floats(-1e-14, 1e-14),
    distance=st.floats(0.1, 10),
)
def test_a_bearing_bin_is_that_of_the_arctangent(edge, off, distance):
    angle = ((edge + off) / BEARINGS - 0.5) * 2 * np.pi
    x, y = distance * np.cos(angle), distance * np.sin(angle)
    expected = int((math.atan2(y, x) / (2 * np.pi) + 0.5) * BEARINGS) % BEARINGS
    assert bearing_bin(x, y, BEARINGS) == expected


def test_the_edge_of_a_hole_in_the_floor_is_an_obstacle(mapper):
    rng = np.random.default_rng(0)
    for x in np.arange(0.0, 0.6, 0.1):
        T_map_cam = planar(x, 0.0, 0.0) @ MOUNT
        mapper.integrate(0, np.eye(4), T_map_cam, stairwell(T_map_cam, rng), INTRINSICS)
    grid = mapper.grid()
    for y in np.arange(-0.5, 0.51, 0.1):
        edge = occupied_xy(grid)[np.abs(occupied_xy(grid)[:, 1] - y) < 0.05]
        assert edge[:, 0].min() == pytest.approx(1.63, abs=0.08)
        assert at(grid, 1.45, y) < 0.35
    beside = occupied_xy(grid)
    beside = beside[beside[:, 0] < 2.5]
    assert (np.abs(beside[:, 1]) < 0.7).all()


def test_a_hole_far_away_is_unknown_and_no_obstacle(mapper):
    T_map_cam = planar(-0.8, 0.0, 0.0) @ MOUNT
    for _ in range(5):
        mapper.integrate(0, np.eye(4), T_map_cam, stairwell(T_map_cam), INTRINSICS)
    assert 0.35 < at(mapper.grid(), 1.8, 0.0) < 0.65


@pytest.mark.parametrize("pitch", [-0.015, 0.015])
def test_a_camera_that_nods_sees_no_holes_in_a_floor_that_is_whole(mapper, pitch):
    rng = np.random.default_rng(1)
    T_map_cam = planar(0.0, 0.0, 0.0) @ MOUNT
    nodding = planar(0.0, 0.0, 0.0) @ camera_mount(0.6, 0.0, 0.25 + pitch)
    for _ in range(10):
        mapper.integrate(0, np.eye(4), T_map_cam, depth_of(nodding, rng=rng), INTRINSICS)
    near = occupied_xy(mapper.grid())
    assert not (np.linalg.norm(near, axis=1) < 2.5).any()


def test_an_inferred_obstacle_beyond_the_range_of_scans_is_left_out(mapper):
    reach = DepthMapperConfig().scan.max_range
    mapper.infer_obstacle(planar(0.0, 0.0, 0.0), np.array([[1.0, 0.0], [reach + 0.5, 0.0]]))
    walls = occupied_xy(mapper.grid())
    assert len(walls) and np.linalg.norm(walls - (1.0, 0.0), axis=1).max() < 0.11
