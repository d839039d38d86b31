import numpy as np
import pytest

from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome
from vizbot.core.types import OccupancyGrid
from vizbot.objectnav.search import Search
from vizbot.objectnav.tasks import Goal, Waypoint
from vizbot.perception.sightings import Sightings

GRID = OccupancyGrid(np.zeros((120, 120), np.float32), 0.05, np.array([-3.0, -3.0]))
HERE = planar(0.0, 0.0, 0.0)


def sightings(*elements):
    """Of elements (x, similarity, frame, camera's x) ahead; a frame is a keyframe."""
    x, similarities, frames, seen_from = (
        np.array(column) for column in zip(*elements, strict=True)
    )
    return Sightings(
        np.column_stack([x, np.zeros(len(x)), np.full(len(x), 0.5)]),
        similarities.astype(np.float32),
        frames.astype(np.int32),
        frames.astype(np.int32),
        np.column_stack([seen_from, np.zeros(len(x))]),
        np.zeros(len(x), np.float32),
    )


@pytest.fixture
def goal():
    return Goal("sofa", np.ones(1, np.float32), 0.5)


@pytest.fixture
def search():
    search = Search(Config())
    search.look(GRID, HERE)
    return search


def go(search, goal, seen, grid, T_map_base, frame):
    """A step with every frame."""
    return search.go(goal, seen, grid, T_map_base, frame, frame)


VIEWS = Config().objectnav.agreement.views
LATE = int(Config().objectnav.choosy_share * Config().objectnav.max_steps)


def test_one_view_is_not_gone_to_and_several_are(search, goal):
    one = sightings((1.5, 0.7, 0, 0.0))
    assert go(search, goal, one, GRID, HERE, 0).exploring
    several = sightings(*((1.5, 0.7, frame, 0.1 * frame) for frame in range(VIEWS)))
    decision = go(search, goal, several, GRID, HERE, VIEWS)
    assert decision.activity == "going to what was found"
    np.testing.assert_allclose(decision.navigation.goal_xy, [1.5, 0.0])


def closed(search):
    """The grid with walls around it, all of it looked at."""
    occupancy = GRID.occupancy.copy()
    grid = OccupancyGrid(occupancy, GRID.resolution, GRID.origin)
    occupancy[[0, -1]] = occupancy[:, [0, -1]] = 1.0
    search._frontiers.explored.mask_on(grid)[:] = True
    return grid


def test_a_closer_look_comes_after_large_frontiers_and_before_small_ones(search, goal):
    grid = closed(search)
    looked = search._frontiers.explored.mask_on(grid)
    suspect = sightings((2.7, 0.48, 0, -2.7))
    far = planar(-2.7, 0.0, 0.0)
    looked[60:119, 1:40] = False
    assert go(search, goal, suspect, grid, far, 0).activity == "exploring"
    looked[:] = True
    looked[100:119, 1:17] = False  # 0.8 m^2
    assert go(search, goal, suspect, grid, far, 1).activity == "looking closer"
    seen = sightings((2.7, 0.48, 0, -2.7), *((2.7, 0.2, 1 + i, 0.8 + 0.3 * i) for i in range(3)))
    assert go(search, goal, seen, grid, far, 2).activity == "exploring"


def test_what_may_be_the_goal_is_looked_at_on_the_way(search, goal):
    grid = closed(search)
    search._frontiers.explored.mask_on(grid)[60:119, 1:40] = False
    suspect = sightings((2.3, 0.48, 0, -1.0))
    assert go(search, goal, suspect, grid, HERE, 0).activity == "looking closer"


