import numpy as np
import pytest

from nav.costmap import CostmapConfig, build_costmap
from nav.keep_out import close_zones
from nav.navigator import NavigatorConfig, Reach, navigate
from vizbot.core.geometry import planar
from vizbot.core.types import OccupancyGrid

GRID = OccupancyGrid(np.zeros((120, 120), np.float32), 0.05, np.array([-3.0, -3.0]))
HERE = planar(-2.0, 0.0, 0.0)
BAR = np.array([[-0.5, -2.0], [0.5, -2.0], [0.5, 2.0], [-0.5, 2.0]], np.float32)
REACH = Reach(distance=0.3, extent=0.05)


def way(grid, T_map_base=HERE, to=(2.0, 0.0)):
    return navigate(grid, np.array(to), T_map_base, REACH, NavigatorConfig())


def gap(xy, zone):
    """Between points and an upright rectangle [m]."""
    low, high = zone.min(axis=0), zone.max(axis=0)
    return np.linalg.norm(np.maximum(np.maximum(low - xy, xy - high), 0.0), axis=1)


def test_the_way_leads_round_a_zone_with_room_for_the_whole_robot():
    straight, round_it = way(GRID), way(close_zones(GRID, [BAR], HERE[:2, 3]))
    assert gap(straight.path, BAR).min() == 0.0
    assert gap(round_it.path, BAR).min() >= CostmapConfig().robot_radius - GRID.resolution
    assert round_it.distance > straight.distance + 1.0


def test_a_zone_across_the_whole_map_leaves_no_way():
    wall = np.array([[0.0, -9.0], [0.4, -9.0], [0.4, 9.0], [0.0, 9.0]], np.float32)
    closed = close_zones(GRID, [wall], HERE[:2, 3])
    assert way(closed) is None


def test_a_robot_inside_a_zone_gets_out_and_then_it_holds():
    inside = planar(0.0, 0.0, 0.0)
    assert way(close_zones(GRID, [BAR], inside[:2, 3]), inside) is not None
    outside = planar(1.0, 0.0, 0.0)
    back = way(close_zones(GRID, [BAR], outside[:2, 3]), outside, (0.0, 0.0))
    assert back is None


def test_a_robot_that_touches_a_zone_gets_away_from_it():
    beside = planar(0.55, 0.0, 0.0)
    found = way(close_zones(GRID, [BAR], beside[:2, 3]), beside)
    assert found is not None
    assert found.path[-1][0] > 1.5


def test_a_zone_hides_nothing_that_stands_behind_it():
    occupancy = GRID.occupancy.copy()
    occupancy[:, 70:72] = 1.0  # a wall at x = 0.5 m
    grid = OccupancyGrid(occupancy, GRID.resolution, GRID.origin)
    strip = np.array([[0.1, -0.5], [0.45, -0.5], [0.45, 0.5], [0.1, 0.5]], np.float32)
    seen = navigate(
        close_zones(grid, [strip], HERE[:2, 3]),
        np.array([[0.55, 0.0]]),
        HERE,
        Reach(distance=1.2, extent=0.2),
        NavigatorConfig(),
        seen_from=np.array([[-2.0, 0.0]]),
    )
    assert seen is not None and seen.path[-1][0] < 0.1


@pytest.mark.parametrize("zones", [[], [BAR + 100.0]])
def test_zones_beyond_the_map_change_nothing(zones):
    assert close_zones(GRID, zones, HERE[:2, 3]) is GRID


def test_closed_cells_keep_their_place_in_the_costmap():
    closed = close_zones(GRID, [BAR], HERE[:2, 3])
    cost = build_costmap(closed, CostmapConfig()).cost
    inside, outside = GRID.to_cells(np.array([0.0, 0.0])), GRID.to_cells(np.array([0.0, 2.5]))
    assert np.isinf(cost[tuple(inside)]) and np.isfinite(cost[tuple(outside)])
