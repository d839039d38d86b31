"""A WC of 2.3 square metres behind a door of 0.92 m, as in homes that others have drawn.

The robot can drive into it and does where something in it is its goal. Exploring alone does not
lead it in: all of its floor is in view from the hallway, and a room that was seen from its door
needs no visit.
"""

import numpy as np
import pytest

from nav.config import FrontierConfig, NavigatorConfig, Reach
from nav.costmap import LiveCostmap
from nav.frontier import FrontierSearch
from nav.navigator import GoalPoints, navigate
from vizbot.core.distance import distance_to_zero
from vizbot.core.geometry import planar
from vizbot.core.types import OccupancyGrid

NAVIGATOR, CONFIG = NavigatorConfig(), FrontierConfig()
RADIUS = NAVIGATOR.costmap.robot_radius
CELL = 0.02
"""Edge of a cell of the plan [m], fine enough for 0.92 m."""
DOOR = 1.7
"""x of the outer face of the door [m]; west of it lies the hallway."""
LOW, HIGH = 3.0, 3.96
"""y of the walls of the WC [m]."""
END = 4.1
"""x of its east wall [m]."""
IN_THE_HALLWAY = planar(0.85, 1.0, np.pi / 2)


def boxed(occupancy, x0, y0, x1, y1, value):
    rows = slice(round((y0 + 0.5) / CELL), round((y1 + 0.5) / CELL))
    columns = slice(round((x0 + 0.5) / CELL), round((x1 + 0.5) / CELL))
    occupancy[rows, columns] = value


def plan(*, drawn_out=0.0, screen=False):
    """A hallway of 1.7 x 7 m with the WC at its side: a radiator in it, and a toilet at its end.

    Args:
        drawn_out: How much too large the map draws what stands there [m].
        screen: Whether half of the WC is hidden from the door.
    """
    occupancy = np.full((round(8 / CELL), round(5.6 / CELL)), 0.9, np.float32)
    boxed(occupancy, 0.0, 0.0, DOOR, 7.0, 0.1)
    boxed(occupancy, DOOR + 0.1, LOW, END, HIGH, 0.1)
    boxed(occupancy, DOOR, LOW + 0.02, DOOR + 0.1, LOW + 0.94, 0.1)
    boxed(occupancy, 2.6, HIGH - 0.16, 3.26, HIGH, 0.9)
    boxed(occupancy, END - 0.8, LOW + 0.28, END, LOW + 0.68, 0.9)
    if screen:
        boxed(occupancy, 2.5, LOW, 2.6, LOW + 0.45, 0.9)
    if drawn_out:
        near = distance_to_zero(occupancy < 0.5) * CELL <= drawn_out
        occupancy[near] = 0.9
    return OccupancyGrid(occupancy, CELL, np.array([-0.5, -0.5]))


def inside(T_map_base):
    x, y = T_map_base[:2, 3]
    return DOOR + 0.1 < x < END and LOW < y < HIGH


def driven(act, T_map_base, ticks=600, seconds=0.1):
    """Poses of an ideal base that does what `act` says until it says nothing, or arrives."""
    poses, navigation = [T_map_base], None
    for _ in range(ticks):
        navigation = act(poses[-1], navigation)
        if navigation is None or navigation.arrived:
            return poses, navigation
        twist = navigation.twist
        poses.append(poses[-1] @ planar(seconds * twist.linear, 0.0, seconds * twist.angular))
    raise AssertionError("the drive has not ended")


def gap(grid, T_map_base):
    """From the rim of the robot to the nearest thing [m]."""
    to_thing = distance_to_zero(grid.occupancy < 0.5) * grid.resolution
    return to_thing[tuple(grid.to_cells(T_map_base[None, :2, 3])[0])] - RADIUS


def explored(grid):
    search, live = FrontierSearch(CONFIG), LiveCostmap(NAVIGATOR.costmap)

    def act(T_map_base, previous):
        search.look(grid, T_map_base, RADIUS)
        return search.act(grid, live.update(grid), T_map_base, NAVIGATOR, previous)

    poses, _ = driven(act, IN_THE_HALLWAY, seconds=0.25)
    return search, poses


def share_seen(search, grid):
    """Share of the floor of the WC that counts as seen."""
    free = np.zeros(grid.occupancy.shape, bool)
    boxed(free, DOOR + 0.1, LOW, END, HIGH, True)
    free &= grid.occupancy < 0.5
    return search.explored.mask_on(grid)[free].mean()


@pytest.mark.parametrize("drawn_out", [0.0, 0.05, 0.1])
def test_the_robot_drives_into_a_wc_for_what_is_in_it(drawn_out):
    grid, seen = plan(drawn_out=drawn_out), plan()
    toilet = GoalPoints(np.array([[END - 0.75, LOW + 0.48]]), None, np.array([[2.0, LOW + 0.48]]))
    costmap = LiveCostmap(NAVIGATOR.costmap).update(grid)
    reach = Reach(distance=0.8, extent=0.5)
    poses, end = driven(
        lambda T, previous: navigate(costmap, toilet, T, reach, NAVIGATOR, previous),
        IN_THE_HALLWAY,
    )
    assert end is not None
    assert end.arrived
    assert inside(poses[-1])
    assert min(gap(seen, T) for T in poses) > 0.02


def test_a_wc_whose_floor_is_in_view_from_the_hallway_is_not_entered():
    grid = plan()
    search, poses = explored(grid)
    assert not any(map(inside, poses))
    assert share_seen(search, grid) > 0.7
    # What is left beside the toilet is worth no look.
    left_xy, _ = search.options(grid, NAVIGATOR.costmap, CONFIG.gain_reach)
    assert not any(x > DOOR and LOW < y < HIGH for x, y in left_xy)


@pytest.mark.slow
def test_what_the_door_does_not_show_of_a_wc_is_looked_at_from_within_its_door():
    grid = plan(screen=True)
    search, poses = explored(grid)
    assert share_seen(search, grid) > 0.8
    assert max(T[0, 3] for T in poses if LOW < T[1, 3] < HIGH) > DOOR - 0.4
