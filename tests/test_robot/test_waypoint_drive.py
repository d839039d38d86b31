"""The drive to a place that somebody named."""

import numpy as np

from vizbot.behaviours.waypoint_drive import WaypointDrive
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome
from vizbot.core.types import OccupancyGrid
from vizbot.objectnav.tasks import Waypoint

GRID = OccupancyGrid(np.zeros((120, 120), np.float32), 0.05, np.array([-3.0, -3.0]))
HERE = planar(0.0, 0.0, 0.0)


def decided(place, grid, T_map_base):
    return WaypointDrive(Config()).decide(place, grid, T_map_base)


def test_a_place_is_driven_to_as_near_as_there_is_room():
    free = decided(Waypoint(2.0, 0.0), GRID, HERE)
    assert free.activity == "going to a place" and free.ended is None
    assert np.linalg.norm(free.navigation.path[-1] - [2.0, 0.0]) <= 0.2
    occupancy = GRID.occupancy.copy()
    occupancy[50:70, 95:105] = 1.0  # a table of 1 x 0.5 m around the place
    taken = OccupancyGrid(occupancy, GRID.resolution, GRID.origin)
    near = decided(Waypoint(2.0, 0.0), taken, HERE)
    assert 0.3 < np.linalg.norm(near.navigation.path[-1] - [2.0, 0.0]) <= 1.7


def test_at_a_place_the_robot_is_done_whichever_way_it_looks():
    for heading in (0.0, 2.0, -2.0):
        decision = decided(Waypoint(1.0, 0.0), GRID, planar(0.9, 0.0, heading))
        assert decision.ended is not None and decision.ended[0] is Outcome.ARRIVED
        assert decision.ended[1].startswith("0.1 m")


def test_a_place_behind_walls_all_around_is_given_up():
    occupancy = GRID.occupancy.copy()
    occupancy[40:80, 95] = occupancy[40, 95:] = occupancy[79, 95:] = 1.0
    occupancy[40:80, -1] = 1.0
    closed = OccupancyGrid(occupancy, GRID.resolution, GRID.origin)
    decision = decided(Waypoint(2.8, 0.0), closed, HERE)
    assert decision.ended == (Outcome.GAVE_UP, "the map shows no way to that place")


def test_a_place_at_a_wall_is_not_gone_to_from_the_other_side_of_it():
    occupancy = GRID.occupancy.copy()
    occupancy[:, 80] = 1.0  # the wall at 1 m
    occupancy[:10, 80] = 0.0  # has a door far off
    walled = OccupancyGrid(occupancy, GRID.resolution, GRID.origin)
    decision = decided(Waypoint(1.2, 0.0), walled, HERE)
    assert decision.navigation.path[-1][0] > 1.05
