import numpy as np
import pytest

from nav.config import FrontierConfig, NavigatorConfig
from nav.explored_area import ExploredArea
from nav.frontier import FrontierSearch, area_behind, frontiers, gains
from tests.test_nav.test_navigator import costs_on
from vizbot.core.geometry import planar
from vizbot.core.types import OccupancyGrid

NAVIGATOR = NavigatorConfig()
CONFIG = FrontierConfig()
RADIUS = NAVIGATOR.costmap.robot_radius


def grid_of(occupancy):
    return OccupancyGrid(occupancy.astype(np.float32), 0.05, np.zeros(2))


@pytest.fixture
def room():
    """A closed room of 4 x 3 m, measured whole."""
    occupancy = np.full((80, 100), 0.5)
    occupancy[10:70, 10:90] = 0.9
    occupancy[11:69, 11:89] = 0.1
    return grid_of(occupancy)


@pytest.fixture
def looked(room):
    """All but a corner of 1 x 0.8 m in the north-east."""
    mask = np.ones(room.occupancy.shape, bool)
    mask[53:69, 69:89] = False
    return mask


def frontiers_of(grid, looked):
    return frontiers(grid, looked, NAVIGATOR.costmap, CONFIG.min_length)


def explored(truth, T_map_base, search, ticks=400):
    """Drive with ideal kinematics on a map that is known from the start, camera included."""
    navigation, way, turned = None, 0.0, 0.0
    for _ in range(ticks):
        search.look(truth, T_map_base, RADIUS)
        navigation = search.act(truth, costs_on(truth), T_map_base, NAVIGATOR, navigation)
        if navigation is None:
            return T_map_base, way, turned
        angle, step = 0.3 * navigation.twist.angular, 0.3 * navigation.twist.linear
        T_map_base = T_map_base @ planar(step, 0.0, angle)
        way, turned = way + abs(step), turned + abs(angle)
    raise AssertionError("the exploration has not ended")


def test_where_the_camera_has_not_looked_is_the_only_frontier(room, looked):
    [along] = frontiers_of(room, looked)
    assert len(along) > 5
    assert (along > (3.3, 2.5)).all() and (along < (4.5, 3.5)).all()


def test_a_room_that_was_looked_at_has_none_though_depth_has_holes(room, looked):
    looked[:] = True
    room.occupancy[20:30, 20:40] = 0.5
    assert len(frontiers_of(room, looked)) == 0


def test_what_lies_behind_a_wall_is_no_frontier(room, looked):
    room.occupancy[52, 68:90] = room.occupancy[52:70, 68] = 0.9
    assert len(frontiers_of(room, looked)) == 0


def test_short_frontiers_are_left_alone(room, looked):
    looked[:] = True
    looked[30, 40:42] = False
    assert len(frontiers_of(room, looked)) == 0


def test_an_open_door_promises_more_than_a_corner_behind_a_cupboard(room, looked):
    looked[:] = False
    looked[11:69, 11:60] = True
    room.occupancy[11:69, 60] = 0.9
    room.occupancy[30:48, 60] = 0.1
    looked[60:69, 11:16] = False
    door, corner = gains(
        room, looked, np.array([[2.98, 1.95], [0.82, 3.2]]), 1.5, NAVIGATOR.costmap
    )
    assert door > 1.5
    assert corner == pytest.approx(9 * 5 * 0.05**2, rel=0.3)


def test_a_frontier_is_judged_by_its_best_view_not_by_its_middle(room):
    room.occupancy[11:69, 60] = 0.9
    room.occupancy[11:24, 60] = 0.1  # a door at the end of a strip that was not looked at
    search = FrontierSearch(CONFIG)
    search.explored.mask_on(room)[11:69, 11:59] = True
    [along] = frontiers_of(room, search.explored.mask_on(room))
    to_see = gains(room, search.explored.mask_on(room), along, CONFIG.gain_reach, NAVIGATOR.costmap)
    assert to_see[0] < CONFIG.min_gain < to_see.max()
    navigation = search.act(room, costs_on(room), planar(1.5, 2.0, 0.0), NAVIGATOR, None)
    assert navigation is not None
    assert navigation.goal_xy[1] < 1.6
    np.testing.assert_array_equal(search.frontiers_xy, [navigation.goal_xy])


def test_the_share_that_was_seen_counts_what_frontiers_may_show(room, looked):
    search = FrontierSearch(CONFIG)
    costmap, nothing = NAVIGATOR.costmap, np.zeros((0, 2))
    assert search.seen_share is None
    search.count_left(room, nothing, costmap)
    assert search.seen_share == 0.0
    search.explored.mask_on(room)[:] = looked
    points_xy, areas = search.options(room, costmap, 5.0)
    search.count_left(room, points_xy, costmap)
    share = search.seen_share
    assert 0.5 < share < 1.0
    search.give_up(points_xy[np.argmax(areas)])
    search.count_left(room, search.options(room, costmap, 5.0)[0], costmap)
    assert search.seen_share > share
    search.count_left(room, nothing, costmap)
    assert search.seen_share == 1.0


