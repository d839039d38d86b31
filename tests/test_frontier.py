import numpy as np
import pytest

from nav.frontier import FrontierConfig, FrontierSearch, frontiers
from nav.navigator import NavigatorConfig
from vizbot.core.geometry import planar
from vizbot.core.types import OccupancyGrid

CONFIG = NavigatorConfig()


@pytest.fixture
def room():
    """A closed room of 4 x 3 m, seen but for a corner of 1 x 0.8 m in the north-east."""
    occupancy = np.full((80, 100), 0.5, np.float32)
    occupancy[10:70, 10:90] = 0.9
    occupancy[11:69, 11:89] = 0.1
    occupancy[53:69, 69:89] = 0.5
    return OccupancyGrid(occupancy, 0.05, np.zeros(2))


def test_the_unseen_corner_is_the_only_frontier(room):
    (point,) = frontiers(room, CONFIG, 0.4)
    assert 3.3 < point[0] < 4.5 and 2.5 < point[1] < 3.5


def test_a_room_seen_whole_has_none(room):
    room.occupancy[53:69, 69:89] = 0.1
    assert len(frontiers(room, CONFIG, 0.4)) == 0


def test_unknown_cells_behind_a_wall_are_no_frontier(room):
    room.occupancy[52, 68:90] = room.occupancy[52:70, 68] = 0.9
    assert len(frontiers(room, CONFIG, 0.4)) == 0


def test_short_gaps_are_left_alone(room):
    room.occupancy[53:69, 69:89] = 0.1
    room.occupancy[30, 40] = 0.5
    assert len(frontiers(room, CONFIG, 0.4)) == 0


def test_the_robot_drives_to_the_corner_looks_once_and_is_done(room):
    search, T_map_base = FrontierSearch(FrontierConfig()), planar(1.0, 1.0, 0.0)
    navigation = None
    for _ in range(200):
        navigation = search.act(room, T_map_base, CONFIG, navigation)
        if navigation is None or navigation.arrived:
            break
        turned = 0.2 * navigation.twist.angular
        T_map_base = T_map_base @ planar(0.2 * navigation.twist.linear, 0.0, turned)
    assert navigation is not None and navigation.arrived
    assert np.linalg.norm(navigation.goal_xy - T_map_base[:2, 3]) <= CONFIG.reach
    assert search.act(room, T_map_base, CONFIG, None) is None


def test_a_frontier_that_cannot_be_reached_is_no_way(room):
    room.occupancy[11:69, 45] = 0.9
    search = FrontierSearch(FrontierConfig())
    assert search.act(room, planar(1.0, 1.0, 0.0), CONFIG, None) is None
