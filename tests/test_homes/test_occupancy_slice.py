import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from sim_stubs.homes.geometry.occupancy_slice import (
    PlanGrid,
    clearance,
    grid_around,
    occupied,
    reachable,
)
from sim_stubs.homes.geometry.solids import box, triangles

GREY = (0.5, 0.5, 0.5)


def xy_of(mask, grid):
    rows, columns = np.nonzero(mask)
    return grid.pixels_to_xy(np.column_stack([columns, rows]))


def test_a_table_is_its_legs_below_and_its_top_above():
    legs = [box((x, y, 0), (0.05, 0.05, 0.7), GREY) for x in (0, 1) for y in (0, 1)]
    table = triangles([*legs, box((0.5, 0.5, 0.7), (1.1, 1.1, 0.05), GREY)])
    grid = grid_around(table)
    low = xy_of(occupied(table, 0.02, 0.10, grid), grid)
    distances = np.linalg.norm(low[:, None] - [[0, 0], [0, 1], [1, 0], [1, 1]], axis=2)
    assert distances.min(axis=1).max() < 0.05
    assert occupied(table, 0.65, 0.80, grid)[grid.cell_of(0.5, 0.5)]


def test_a_hollow_box_stays_hollow():
    """A convex hull of the walls would fill the room."""
    walls = triangles([box((0, 0, -1), (2, 2, 4), GREY)])
    grid = grid_around(walls)
    mask = occupied(walls, 0.0, 0.1, grid)
    assert not mask[grid.cell_of(0, 0)]
    assert not reachable(~mask, grid.cell_of(0, 0))[0, 0]


@given(
    corners=st.lists(
        st.tuples(*[st.floats(-1, 1, allow_nan=False)] * 3), min_size=3, max_size=3
    ).map(np.array),
    low=st.floats(-0.9, 0.4),
    thickness=st.floats(0.05, 0.5),
    weights=st.tuples(*[st.floats(0.01, 1.0)] * 3).map(np.array),
)
@example(
    corners=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 5e-128], [0.0, 1.0, -2e-309]]),
    low=0.0,
    thickness=0.5,
    weights=np.ones(3),
)
def test_every_point_of_a_triangle_in_the_layer_is_occupied(corners, low, thickness, weights):
    point = weights / weights.sum() @ corners
    grid = PlanGrid(np.array([-1.5, -1.5]), 0.02, (150, 150))
    mask = occupied(corners[None], low, low + thickness, grid)
    if low < point[2] < low + thickness:
        row, column = grid.cell_of(*point[:2])
        assert mask[row - 1 : row + 2, column - 1 : column + 2].any()
    if corners[:, 2].max() < low or corners[:, 2].min() > low + thickness:
        assert not mask.any()


@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([0.005, 0.02, 0.1]))
def test_small_triangles_are_drawn_as_opencv_draws_them_also_at_the_edge(seed, size):
    rng = np.random.default_rng(seed)
    flat = rng.uniform(-0.1, 1.1, (40, 1, 2)) + rng.uniform(-size, size, (40, 3, 2))
    grid = PlanGrid(np.zeros(2), 0.02, (50, 48))
    drawn = np.zeros(grid.shape, np.uint8)
    for corners in np.round(grid.to_pixels(flat) * 16).astype(np.int32):
        cv2.fillConvexPoly(drawn, corners, 1, shift=4)
    upright = np.dstack([flat, rng.uniform(0.1, 0.2, (40, 3))])
    assert np.array_equal(occupied(upright, 0.0, 1.0, grid), drawn > 0)


def test_clearance_is_the_distance_to_the_surface():
    wall = triangles([box((1.0, 0, 0), (0.1, 4, 1), GREY), box((-1.0, 0, 0), (0.1, 4, 1), GREY)])
    grid = grid_around(wall)
    field = clearance(occupied(wall, 0.0, 0.5, grid), grid)
    assert field[grid.cell_of(0.0, 0.0)] == pytest.approx(0.95, abs=0.016)
    assert field[grid.cell_of(0.5, 1.0)] == pytest.approx(0.45, abs=0.016)


def test_nothing_is_reachable_from_an_occupied_cell():
    free = np.ones((5, 5), bool)
    free[2, 2] = False
    assert not reachable(free, (2, 2)).any()
    assert reachable(free, (0, 0)).sum() == 24