def test_a_search_begins_choosy_and_settles_for_less(search, goal):
    fair = sightings(*((1.5, 0.55, frame, 0.1 * frame) for frame in range(VIEWS)))
    first = go(search, goal, fair, GRID, HERE, 0)
    assert first.exploring and first.threshold == pytest.approx(1.3 * goal.threshold)
    halfway = go(search, goal, fair, GRID, HERE, LATE // 2)
    assert halfway.exploring and halfway.threshold == pytest.approx(1.125 * goal.threshold)
    late = go(search, goal, fair, GRID, HERE, LATE)
    assert late.activity == "going to what was found"
    assert late.threshold == pytest.approx(0.95 * goal.threshold)


def test_in_a_kept_map_a_search_settles_at_once(goal):
    search = Search(Config(), in_saved_map=True)
    search.look(GRID, HERE)
    alike = sightings(*((1.5, 0.5, frame, 0.1 * frame) for frame in range(VIEWS)))
    assert go(search, goal, alike, GRID, HERE, VIEWS).activity == "going to what was found"


def test_the_robot_closes_in_on_what_it_saw_best_from_where_it_stood(search, goal):
    seen = [(0.4, 0.7, frame, -0.2 * frame) for frame in range(VIEWS)]
    stopped = go(search, goal, sightings(*seen), GRID, HERE, VIEWS)
    assert stopped.activity == "making sure"
    seen += [(0.4, 0.7, VIEWS + 1, 0.0), (1.75, 0.9, VIEWS + 1, 0.0)]
    closing = go(search, goal, sightings(*seen), GRID, HERE, VIEWS + 1)
    assert closing.activity == "closing in"
    assert search.answer == VIEWS + 1
    nearer = go(search, goal, sightings(*seen), GRID, planar(0.3, 0.0, 0.0), VIEWS + 4)
    assert nearer.activity == "closing in"
    there = planar(0.8, 0.0, 0.0)
    assert go(search, goal, sightings(*seen), GRID, there, VIEWS + 8).activity == "making sure"
    seen.append((1.8, 0.8, VIEWS + 9, 0.8))
    arrived = go(search, goal, sightings(*seen), GRID, there, VIEWS + 9)
    assert arrived.ended is not None and arrived.ended[0] is Outcome.ARRIVED
    assert search.answer == len(seen) - 1


def out_of_sight_from_near_by(search, goal, height):
    """Something at this height is closed in on, and not seen again in a whole turn.

    Returns the decision that follows, the elements and the frame.
    """
    seen = [(0.4, 0.7, frame, -0.2 * frame) for frame in range(VIEWS)]
    go(search, goal, sightings(*seen), GRID, HERE, VIEWS)
    seen += [(0.4, 0.7, VIEWS + 1, 0.0), (1.75, 0.9, VIEWS + 1, 0.0)]

    def now():
        elements = sightings(*seen)
        elements.points[VIEWS + 1 :, 2] = height
        return elements

    assert go(search, goal, now(), GRID, HERE, VIEWS + 1).activity == "closing in"
    frame = VIEWS + 8
    for yaw in np.arange(0.0, 7.0, 0.4):
        on_top = planar(0.8, 0.0, float(yaw))
        assert go(search, goal, now(), GRID, on_top, frame).activity == "making sure"
        frame += 1
        seen.append((1.8, 0.1, frame, 0.8))
    return go(search, goal, now(), GRID, planar(0.8, 0.0, np.pi), frame), now(), frame


@pytest.mark.parametrize("height", [0.25, 1.3])
def test_the_robot_goes_back_for_what_is_out_of_the_picture_from_near_by(search, goal, height):
    back, seen, frame = out_of_sight_from_near_by(search, goal, height)
    assert back.activity == "going back" and back.twist.linear > 0
    there = go(search, goal, seen, GRID, planar(0.05, 0.0, np.pi), frame + 5)
    assert there.ended == (Outcome.ARRIVED, "similarity 0.900, seen from near by")
    assert search.answer == VIEWS + 1


def test_the_search_goes_on_when_what_must_be_in_the_picture_is_not(search, goal):
    decision, _, _ = out_of_sight_from_near_by(search, goal, height=0.5)
    assert decision.ended is None and decision.activity != "going back"
    assert search.answer is None


def test_a_carpet_is_not_closed_in_on_below_the_picture(search, goal):
    seen = [(0.4, 0.7, frame, -0.2 * frame) for frame in range(VIEWS)]
    go(search, goal, sightings(*seen), GRID, HERE, VIEWS)
    seen.append((1.75, 0.9, VIEWS + 1, 0.0))
    flat = sightings(*seen)
    flat.points[-1, 2] = 0.05
    assert go(search, goal, flat, GRID, HERE, VIEWS + 1).ended is not None


def test_a_robot_that_cannot_get_nearer_has_seen_enough(search, goal):
    seen = [(0.4, 0.7, frame, -0.2 * frame) for frame in range(VIEWS)]
    go(search, goal, sightings(*seen), GRID, HERE, VIEWS)
    seen += [(0.4, 0.7, VIEWS + 1, 0.0)]
    arrived = go(search, goal, sightings(*seen), GRID, HERE, VIEWS + 1)
    assert arrived.ended is not None and arrived.ended[0] is Outcome.ARRIVED


def test_the_search_goes_on_when_what_was_stopped_for_is_not_in_sight(search, goal):
    seen = [(0.4, 0.7, frame, -0.2 * frame) for frame in range(VIEWS)]
    go(search, goal, sightings(*seen), GRID, HERE, VIEWS)
    seen.append((0.4, 0.1, VIEWS + 1, 0.0))
    frame = VIEWS
    for yaw in np.arange(0.0, 7.0, 0.4):
        frame += 1
        decision = go(search, goal, sightings(*seen), GRID, planar(0.0, 0.0, float(yaw)), frame)
        assert decision.activity == "making sure"
    seen.append((0.4, 0.1, frame, 0.0))
    assert go(search, goal, sightings(*seen), GRID, HERE, frame + 1).activity == "exploring"


def test_positions_that_are_apart_are_told_from_a_turn_on_the_spot():
    seen = sightings(
        (1.0, 0.5, 0, 0.0), (1.0, 0.5, 1, 0.02), (1.0, 0.5, 2, 0.4), (1.0, 0.5, 3, 0.5)
    )
    np.testing.assert_array_equal(seen.by_position(0.3).keyframes, [0, 0, 1, 1])


def test_a_place_is_driven_to_as_near_as_there_is_room(search):
    free = search.drive_to(Waypoint(2.0, 0.0), GRID, HERE)
    assert free.activity == "going to a place" and free.ended is None
    assert np.linalg.norm(free.navigation.path[-1] - [2.0, 0.0]) <= 0.2
    occupancy = GRID.occupancy.copy()
    occupancy[50:70, 95:105] = 1.0  # a table of 1 x 0.5 m around the place
    taken = OccupancyGrid(occupancy, GRID.resolution, GRID.origin)
    near = search.drive_to(Waypoint(2.0, 0.0), taken, HERE)
    assert 0.3 < np.linalg.norm(near.navigation.path[-1] - [2.0, 0.0]) <= 1.7


def test_at_a_place_the_robot_is_done_whichever_way_it_looks(search):
    for heading in (0.0, 2.0, -2.0):
        decision = search.drive_to(Waypoint(1.0, 0.0), GRID, planar(0.9, 0.0, heading))
        assert decision.ended is not None and decision.ended[0] is Outcome.ARRIVED
        assert decision.ended[1].startswith("0.1 m")


def test_a_place_behind_walls_all_around_is_given_up(search):
    occupancy = GRID.occupancy.copy()
    occupancy[40:80, 95] = occupancy[40, 95:] = occupancy[79, 95:] = 1.0
    occupancy[40:80, -1] = 1.0
    closed = OccupancyGrid(occupancy, GRID.resolution, GRID.origin)
    decision = search.drive_to(Waypoint(2.8, 0.0), closed, HERE)
    assert decision.ended == (Outcome.GAVE_UP, "the map shows no way to that place")


def test_a_place_at_a_wall_is_not_gone_to_from_the_other_side_of_it(search):
    occupancy = GRID.occupancy.copy()
    occupancy[:, 80] = 1.0  # the wall at 1 m
    occupancy[:10, 80] = 0.0  # has a door far off
    walled = OccupancyGrid(occupancy, GRID.resolution, GRID.origin)
    decision = search.drive_to(Waypoint(1.2, 0.0), walled, HERE)
    assert decision.navigation.path[-1][0] > 1.05
