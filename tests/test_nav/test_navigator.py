"""Navigation and exploration in closed loop on drawn floor plans, with ideal kinematics."""

import numpy as np
import pytest

from nav.config import NavigatorConfig, Reach, RecoveryConfig
from nav.costmap import Costmap, LiveCostmap, build_costmap
from nav.goal_region import NO_GOAL, fronts, goal_region
from nav.navigator import GoalPoints, Navigation, explore_distant, navigate
from nav.recovery import Recovery, contact_points
from tests.test_nav.test_follower import driven
from vizbot.core.geometry import planar
from vizbot.core.types import STOP, OccupancyGrid, Twist

CONFIG = NavigatorConfig()
REACH = Reach(distance=0.9, extent=0.4)
RESOLUTION = 0.05


def two_rooms() -> OccupancyGrid:
    """6 m by 4 m behind walls: two rooms, a door of 0.8 m, a table with a chair, a cupboard."""
    occupancy = np.zeros((80, 120), np.float32)
    occupancy[[0, -1]] = occupancy[:, [0, -1]] = 1.0
    occupancy[:, 60] = 1.0
    occupancy[50:66, 60] = 0.0
    occupancy[20:32, 80:100] = 1.0
    occupancy[10:40, 25:33] = 1.0
    return OccupancyGrid(occupancy, RESOLUTION, np.array([-1.0, -1.5]))


def costs_on(grid: OccupancyGrid) -> Costmap:
    return LiveCostmap(CONFIG.costmap).update(grid)


def gap(grid: OccupancyGrid, T_map_base: np.ndarray) -> float:
    """From the robot's centre to the nearest obstacle's edge [m]."""
    centres = grid.to_xy(np.argwhere(grid.occupancy > 0.9))
    outside = np.maximum(np.abs(centres - T_map_base[:2, 3]) - RESOLUTION / 2, 0.0)
    return float(np.linalg.norm(outside, axis=1).min())


def way_to(
    grid: OccupancyGrid,
    goals: GoalPoints,
    T_map_base: np.ndarray,
    reach: Reach = REACH,
    last: Navigation | None = None,
) -> Navigation | None:
    return navigate(costs_on(grid), goals, T_map_base, reach, CONFIG, last)


def seen_from(
    truth: OccupancyGrid, known: np.ndarray, T_map_base: np.ndarray, fov: float, reach: float
) -> None:
    """Draw into `known` what a level scanner with the camera's field of view sees."""
    yaw = np.arctan2(T_map_base[1, 0], T_map_base[0, 0])
    bearings = yaw + np.arange(-fov / 2, fov / 2, 0.01)
    ranges = np.arange(0.3, reach, RESOLUTION / 2)
    directions = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
    cells = truth.to_cells(T_map_base[:2, 3] + ranges[None, :, None] * directions[:, None])
    rows, cols = np.moveaxis(np.clip(cells, 0, np.array(truth.occupancy.shape) - 1), -1, 0)
    hit = truth.occupancy[rows, cols] > 0.9
    before = np.cumsum(hit, axis=1) - hit == 0
    known[rows[before], cols[before]] = truth.occupancy[rows[before], cols[before]]


@pytest.mark.parametrize("seed", range(6))
def test_the_robot_arrives_without_touching_anything(seed):
    grid = two_rooms()
    rng = np.random.default_rng(seed)
    costmap = build_costmap(grid, CONFIG.costmap)
    free = np.argwhere(np.isfinite(costmap.cost))
    T = planar(*grid.to_xy(rng.permutation(free)[0]), rng.uniform(-np.pi, np.pi))
    goals_xy = np.array([[3.5, -0.3], [3.6, -0.2]])
    navigation, way = None, 0.0
    for _ in range(400):
        navigation = way_to(grid, GoalPoints(goals_xy), T, last=navigation)
        assert navigation is not None
        if navigation.arrived:
            break
        before, T = T, driven(T, navigation.twist, 0.2)
        way += float(np.linalg.norm(T[:2, 3] - before[:2, 3]))
        assert gap(grid, T) > CONFIG.costmap.robot_radius
    assert navigation.arrived and navigation.twist == STOP
    away = goals_xy[navigation.goal] - T[:2, 3]
    assert np.linalg.norm(away) <= REACH.distance
    assert away @ T[:2, 0] / np.linalg.norm(away) > np.cos(CONFIG.facing_tolerance + 1e-9)
    assert way < 9.0


