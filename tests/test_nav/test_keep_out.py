from dataclasses import replace

import numpy as np
import pytest

from nav.config import CostmapConfig, FrontierConfig, NavigatorConfig, Reach
from nav.costmap import build_costmap
from nav.frontier import FrontierSearch
from nav.navigator import GoalPoints, navigate
from tests.test_nav.test_navigator import costs_on
from vizbot.core.geometry import planar
from vizbot.core.types import OccupancyGrid

GRID = OccupancyGrid(np.zeros((120, 120), np.float32), 0.05, np.array([-3.0, -3.0]))
HERE = planar(-2.0, 0.0, 0.0)
REACH = Reach(distance=0.3, extent=0.05)
RADIUS = CostmapConfig().robot_radius


def rectangle(left, bottom, right, top):
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]], np.float32)


BAR = rectangle(-0.5, -2.0, 0.5, 2.0)
WALL = rectangle(0.0, -9.0, 0.05, 9.0)


def with_zones(*zones):
    return replace(GRID, zones=zones)


def way(grid, T_map_base=HERE, to=(2.0, 0.0)):
    return navigate(costs_on(grid), GoalPoints(np.array(to)), T_map_base, REACH, NavigatorConfig())


def gap(xy, zone):
    """Between points and an upright rectangle [m]."""
    low, high = zone.min(axis=0), zone.max(axis=0)
    return np.linalg.norm(np.maximum(np.maximum(low - xy, xy - high), 0.0), axis=1)


def test_the_way_leads_round_a_zone_with_room_for_the_whole_robot():
    straight, round_it = way(GRID), way(with_zones(BAR))
    assert gap(straight.path, BAR).min() == 0.0
    assert gap(round_it.path, BAR).min() >= RADIUS
    assert round_it.distance > straight.distance + 1.0


def test_beside_a_zone_the_robot_is_slow():
    far, near = planar(-2.0, 2.25, 0.0), planar(0.0, 2.25, 0.0)
    free, beside = (
        [way(grid, T, (2.0, 2.25)).twist.linear for T in (far, near)]
        for grid in (GRID, with_zones(BAR))
    )
    assert beside[0] == free[0]
    assert 0.0 < beside[1] < 0.7 * free[1]


def test_a_zone_across_the_whole_map_leaves_no_way():
    assert way(with_zones(WALL)) is None


def test_a_zone_right_beyond_the_map_holds():
    occupancy = GRID.occupancy.copy()
    occupancy[:-1, 60] = 1.0  # a wall whose only gap is at the upper border
    walled = replace(GRID, occupancy=occupancy)
    over = way(walled)
    assert over is not None and over.path[:, 1].max() > 2.9
    beyond = rectangle(-3.0, 3.05, 3.0, 5.0)
    under = way(replace(walled, zones=(beyond,)))
    assert gap(under.path, beyond).min() >= RADIUS


@pytest.mark.parametrize("x", [-0.45, -0.1, 0.3, 0.49])
def test_a_robot_inside_a_zone_leaves_it_by_the_shortest_way(x):
    inside = planar(x, 0.0, 0.0)
    for goal in ((2.0, 0.0), (-2.0, 0.0)):
        out = way(with_zones(BAR), inside, goal)
        first_out = np.argmax(gap(out.path, BAR) > 0.0)
        depth = 0.5 - np.abs(out.path[:first_out, 0])
        assert (depth <= 0.5 - abs(x) + GRID.resolution).all()
        assert first_out * GRID.resolution <= 1.5 * (0.5 - abs(x)) + 0.15


def test_nothing_in_a_zone_is_gone_to_from_within_it_either():
    assert way(with_zones(BAR), planar(0.45, 0.0, 0.0), (0.0, 1.0)) is None
    seen = np.zeros(GRID.occupancy.shape, np.float32)
    seen[:, 40:60] = 0.5  # not seen yet, in the middle of the zone
    grid = OccupancyGrid(seen, 0.05, np.array([-3.0, -3.0]), (rectangle(-2.0, -9.0, 2.0, 9.0),))
    search = FrontierSearch(FrontierConfig())
    edge = planar(-1.95, 0.0, 0.0)
    search.look(grid, edge, RADIUS)
    found = search.act(grid, costs_on(grid), edge, NavigatorConfig(), None)
    away = gap(found.path[-1:], rectangle(-2.0, -9.0, 2.0, 9.0))[0]
    assert found.distance == 0.0 or away >= RADIUS  # it may look in from where it stands


def test_a_robot_that_touches_a_zone_gets_away_from_it_and_not_through():
    beside = planar(0.55, 0.0, 0.0)
    away = way(with_zones(BAR), beside)
    assert away.path[-1][0] > 1.5
    thin = planar(-0.1, 0.0, 0.0)
    assert way(with_zones(WALL), thin) is None
    assert way(with_zones(WALL), thin, (-2.0, 0.0)) is not None


def test_a_zone_hides_nothing_that_stands_behind_it():
    occupancy = GRID.occupancy.copy()
    occupancy[:, 70:72] = 1.0  # a wall at x = 0.5 m
    strip = rectangle(0.1, -0.5, 0.45, 0.5)
    seen = navigate(
        costs_on(replace(GRID, occupancy=occupancy, zones=(strip,))),
        GoalPoints(np.array([[0.55, 0.0]]), seen_from=np.array([[-2.0, 0.0]])),
        HERE,
        Reach(distance=1.2, extent=0.2),
        NavigatorConfig(),
    )
    assert seen is not None and seen.path[-1][0] < 0.1


def test_zones_far_beyond_the_map_change_nothing():
    far = with_zones(BAR + np.float32(100.0))
    np.testing.assert_array_equal(way(far).path, way(GRID).path)


def test_without_zones_nothing_is_closed():
    costmap = build_costmap(GRID, CostmapConfig())
    assert costmap.closed is None
    assert costmap.room(np.array([3, 4])) == costmap.clearance[3, 4]
