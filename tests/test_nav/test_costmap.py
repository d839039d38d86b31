"""Inflation of obstacles by the robot's size."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nav.config import CostmapConfig
from nav.costmap import LiveCostmap, build_costmap
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


def test_a_costmap_follows_its_map_to_the_last_bit():
    rng, live = np.random.default_rng(5), LiveCostmap(CONFIG)
    occupancy = np.full((150, 180), 0.5, np.float32)
    zones, moved = (), 0
    before = live.update(grid_of(occupancy))
    for tick in range(40):
        row, col = rng.integers(0, [140, 170])
        value = rng.choice([0.0, 0.5, 0.7, 1.0])
        occupancy[row : row + rng.integers(1, 20), col : col + rng.integers(1, 20)] = value
        if tick == 20:
            zones = (np.array([[1, 1], [3, 1], [3, 2]], np.float32),)
        grid = replace(grid_of(occupancy.copy()), zones=zones)
        kept, now = before.cost.copy(), live.update(grid)
        np.testing.assert_array_equal(before.cost, kept)
        anew = LiveCostmap(CONFIG).update(grid)
        np.testing.assert_array_equal(now.cost, anew.cost)
        assert now.least == anew.least
        width = (np.array(now.cost.shape) - grid.occupancy.shape)[0] // 2
        inner = now.grid.occupancy[width:-width, width:-width]
        np.testing.assert_array_equal(inner, grid.occupancy)
        near = anew.clearance <= CONFIG.safe_radius + 1.0
        np.testing.assert_array_equal(now.clearance[near], anew.clearance[near])
        assert (now.clearance[~near] > CONFIG.safe_radius + 1.0).all()
        moved += not np.array_equal(now.cost, before.cost)
        before = now
    assert moved > 20


def test_costs_are_those_of_the_formula_however_far_obstacles_are():
    occupancy = np.zeros((200, 240), np.float32)
    occupancy[3, 5] = 1.0
    costmap = build_costmap(grid_of(occupancy), CONFIG)
    rows, cols = np.mgrid[:200, :240]
    away = np.sqrt(((rows - 3) ** 2 + (cols - 5) ** 2).astype(np.float32))
    clearance = np.maximum(away - 0.5, 0.0) * np.float32(costmap.grid.resolution)
    nearness = np.maximum((clearance - CONFIG.safe_radius) / CONFIG.inflation_falloff, 0.0)
    expected = (1.0 + (CONFIG.inflation_cost * np.exp(-nearness)).astype(float)).astype(np.float32)
    safe = clearance >= CONFIG.safe_radius
    np.testing.assert_array_equal(costmap.cost[safe], expected[safe])
    assert (costmap.cost == 1.0).any()


def test_a_map_that_stays_keeps_its_costs():
    live = LiveCostmap(CONFIG)
    occupancy = np.full((40, 50), 0.2, np.float32)
    occupancy[8:12, 8:20] = 0.9
    first = live.update(grid_of(occupancy))
    second = live.update(grid_of(occupancy + np.float32(0.01)))
    assert second.cost is first.cost
    assert (second.grid.occupancy == np.float32(0.2) + np.float32(0.01)).any()