def test_a_goal_on_a_wall_is_not_reached_through_the_wall():
    grid = two_rooms()
    # On a picture that hangs 0.3 m inside the right room, the robot close behind the wall.
    goals_xy = np.array([[2.55, -0.5]])
    T = planar(1.75, -0.5, 0.0)
    assert np.linalg.norm(goals_xy[0] - T[:2, 3]) < REACH.distance
    navigation = way_to(grid, GoalPoints(goals_xy), T)
    assert navigation is not None and not navigation.arrived
    assert navigation.path[-1, 0] > 2.05
    assert navigation.distance > 2.0


def test_an_enclosed_goal_is_not_reachable():
    grid = two_rooms()
    grid.occupancy[50:66, 60] = 1.0
    assert way_to(grid, GoalPoints(np.array([[3.5, 0.8]])), planar(0.0, 1.5, 0.0)) is None
    assert way_to(grid, GoalPoints(np.array([[0.8, 1.5]])), planar(0.0, 1.5, 0.0)) is not None


def test_navigation_without_goals_is_none():
    assert way_to(two_rooms(), GoalPoints(np.zeros((0, 2))), planar(0.0, 1.5, 0.0)) is None


def test_the_cheaper_of_two_goals_is_taken():
    goals_xy = np.array([[4.6, 2.2], [-0.4, 2.2]])
    navigation = way_to(two_rooms(), GoalPoints(goals_xy), planar(1.2, 1.5, 0.0))
    assert navigation is not None
    assert navigation.goal == 1
    np.testing.assert_array_equal(navigation.goal_xy, goals_xy[1])


def test_a_cell_sees_its_goal_only_where_nothing_else_stands_between():
    grid = two_rooms()
    costmap = build_costmap(grid, CONFIG.costmap)
    # Beside the cupboard at x 0.25 to 0.65, 0.6 m behind its far side.
    goals_xy = np.array([[1.2, -0.5]])
    region = goal_region(costmap, goals_xy, 1.6, 0.4)
    assert region.goal_from(grid.to_cells(np.array([1.2, 0.3]))) == 0
    assert region.goal_from(grid.to_cells(np.array([-0.2, -0.5]))) == NO_GOAL


def test_a_thing_at_a_wall_is_gone_to_from_the_side_where_it_was_seen():
    grid = two_rooms()
    # The wall is at x 2.0 to 2.05; what stands before it is 0.2 m deep.
    grid.occupancy[8:20, 61:65] = 1.0
    goals_xy, seen = np.array([[2.15, -0.8]]), np.array([[4.0, -0.8]])
    behind = planar(1.6, -0.8, 0.0)
    anywhere = way_to(grid, GoalPoints(goals_xy), behind, Reach(distance=0.6, extent=0.4))
    assert anywhere is not None and anywhere.arrived
    there = way_to(
        grid, GoalPoints(goals_xy, seen_from=seen), behind, Reach(distance=0.6, extent=0.4)
    )
    assert there is not None and not there.arrived
    assert there.path[-1, 0] > 2.3
    np.testing.assert_array_equal(there.goal_xy, goals_xy[0])


def test_a_thing_begins_where_the_line_of_sight_leaves_what_it_stands_on_or_in():
    costmap = build_costmap(two_rooms(), CONFIG.costmap)
    on_the_table, in_the_wall = [3.5, -0.2], [2.02, 0.0]
    goals_xy = np.array([on_the_table, in_the_wall, in_the_wall, [1.0, 0.4], on_the_table])
    seen = np.array([[3.5, 1.9], [1.0, 0.0], [4.0, 0.0], [1.0, 1.9], [3.5, 1.9]])
    places, found = fronts(costmap, goals_xy, seen, 0.6)
    assert found.all()
    np.testing.assert_allclose(places[0], [3.5, 0.1], atol=0.06)  # the table's edge
    assert 1.9 < places[1, 0] < 2.0 and 2.05 < places[2, 0] < 2.15
    np.testing.assert_allclose(places[3], goals_xy[3])  # free floor
    assert not fronts(costmap, goals_xy[:1], seen[:1], 0.2)[1].any()


def test_the_goal_that_is_seen_keeps_its_index():
    grid = two_rooms()
    goals_xy, seen = np.array([[3.5, -0.2], [1.2, 0.3]]), np.array([[3.5, 1.9], [1.0, 1.5]])
    reach = Reach(distance=0.9, extent=0.1)
    costs = np.array([0.0, 5.0])
    way = way_to(grid, GoalPoints(goals_xy, costs, seen), planar(-0.5, 1.5, 0.0), reach)
    assert way is not None and way.goal == 1
    np.testing.assert_array_equal(way.goal_xy, goals_xy[1])


