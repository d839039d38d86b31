"""The field of ways against the planner's paths, as the map changes and the robot moves."""

import numpy as np
import pytest

from nav.astar import plan
from nav.config import CostmapConfig
from nav.costmap import LiveCostmap
from nav.goal_region import goal_region
from nav.way_field import WayField
from tests.test_nav.dijkstra import dijkstra_costs
from vizbot.core.types import OccupancyGrid

CONFIG = CostmapConfig()


def rooms(rng):
    """A quarter still unknown, two walls with doors, and furniture."""
    occupancy = np.zeros((90, 120), np.float32)
    occupancy[60:, 70:] = 0.5
    occupancy[30], occupancy[:, 50] = 1.0, 1.0
    occupancy[30, 10:26] = occupancy[30, 80:96] = occupancy[50:68, 50] = 0.0
    for _ in range(6):
        row, col = rng.integers(0, [80, 110])
        occupancy[row : row + 8, col : col + 6] = 1.0
    return occupancy


def grid_of(occupancy):
    return OccupancyGrid(occupancy.copy(), 0.05, np.array([-1.0, 0.5]))


def passable(costmap, rng, count):
    cells = np.argwhere(np.isfinite(costmap.cost))
    return costmap.grid.to_xy(cells[rng.integers(0, len(cells), count)])


def same_as_planned(field, costmap, position, points):
    """Compare with the planner's path to each point; the number of those that can be reached."""
    reached = 0
    for point, cost in zip(points, field.costs(points), strict=True):
        path = plan(costmap, position, point[None])
        if path is None:
            assert np.isinf(cost)
            continue
        reached += 1
        assert cost == pytest.approx(path.cost, abs=1e-6)
    return reached


@pytest.mark.parametrize("seed", range(4))
def test_costs_are_those_of_the_planner_while_map_and_robot_change(seed):
    rng = np.random.default_rng(seed)
    occupancy, live, field = rooms(rng), LiveCostmap(CONFIG), WayField()
    costmap = live.update(grid_of(occupancy))
    position, reached = passable(costmap, rng, 1)[0], 0
    for tick in range(30):
        row, col = rng.integers(0, [85, 115])
        occupancy[row : row + rng.integers(1, 9), col : col + 5] = rng.choice([0.0, 0.5, 1.0])
        costmap = live.update(grid_of(occupancy))
        if tick % 10 == 9:
            position = passable(costmap, rng, 1)[0]
        field.update(costmap, position)
        reached += same_as_planned(field, costmap, position, passable(costmap, rng, 12))
    assert reached > 100


def test_costs_to_everywhere_are_those_of_dijkstra_while_the_map_grows_and_the_robot_drives():
    rng = np.random.default_rng(5)
    occupancy, live, field = rooms(rng), LiveCostmap(CONFIG), WayField()
    grid, position, reached = grid_of(occupancy), None, 0
    for tick in range(24):
        if tick % 6 == 5:  # something is seen beyond the west and south ends
            wider = np.pad(grid.occupancy, ((4, 0), (7, 0)), constant_values=0.5)
            origin = grid.origin - grid.resolution * np.array([7, 4])
            grid = OccupancyGrid(wider, grid.resolution, origin, grid.zones)
        row, col = rng.integers(0, np.array(grid.occupancy.shape) - 6)
        grid.occupancy[row : row + 4, col : col + 6] = rng.choice([0.0, 0.5, 1.0])
        costmap = live.update(OccupancyGrid(grid.occupancy.copy(), grid.resolution, grid.origin))
        if position is None:
            position = passable(costmap, rng, 1)[0]
        elif tick % 2:
            distant = plan(costmap, position, passable(costmap, rng, 1))
            position = position if distant is None else distant.xy[: int(rng.integers(2, 8))][-1]
        field.update(costmap, position)
        start = costmap.grid.to_cells(position)
        if np.isinf(costmap.cost[tuple(start)]):  # where it escapes, the planner's test speaks
            continue
        true = dijkstra_costs(costmap.cost.astype(float), start, grid.resolution)
        centres = costmap.grid.to_xy(np.argwhere(np.ones(true.shape, bool)))
        np.testing.assert_allclose(field.costs(centres), true.ravel(), rtol=1e-6)
        reached += 1
    assert reached > 12


def test_a_kept_field_is_a_fresh_one_to_the_last_cell():
    rng = np.random.default_rng(9)
    occupancy, live, kept = rooms(rng), LiveCostmap(CONFIG), WayField()
    position = passable(live.update(grid_of(occupancy)), rng, 1)[0]
    centres = None
    for _ in range(60):
        row, col = rng.integers(0, [88, 118])
        occupancy[row : row + rng.integers(1, 4), col : col + rng.integers(1, 4)] = rng.choice(
            [0.0, 0.5, 1.0, 1.0]
        )
        costmap, fresh = live.update(grid_of(occupancy)), WayField()
        kept.update(costmap, position)
        fresh.update(costmap, position)
        if centres is None:
            centres = costmap.grid.to_xy(np.argwhere(np.ones(costmap.cost.shape, bool)))
        np.testing.assert_array_equal(kept.costs(centres), fresh.costs(centres))


