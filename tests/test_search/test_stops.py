"""Where the robot stops before a thing that it believes: the true camera has it in the picture."""

import numpy as np
import pytest

from nav.costmap import LiveCostmap
from nav.goal_region import sees
from nav.navigator import Navigation
from sim_stubs.realsense.software_device import COLOR
from tests.test_search.test_belief_search import CONFIG, SOFA, believed, room
from vizbot.core.geometry import invert, planar, transform
from vizbot.core.observer import Outcome
from vizbot.objectnav import paper_search
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.stops import BAND, FARTHEST, NEAR, WITHIN, Stops
from vizbot.perception.sightings import Sightings

AT = np.array([5.625, 2.125])
"""Where the thing is, near the east wall."""
FAR, NEAR_BY = planar(1.5, 2.1, 0.0), planar(4.6, 2.1, 0.0)


def shown(T_map_base, low, high):
    """How much of a thing from one height to another the camera has in the picture [m]."""
    heights = np.arange(low, high, 0.01)
    x, y = AT
    points = np.column_stack([np.full_like(heights, x), np.full_like(heights, y), heights])
    ahead, down, depth = transform(invert(T_map_base @ CONFIG.mount.T_base_cam), points).T
    u, v = COLOR.fx * ahead / depth + COLOR.cx, COLOR.fy * down / depth + COLOR.cy
    inside = (depth > 0) & (u >= 0) & (u < COLOR.width) & (v >= 0) & (v < COLOR.height)
    return 0.01 * np.count_nonzero(inside)


def stopped(T_map_base, height, grid=None, probability=0.95, seen_from=(3.0, 2.0)):
    """Where the robot is when its search ends, and how that does."""
    plan, frontiers = room()
    grid = plan if grid is None else grid
    search = BeliefSearch(CONFIG, frontiers)
    belief = believed({tuple(AT): probability}, seen_from=seen_from, height=height)
    for _ in range(40):
        decision = search.go(SOFA, belief, grid, T_map_base)
        if decision.ended is not None:
            return T_map_base, decision.ended
        if isinstance(decision.navigation, Navigation) and not decision.navigation.arrived:
            x, y = decision.navigation.path[-1]
            T_map_base = planar(x, y, np.arctan2(AT[1] - y, AT[0] - x))
    raise AssertionError("the search does not end")


def away(T_map_base):
    return float(np.linalg.norm(T_map_base[:2, 3] - AT))


@pytest.mark.parametrize("start", [FAR, NEAR_BY], ids=["far", "near by"])
@pytest.mark.parametrize(
    ("low", "high", "mean"),
    [(0.0, 0.2, 0.1), (0.0, 0.5, 0.25), (0.93, 2.0, 0.97), (0.0, 1.4, 0.5), (0.0, 1.8, 0.5)],
)
def test_from_the_stop_a_thing_is_in_the_picture_whatever_its_height(low, high, mean, start):
    """A view from near by shows of a window no more than what is above its sill."""
    stop, (outcome, why) = stopped(start, mean)
    assert outcome is Outcome.ARRIVED and why == "95% sure, from near by"
    assert shown(stop, low, high) >= 0.02
    assert away(stop) <= FARTHEST
    if start is FAR:
        assert away(stop) >= (FARTHEST - BAND if mean > 0.9 else NEAR - BAND)


def test_from_where_the_robot_was_the_window_was_out_of_the_picture():
    facing = planar(*NEAR_BY[:2, 3], 0.0)
    assert away(facing) < 1.1 and shown(facing, 0.93, 2.0) == 0.0


def test_of_what_is_in_the_picture_the_robot_goes_no_farther_away():
    assert np.array_equal(stopped(NEAR_BY, 0.5)[0], NEAR_BY)


def test_behind_a_wall_the_thing_is_seen_from_its_own_side():
    grid, _ = room()
    wall = round((4.9 + 0.25) / 0.05)
    grid.occupancy[: round((3.2 + 0.25) / 0.05), wall : wall + 2] = 1.0
    stop, (outcome, _) = stopped(planar(4.3, 2.1, 0.0), 0.97, grid, seen_from=(5.4, 3.4))
    assert outcome is Outcome.ARRIVED and away(stop) <= FARTHEST
    costmap = LiveCostmap(CONFIG.navigator.costmap).update(grid)
    assert sees(costmap, stop[:2, 3], AT, 0.05) and stop[1, 3] > 2.6


