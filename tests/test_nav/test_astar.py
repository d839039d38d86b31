"""Multi-goal A* against Dijkstra on the same graph, and its rules at the edges."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nav.astar import ESCAPE_COST, ESCAPE_RADIUS, exits, plan
from nav.config import CostmapConfig
from nav.costmap import Costmap, build_costmap
from tests.test_nav.dijkstra import dijkstra_costs
from vizbot.core.types import OccupancyGrid

CONFIG = CostmapConfig()
STEP = 0.05


def costmap_of(cost: np.ndarray) -> Costmap:
    grid = OccupancyGrid(np.zeros(cost.shape, np.float32), STEP, np.array([-0.4, 0.7]))
    clearance = np.where(np.isinf(cost), 0.0, np.inf).astype(np.float32)
    return Costmap(grid, cost.astype(np.float32), clearance, None, CONFIG, float(cost.min()))


def cost_of_way(cost: np.ndarray, cells: np.ndarray) -> float:
    """Also checks that the way is one: neighbour to neighbour, nothing closed, no corner cut."""
    steps = np.diff(cells, axis=0)
    assert (np.abs(steps).max(axis=1) == 1).all()
    assert np.isfinite(cost[tuple(cells.T)]).all()
    for (row, col), (down, right) in zip(cells[:-1], steps, strict=True):
        assert np.isfinite(cost[row + down, col]) and np.isfinite(cost[row, col + right])
    along = cost[tuple(cells.T)]
    return float(np.linalg.norm(steps, axis=1) * STEP @ (along[1:] + along[:-1]) / 2)


@st.composite
def problems(draw):
    rows, cols = draw(st.integers(1, 14)), draw(st.integers(1, 14))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    cost = rng.choice([1.0, 1.5, 4.25], (rows, cols)).astype(np.float32).astype(float)
    cost[rng.random((rows, cols)) < draw(st.sampled_from([0.0, 0.25, 0.45]))] = np.inf
    start = rng.integers(0, [rows, cols])
    cost[tuple(start)] = 1.0
    goals = rng.integers(-2, [rows + 2, cols + 2], (draw(st.integers(1, 12)), 2))
    goal_costs = draw(st.sampled_from([0.0, 0.2, 1.0])) * rng.random(len(goals))
    return cost, start, goals, goal_costs


@settings(max_examples=300)
@given(problems())
def test_the_path_costs_what_dijkstra_finds(problem):
    cost, start, goals, goal_costs = problem
    costmap = costmap_of(cost)
    inside = costmap.grid.contains(goals)
    totals = np.full(len(goals), np.inf)
    totals[inside] = dijkstra_costs(cost, start, STEP)[tuple(goals[inside].T)] + goal_costs[inside]
    path = plan(costmap, costmap.grid.to_xy(start), costmap.grid.to_xy(goals), goal_costs)
    if np.isinf(totals.min()):
        assert path is None
        return
    assert path is not None
    assert path.cost == pytest.approx(totals.min(), abs=1e-9)
    assert totals[path.goal] == pytest.approx(totals.min(), abs=1e-9)
    cells = costmap.grid.to_cells(path.xy)
    np.testing.assert_array_equal(cells[0], start)
    np.testing.assert_array_equal(cells[-1], goals[path.goal])
    assert cost_of_way(cost, cells) + goal_costs[path.goal] == pytest.approx(path.cost, abs=1e-9)


def test_a_start_outside_the_map_has_no_path():
    costmap = costmap_of(np.ones((5, 5)))
    assert plan(costmap, np.array([-5.0, 0.8]), np.array([[-0.3, 0.8]])) is None


def test_without_goals_there_is_no_path():
    assert plan(costmap_of(np.ones((5, 5))), np.array([-0.3, 0.8]), np.zeros((0, 2))) is None


def test_a_robot_against_a_wall_gets_away_from_it():
    occupancy = np.zeros((60, 60), np.float32)
    occupancy[:10] = 1.0
    grid = OccupancyGrid(occupancy, STEP, np.zeros(2))
    costmap = build_costmap(grid, CONFIG)
    start = grid.to_xy(np.array([11, 30]))
    assert np.isinf(costmap.cost[11, 30])
    path = plan(costmap, start, np.array([[1.5, 2.5]]))
    assert path is not None
    cells = grid.to_cells(path.xy)
    closed = np.isinf(costmap.cost[tuple(cells.T)])
    assert closed.sum() <= np.ceil(CONFIG.safe_radius / STEP)
    assert (np.diff(costmap.clearance[tuple(cells[: closed.sum() + 1].T)]) > 0).all()


@pytest.mark.parametrize("cell", [(1, 1), (58, 3), (2, 57)])
def test_a_robot_gets_away_from_a_corner_of_the_map_too(cell):
    occupancy = np.zeros((60, 60), np.float32)
    occupancy[[0, -1]] = occupancy[:, [0, -1]] = 1.0
    costmap = build_costmap(OccupancyGrid(occupancy, STEP, np.zeros(2)), CONFIG)
    assert np.isinf(costmap.cost[cell])
    path = plan(costmap, costmap.grid.to_xy(np.array(cell)), np.array([[1.5, 1.5]]))
    assert path is not None


def test_escaping_never_leads_through_a_wall():
    occupancy = np.zeros((60, 60), np.float32)
    occupancy[20] = 1.0
    grid = OccupancyGrid(occupancy, STEP, np.zeros(2))
    costmap = build_costmap(grid, CONFIG)
    assert plan(costmap, grid.to_xy(np.array([18, 30])), np.array([[1.5, 2.5]])) is None


def test_a_robot_drawn_on_an_obstacle_can_leave_it():
    occupancy = np.zeros((40, 40), np.float32)
    occupancy[20, 20] = 1.0
    grid = OccupancyGrid(occupancy, STEP, np.zeros(2))
    path = plan(build_costmap(grid, CONFIG), grid.to_xy(np.array([20, 20])), np.array([[0.2, 0.2]]))
    assert path is not None


def test_a_narrow_passage_stays_closed_beyond_the_escape_radius():
    occupancy = np.zeros((60, 80), np.float32)
    occupancy[25, 10:70] = occupancy[29, 10:70] = 1.0
    grid = OccupancyGrid(occupancy, STEP, np.zeros(2))
    costmap = build_costmap(grid, CONFIG)
    assert plan(costmap, grid.to_xy(np.array([27, 40])), np.array([[0.1, 0.1]])) is None
    near_end = grid.to_xy(np.array([27, 67]))
    path = plan(costmap, near_end, np.array([[3.9, 1.4]]))
    assert path is not None
    assert path.cost > ESCAPE_COST * 0.1
    closed = np.isinf(costmap.cost[tuple(grid.to_cells(path.xy).T)])
    assert (np.linalg.norm(path.xy[closed] - near_end, axis=1) <= ESCAPE_RADIUS + 1e-9).all()


def test_the_distant_point_is_as_on_a_map_that_reaches_it():
    rng = np.random.default_rng(3)
    rows, cols, far = 20, 24, 60
    cost = rng.choice([1.0, 1.5, 3.0, np.inf], (rows, cols), p=[0.4, 0.3, 0.1, 0.2])
    cost[[0, -1]], cost[:, [0, -1]] = CONFIG.unknown_cost, CONFIG.unknown_cost
    cost[12, 12] = 1.0
    costmap = costmap_of(cost)
    # Straight below the map the way on is along a column, where cells measure distance exactly.
    wide = np.full((rows + far, cols), CONFIG.unknown_cost)
    wide[far:] = cost
    start = costmap.grid.to_xy(np.array([12, 12]))
    for col in (0, 11, 23):
        goal = costmap.grid.to_xy(np.array([-far, col]))
        path = plan(costmap, start, *exits(costmap, goal))
        assert path is not None
        whole = dijkstra_costs(wide, np.array([12 + far, 12]), STEP)[0, col]
        assert path.cost <= whole + 1e-9
        # Cells overrate a slanted way by 8.2 % at most.
        assert path.cost > whole * 0.92
        assert costmap.grid.to_cells(path.xy[-1])[0] == 0


def test_exits_face_the_distant_point():
    costmap = costmap_of(np.ones((10, 20)))
    exits_xy, costs = exits(costmap, np.array([-50.0, -50.0]))
    cells = costmap.grid.to_cells(exits_xy)
    assert set(map(tuple, cells)) == {(0, c) for c in range(20)} | {(r, 0) for r in range(10)}
    distances = np.linalg.norm(exits_xy + 50.0, axis=1)
    np.testing.assert_allclose(costs, CONFIG.unknown_cost * distances)


def test_a_closed_room_has_no_way_out():
    cost = np.ones((20, 20))
    cost[5, 5:15] = cost[14, 5:15] = cost[5:15, 5] = cost[5:15, 14] = np.inf
    costmap = costmap_of(cost)
    start = costmap.grid.to_xy(np.array([10, 10]))
    assert plan(costmap, start, *exits(costmap, np.array([-50.0, -50.0]))) is None
    cost[9, 14] = 1.0
    assert plan(costmap_of(cost), start, *exits(costmap, np.array([-50.0, -50.0]))) is not None


def test_a_distant_point_inside_the_map_is_an_ordinary_goal():
    costmap = costmap_of(np.ones((20, 20)))
    point = costmap.grid.to_xy(np.array([3, 4]))
    goals, costs = exits(costmap, point)
    np.testing.assert_array_equal(goals, point[None])
    np.testing.assert_array_equal(costs, [0.0])