@pytest.mark.parametrize("seed", range(3))
def test_exploration_sees_both_rooms_and_ends_when_the_space_is_closed(seed):
    truth = two_rooms()
    rng = np.random.default_rng(seed)
    costmap = build_costmap(truth, CONFIG.costmap)
    free = np.argwhere(np.isfinite(costmap.cost))
    T = planar(*truth.to_xy(rng.permutation(free)[0]), rng.uniform(-np.pi, np.pi))
    known = np.full_like(truth.occupancy, 0.5)
    grid = OccupancyGrid(known, RESOLUTION, truth.origin)
    navigation = None
    for _step in range(1200):
        seen_from(truth, known, T, np.radians(69), 4.0)
        navigation = explore_distant(costs_on(grid), T, CONFIG, navigation)
        if navigation is None:
            break
        assert not navigation.arrived and navigation.goal is None
        ahead = driven(T, navigation.twist, 0.2)
        if gap(truth, ahead) > CONFIG.costmap.robot_radius:
            T = ahead
            continue
        # What the camera has not seen the bumper feels.
        points = contact_points(True, True, CONFIG.costmap.robot_radius)
        cells = grid.to_cells(points @ T[:2, :2].T + T[:2, 3])
        known[tuple(cells[grid.contains(cells)].T)] = 1.0
        T, navigation = driven(T, Twist(-0.12, 0.0), 0.8), None
    assert navigation is None
    inside = known[1:-1, 1:-1]
    assert (inside[:, :59] != 0.5).mean() > 0.6
    assert (inside[:, 60:] != 0.5).mean() > 0.6


def test_exploration_heads_for_the_distant_point_when_nothing_is_known():
    grid = OccupancyGrid(np.full((40, 40), 0.5, np.float32), RESOLUTION, np.array([-1.0, -1.0]))
    navigation = explore_distant(costs_on(grid), planar(0.0, 0.0, -2.4), CONFIG)
    assert navigation is not None
    assert (navigation.path[-1] < -1.0).all()
    assert navigation.twist.linear > 0
    np.testing.assert_array_equal(navigation.goal_xy, [-50.0, -50.0])


def test_a_slightly_cheaper_way_does_not_turn_the_robot_around():
    grid = OccupancyGrid(np.zeros((80, 80), np.float32), RESOLUTION, np.array([-2.0, -2.0]))
    grid.occupancy[30:50, 30:50] = 1.0
    goal = np.array([[0.0, 1.8]])
    above = way_to(grid, GoalPoints(goal), planar(0.0, -1.2, 0.0))
    assert above is not None
    side = np.sign(above.path[np.argmax(np.abs(above.path[:, 0])), 0])
    leaning = planar(-0.05 * side, -1.2, 0.0)
    again = way_to(grid, GoalPoints(goal), leaning, last=above)
    anew = way_to(grid, GoalPoints(goal), leaning)
    assert again is not None and anew is not None
    assert np.sign(again.path[np.argmax(np.abs(again.path[:, 0])), 0]) == side
    assert np.sign(anew.path[np.argmax(np.abs(anew.path[:, 0])), 0]) == -side


def test_a_path_that_is_blocked_is_left_at_once():
    grid = OccupancyGrid(np.zeros((80, 80), np.float32), RESOLUTION, np.array([-2.0, -2.0]))
    goal, T = np.array([[0.0, 1.8]]), planar(0.0, -1.2, 1.57)
    straight = way_to(grid, GoalPoints(goal), T)
    assert straight is not None
    grid.occupancy[40, 30:50] = 1.0
    around = way_to(grid, GoalPoints(goal), T, last=straight)
    assert around is not None
    assert np.abs(around.path[:, 0]).max() > 0.6


def test_recovery_stops_backs_off_and_ends():
    recovery = Recovery(RecoveryConfig())
    assert recovery.twist(0.0) is None
    recovery.begin(10.0)
    assert recovery.twist(10.1) == STOP
    way, now = 0.0, 10.0
    while (twist := recovery.twist(now)) is not None:
        assert twist.linear <= 0 and twist.angular == 0
        way += twist.linear * 0.01
        now += 0.01
    assert way == pytest.approx(-0.1, abs=0.005)
    assert recovery.twist(now) is None


@pytest.mark.parametrize(
    ("left", "right", "sign"), [(True, False, 1.0), (False, True, -1.0), (True, True, 0.0)]
)
def test_contacts_lie_just_outside_the_bumper_on_the_side_that_was_pressed(left, right, sign):
    points = contact_points(left, right, 0.175)
    distances = np.linalg.norm(points, axis=1)
    assert ((distances > 0.175) & (distances < 0.225)).all()
    assert (points[:, 0] > 0).all()
    assert np.sign(np.round(points[:, 1].mean(), 9)) == sign


def test_without_a_bump_there_is_no_contact():
    assert contact_points(False, False, 0.175).shape == (0, 2)