def test_what_is_asked_for_one_by_one_costs_the_same_as_everything_at_once():
    rng = np.random.default_rng(3)
    for _ in range(6):
        occupancy = rooms(rng)
        occupancy[5:20, 5:20] = 1.0  # a closed room
        occupancy[8:17, 8:17] = 0.0
        costmap, one_by_one, at_once = (
            LiveCostmap(CONFIG).update(grid_of(occupancy)),
            WayField(),
            WayField(),
        )
        points = passable(costmap, rng, 60)
        for field in (one_by_one, at_once):
            field.update(costmap, points[0])
        everything = at_once.costs(points, within=0.2)
        for point, cost in zip(points, everything, strict=True):
            assert one_by_one.costs(point[None], within=0.2)[0] == cost


def test_only_what_is_asked_about_is_spread_to():
    costmap, field = LiveCostmap(CONFIG).update(grid_of(np.zeros((300, 300)))), WayField()
    position = np.array([6.0, 8.0])
    field.update(costmap, position)
    field.costs(position[None] + 1.0)
    assert 0.0 < np.isfinite(field._spreading.field).mean() < 0.5


@pytest.mark.parametrize("resolution", [0.05, 0.07])
def test_a_cost_at_the_rim_of_what_is_settled_is_spread_beyond(resolution):
    grid = OccupancyGrid(np.zeros((200, 200), np.float32), resolution, np.zeros(2))
    costmap, field = LiveCostmap(CONFIG).update(grid), WayField()
    field.update(costmap, np.array([1.0, 1.0]))
    spreading, before = field._spreading, 0.0
    while spreading.goes_beyond(np.array([before])):
        assert spreading._settled > before
        before = spreading._settled
    assert before > 5.0


def test_what_lies_on_an_obstacle_is_reached_from_beside_it():
    occupancy = np.zeros((60, 60), np.float32)
    occupancy[30:34, 30:34] = 1.0
    costmap, field = LiveCostmap(CONFIG).update(grid_of(occupancy)), WayField()
    field.update(costmap, np.array([-0.5, 1.0]))
    thing = np.array([[0.6, 2.1]])
    assert np.isinf(field.costs(thing)[0])
    beside = field.costs(thing, within=0.6)[0]
    assert 1.0 < beside < 4.0
    assert field.costs(thing, within=0.9)[0] < beside


def test_nothing_is_reached_from_outside_the_map_or_outside_it():
    costmap, field = LiveCostmap(CONFIG).update(grid_of(np.zeros((40, 40), np.float32))), WayField()
    points = np.array([[0.0, 1.5], [50.0, 50.0]])
    assert np.isinf(field.costs(points)).all()
    field.update(costmap, np.array([0.0, 1.0]))
    assert np.isfinite(field.costs(points)).tolist() == [True, False]
    assert field.costs(np.zeros((0, 2))).shape == (0,)
    field.update(costmap, np.array([99.0, 1.0]))
    assert np.isinf(field.costs(points)).all()


def test_a_robot_against_a_wall_has_ways_too():
    occupancy = np.zeros((60, 60), np.float32)
    occupancy[:10] = 1.0
    costmap, field = LiveCostmap(CONFIG).update(grid_of(occupancy)), WayField()
    position = grid_of(occupancy).to_xy(np.array([11, 30]))
    assert np.isinf(costmap.cost[tuple(costmap.grid.to_cells(position))])
    field.update(costmap, position)
    assert same_as_planned(field, costmap, position, np.array([[1.2, 2.9], [0.0, 2.0]])) == 2


def test_the_way_to_reach_a_goal_leads_to_where_it_is_in_sight():
    occupancy = np.zeros((90, 120), np.float32)
    occupancy[:70, 60] = 1.0  # a wall at x = 2 m, open at the north end only
    costmap = LiveCostmap(CONFIG).update(grid_of(occupancy))
    field, position, goal = WayField(), np.array([1.6, 1.5]), np.array([2.3, 1.5])
    field.update(costmap, position)
    assert field.costs(goal[None], 0.9)[0] < 0.1  # right behind the wall
    around = field.cost_to_reach(costmap, goal, 0.9, 0.05)
    region = goal_region(costmap, goal[None], 0.9, 0.05)
    stops, _ = region.stops()
    path = plan(costmap, position, costmap.grid.to_xy(stops))
    assert around == pytest.approx(path.cost, abs=1e-6) and around > 4.0
    assert field.cost_to_reach(costmap, goal, 0.9, 0.6) < 0.1  # what it is in
    sealed = occupancy.copy()
    sealed[[2, 38], 60:85] = sealed[2:39, 84] = 1.0
    costmap = LiveCostmap(CONFIG).update(grid_of(sealed))
    field.update(costmap, position)
    assert np.isinf(field.cost_to_reach(costmap, goal, 0.9, 0.05))


def test_the_cost_to_reach_is_the_least_in_the_region_of_the_goal():
    rng = np.random.default_rng(4)
    reached = 0
    for _ in range(8):
        costmap, field = LiveCostmap(CONFIG).update(grid_of(rooms(rng))), WayField()
        position, *goals = passable(costmap, rng, 12)
        field.update(costmap, position)
        start = costmap.grid.to_cells(position)
        true = dijkstra_costs(costmap.cost.astype(float), start, costmap.grid.resolution)
        for goal in goals:
            front = goal + rng.uniform(-0.3, 0.3, 2)
            region = goal_region(costmap, goal[None], 0.7, 0.1, front[None])
            stops, _ = region.stops()
            least = true[tuple(stops.T)].min(initial=np.inf)
            cost = field.cost_to_reach(costmap, goal, 0.7, 0.1, front)
            assert cost == pytest.approx(least, rel=1e-6)
            reached += np.isfinite(cost)
    assert reached > 40