def test_in_a_narrow_room_it_stops_as_far_away_as_there_is_room():
    grid, _ = room()
    grid.occupancy[:, : round((4.7 + 0.25) / 0.05)] = 1.0
    grid.occupancy[: round((1.3 + 0.25) / 0.05)] = 1.0
    grid.occupancy[round((2.9 + 0.25) / 0.05) :] = 1.0
    stop, (outcome, _) = stopped(planar(5.2, 2.1, 0.0), 0.97, grid, seen_from=(5.0, 2.1))
    assert outcome is Outcome.ARRIVED and 0.7 <= away(stop) <= 1.1


def test_where_a_thing_hangs_too_high_the_robot_says_so():
    stop, (outcome, why) = stopped(NEAR_BY, 1.6)
    assert outcome is Outcome.ARRIVED and FARTHEST - BAND <= away(stop) <= FARTHEST
    assert shown(stop, 1.5, 1.7) == 0.0
    assert why == "95% sure, but there is no spot within 2 m to see it from"


def test_where_nothing_within_reach_sees_it_the_robot_says_so():
    grid, _ = room()
    grid.occupancy[:, round((3.5 + 0.25) / 0.05) :] = 1.0
    _, (outcome, why) = stopped(FAR, 0.5, grid)
    assert outcome is Outcome.NOT_FOUND
    assert why == "95% sure, but there is no spot within 2 m to see it from"


def test_a_height_is_in_the_picture_from_the_distance_that_is_told():
    stops = Stops(CONFIG)
    for height in (0.0, 0.1, 0.3, 0.8, 0.97):
        point = height, height + 0.005
        needed = float(stops._to_show(np.array([height]))[0])
        facing = planar(AT[0] - max(needed, 0.3), AT[1], 0.0)
        assert shown(facing, *point) > 0.0, height
        assert stops.sees(height) and needed <= WITHIN
    assert stops.sees(1.1) and not stops.sees(1.3), "a patch shows some of what is beneath"
    least = stops.least(np.array([0.0, 0.1, 0.5, 0.97, 1.6]))
    assert least[0] == pytest.approx(NEAR - BAND) and 0.9 < least[1] < 1.0 and least[2] < 0.3
    assert least[3:] == pytest.approx(FARTHEST - BAND)
    assert [round(stops.reach(height).distance, 2) for height in (0.0, 0.5, 0.97)] == [
        NEAR, NEAR, FARTHEST,
    ]  # fmt: skip


@pytest.mark.parametrize("tilt", [-0.6, 0.6])
def test_what_a_tilted_camera_does_not_see_is_stopped_for_at_the_farthest(tilt):
    mount = CONFIG.mount.model_copy(update={"tilt": tilt})
    stops = Stops(CONFIG.model_copy(update={"mount": mount}))
    height, most = (0.8, FARTHEST) if tilt > 0 else (0.4, NEAR)
    assert stops.least(np.array([height]))[0] == pytest.approx(most - BAND)
    assert stops.sees(0.1 if tilt > 0 else 1.1) and not stops.sees(1.1 if tilt > 0 else 0.1)


def test_by_the_papers_method_the_robot_drives_within_a_metre_whatever_the_height():
    grid, _ = room()
    costmap = LiveCostmap(CONFIG.navigator.costmap).update(grid)
    seen = Sightings(np.array([[*AT, 1.6]]), np.ones(1, np.float32), np.array([[3.0, 2.0]]))
    action = paper_search.decide(seen, 0.5, costmap, NEAR_BY, CONFIG.navigator)
    assert action is not None and not action.navigation.arrived
    assert np.linalg.norm(action.navigation.path[-1] - AT) <= 1.0
    before = planar(4.7, 2.1, 0.0)
    action = paper_search.decide(seen, 0.5, costmap, before, CONFIG.navigator)
    assert action is not None and action.navigation.arrived