def test_what_two_frontiers_may_show_counts_once(room, looked):
    one, other = np.array([[3.35, 3.0]]), np.array([[4.0, 2.6]])
    corner = 20 * 16 * 0.05**2
    for points_xy in (one, other, np.vstack([one, other]), np.vstack([one] * 3)):
        area = area_behind(room, looked, points_xy, CONFIG.gain_reach, NAVIGATOR.costmap)
        assert area == pytest.approx(corner, rel=0.02)
    apart = looked.copy()
    apart[11:27, 11:31] = False
    both = np.vstack([one, [[1.65, 0.9]]])
    area = area_behind(room, apart, both, 1.5, NAVIGATOR.costmap)
    assert area == pytest.approx(2 * corner, rel=0.02)


def seen_from(room, x=1.0, y=2.0):
    """What one look shows to a camera that faces along x."""
    seen = ExploredArea()
    seen.add_view(room, planar(x, y, 0.0), 1.1, 4.0, 1.3, 0.4, 0.15)
    return seen


def test_a_look_ends_at_an_obstacle(room):
    room.occupancy[11:69, 60] = 0.7
    mask = seen_from(room).mask_on(room)
    assert mask[40, 25:61].all() and not mask[:, 62:].any()
    assert not mask[40, :15].any()


def test_a_look_crosses_short_gaps_of_depth_but_not_the_unknown(room):
    room.occupancy[:, 52:58] = 0.5
    assert seen_from(room).mask_on(room)[40, 60]
    room.occupancy[:, 52:65] = 0.5
    assert not seen_from(room).mask_on(room)[40, 66]


@pytest.mark.parametrize("x, y", [(-2.0, 2.0), (2.0, -2.0), (-50.0, 2.0), (50.0, 2.0)])
def test_a_look_from_outside_the_map_adds_nothing(room, x, y):
    assert not seen_from(room, x, y).mask_on(room).any()


def test_what_was_looked_at_stays_when_the_map_grows(room):
    seen = seen_from(room)
    before = seen.mask_on(room).copy()
    grown = OccupancyGrid(
        np.pad(room.occupancy, ((64, 0), (128, 64)), constant_values=np.float32(0.5)),
        0.05,
        np.array([-6.4, -3.2]),
    )
    after = seen.mask_on(grown)
    assert after.sum() == before.sum()
    assert (after[64:, 128:228] == before).all()


def test_in_a_room_the_robot_turns_to_see_it_and_is_done(room):
    _, way, turned = explored(room, planar(2.5, 2.0, 0.0), FrontierSearch(CONFIG))
    assert turned < 4 * np.pi
    assert way < 3.0


def test_a_robot_that_remembers_a_room_looks_at_it_again_and_searches_elsewhere(room):
    search = FrontierSearch(CONFIG)
    for yaw in np.arange(0.0, 2 * np.pi, 0.5):
        search.remember(room, planar(2.5, 2.0, yaw), RADIUS)
    assert len(search.options(room, NAVIGATOR.costmap, 2.5)[0]) == 0
    _, _, turned = explored(room, planar(2.5, 2.0, 0.0), search)
    assert turned > np.pi
    assert search.looked_at.mask_on(room).sum() > 2000


def test_two_rooms_are_explored_one_after_the_other(room):
    room.occupancy[11:69, 49:51] = 0.9
    room.occupancy[30:48, 49:51] = 0.1
    search = FrontierSearch(CONFIG)
    T_map_base, _, _ = explored(room, planar(1.2, 2.0, np.pi), search)
    search.look(room, T_map_base, RADIUS)
    inside = search.explored.mask_on(room)[11:69, 11:89]
    assert inside.mean() > 0.93


def test_a_frontier_that_cannot_be_reached_is_no_way(room):
    room.occupancy[11:69, 45] = 0.9
    search = FrontierSearch(CONFIG)
    T_map_base, _, _ = explored(room, planar(1.2, 2.0, 0.0), search)
    assert T_map_base[0, 3] < 2.2
    assert not search.explored.mask_on(room)[11:69, 47:89].any()


def test_a_frontier_that_stays_though_the_robot_looks_at_it_is_given_up(room):
    search, T_map_base, navigation = FrontierSearch(CONFIG), planar(1.2, 1.0, 0.0), None
    search.explored.mask_on(room)[:] = True
    search.explored.mask_on(room)[53:69, 69:89] = False
    for _ in range(200):  # the camera is blind: nothing is ever looked at
        navigation = search.act(room, costs_on(room), T_map_base, NAVIGATOR, navigation)
        if navigation is None:
            break
        turned = 0.3 * navigation.twist.angular
        T_map_base = T_map_base @ planar(0.3 * navigation.twist.linear, 0.0, turned)
    assert navigation is None


def test_frontiers_right_ahead_of_a_blind_place_are_given_up_though_nothing_faces_them(room):
    search = FrontierSearch(FrontierConfig())
    search.frontiers_xy = np.array([[0.8, 0.2], [0.0, 0.8], [2.0, 0.0], [-0.5, 0.0]])
    points_xy = search.frontiers_xy.copy()
    search.give_up_ahead(planar(0.0, 0.0, 0.0))
    assert search._are_open(points_xy).tolist() == [False, True, True, True]
    search.reopen()
    search.barred_xy = points_xy[2:3]
    assert search._are_open(points_xy).tolist() == [True, True, False, True]
