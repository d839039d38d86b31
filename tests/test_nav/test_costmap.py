"""Inflation of obstacles by the robot's size."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nav.costmap import CostmapConfig, build_costmap
from vizbot.core.types import OccupancyGrid

CONFIG = CostmapConfig()


def grid_of(occupancy: np.ndarray) -> OccupancyGrid:
    return OccupancyGrid(occupancy.astype(np.float32), 0.05, np.array([-1.0, 2.0]))


@settings(max_examples=50)
@given(arrays(np.float32, (12, 17), elements=st.sampled_from([0.0, 0.5, 1.0])))
def test_cells_are_lethal_exactly_where_the_robot_cannot_be(occupancy):
    costmap = build_costmap(grid_of(occupancy), CONFIG)
    cells = np.argwhere(np.isfinite(occupancy))
    obstacles = cells[(occupancy == 1.0).ravel()]
    if len(obstacles):
        nearest = np.linalg.norm(cells[:, None] - obstacles[None], axis=-1).min(axis=1) * 0.05
        nearest = np.maximum(nearest - 0.025, 0.0)
        np.testing.assert_allclose(costmap.clearance.ravel(), nearest, atol=1e-5)
        lethal = (nearest < CONFIG.closed_radius - 1e-6).reshape(occupancy.shape)
        assert np.isinf(costmap.cost[lethal]).all()
        clear = (nearest > CONFIG.closed_radius + 1e-6).reshape(occupancy.shape)
        assert np.isfinite(costmap.cost[clear]).all()
        tight = clear & (nearest < CONFIG.safe_radius - 1e-6).reshape(occupancy.shape)
        assert (costmap.cost[tight] >= CONFIG.squeeze_cost).all()
    else:
        assert np.isfinite(costmap.cost).all()
    assert (costmap.cost >= 1.0).all()


def test_unknown_floor_costs_more_than_free_floor_and_less_than_a_wall():
    occupancy = np.zeros((40, 40))
    occupancy[:, 20:] = 0.5
    costmap = build_costmap(grid_of(occupancy), CONFIG)
    assert costmap.cost[10, 10] == 1.0
    assert costmap.cost[10, 30] == np.float32(CONFIG.unknown_cost)


def test_cost_decays_away_from_an_obstacle():
    occupancy = np.zeros((41, 41))
    occupancy[20, 20] = 1.0
    row = build_costmap(grid_of(occupancy), CONFIG).cost[20, 25:]
    assert (np.diff(row) < 0).all()
    assert row[-1] < 1.1


def test_a_gap_narrower_than_the_robot_is_closed_and_a_door_is_open():
    occupancy = np.zeros((60, 60))
    occupancy[30] = 1.0
    occupancy[30, 10:15] = 0.0
    occupancy[30, 35:51] = 0.0
    costmap = build_costmap(grid_of(occupancy), CONFIG)
    assert np.isinf(costmap.cost[30, :20]).all()
    assert np.isfinite(costmap.cost[30, 42])


def test_weak_evidence_is_neither_wall_nor_floor():
    costmap = build_costmap(grid_of(np.full((5, 5), 0.6)), CONFIG)
    assert (costmap.cost == np.float32(CONFIG.unknown_cost)).all()
    assert not costmap.occupied.any()
