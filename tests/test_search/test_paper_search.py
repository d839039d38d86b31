"""The paper's method, compared with Algorithm 1 written down a second time."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from benchmarks.planner.grids import known_floor, recorded_map, recorded_maps
from nav.config import NavigatorConfig
from nav.costmap import LiveCostmap
from nav.navigator import GoalPoints, Navigation, explore_distant, navigate
from tests.helpers.scripted_robot import ScriptedBase, ticks
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, OccupancyGrid
from vizbot.objectnav import paper_search, reasons
from vizbot.objectnav.paper_search import REACH, PaperSearch, decide
from vizbot.objectnav.tasks import Goal
from vizbot.perception.sightings import Sightings

THETA = 0.27
NAVIGATOR = NavigatorConfig()


def algorithm_1(points, similarities, theta, navigation, distant):
    """Algorithm 1 of the paper, line by line.

    Args:
        points: Elements of M^CLIP.
        similarities: S_q(e) of each (equation 7).
        theta: The threshold.
        navigation: Navigation(M^Depth, g, P), of indices of elements.
        distant: Navigation(M^Depth, g_distant, P).

    Returns:
        a_t, the index of the element it leads to or None, and theta.
    """

    def find(theta):  # equation 8; most similar first, as one of those in a cell is planned to
        found = [e for e in range(len(points)) if similarities[e] > np.float32(theta)]
        return sorted(found, key=lambda e: -similarities[e])

    a_t = None
    g_t = find(theta)
    if g_t:
        a_t = navigation(g_t)
    if not g_t or a_t is None:
        a_t = distant()
        if a_t is not None:
            return a_t, None, theta
        while a_t is None:
            if len(g_t) == len(points):  # the paper's loop would never end
                return None, None, theta
            theta = theta - 0.001
            g_t = find(theta)
            if g_t:
                a_t = navigation(g_t)
    return a_t, g_t[a_t.goal], theta


def seen(*elements):
    """Elements (x, y, similarity, camera's x, camera's y), each of a frame of its own."""
    rows = np.array(elements, float).reshape(-1, 5)
    points = np.column_stack([rows[:, :2], np.full(len(rows), 0.5)])
    scores = rows[:, 2].astype(np.float32)
    return Sightings(points, scores, rows[:, 3:])


def two_rooms(is_open):
    """Rooms from x 0 to 4 and from 4 to 8, 4 m deep; no door between them, and one to the west."""
    occupancy = np.full((100, 180), 0.5, np.float32)
    occupancy[10:90, 10:170] = 1.0
    occupancy[12:88, 12:88] = occupancy[12:88, 92:168] = 0.0
    if is_open:
        occupancy[40:60, 10:12] = 0.0
    return OccupancyGrid(occupancy, 0.05, np.array([-0.5, -0.5]))


NEAR, EAST, FAR = (3.9, 2.0), (3.9, 3.2), (6.0, 2.0)
"""Places before the robot, to its left, and in the other room."""
HERE = planar(1.5, 2.0, 0.0)
AT_WALL = planar(3.2, 2.0, 0.0)


def element(place, similarity, camera=(2.0, 2.0)):
    return (*place, similarity, *camera)


IN_OTHER_ROOM = (7.0, 2.0)
DECISIONS = {
    "an empty map": (seen(), True, HERE),
    "nothing is similar enough": (seen(element(NEAR, 0.26)), True, HERE),
    "one view is": (seen(element(NEAR, 0.28), element(EAST, 0.1)), True, HERE),
    "the nearer of two, not the more similar": (
        seen(element((0.2, 3.9), 0.9), element(NEAR, 0.28)), True, planar(2.5, 2.0, 0.0)
    ),
    "what is found lies in a closed room": (
        seen(element(FAR, 0.4, IN_OTHER_ROOM)), True, HERE
    ),
    "a closed space": (seen(element(NEAR, 0.2341), element(EAST, 0.1)), False, HERE),
    "a closed space, and the most similar out of reach": (
        seen(element(FAR, 0.4, IN_OTHER_ROOM), element(EAST, 0.031)), False, HERE
    ),
    "a closed space, and nothing similar at all": (
        seen(element(NEAR, -0.41), element(EAST, -0.8)), False, HERE
    ),
    "a closed space, and all out of reach": (
        seen(element(FAR, 0.4, IN_OTHER_ROOM), element((6.0, 3.0), 0.1, IN_OTHER_ROOM)), False, HERE
    ),
    "within reach": (seen(element(NEAR, 0.28)), True, AT_WALL),
}  # fmt: skip


def same(ours, theirs):
    """Whether two navigations are the same in every way; None is equal to None."""
    if ours is None or theirs is None:
        return ours is theirs
    return (
        ours.twist == theirs.twist
        and ours.arrived == theirs.arrived
        and np.array_equal(ours.path, theirs.path)
        and np.array_equal(ours.goal_xy, theirs.goal_xy)
    )


def on_recorded_map(path, seed):
    """A robot on the floor of a recorded map, and elements on its walls and furniture.

    The most similar one has 0.15 to 0.35, so that theta is reached, or must be lowered, or neither
    is enough.
    """
    rng, grid = np.random.default_rng(seed), recorded_map(path)
    costmap = LiveCostmap(NAVIGATOR.costmap).update(grid)
    stands_xy = costmap.grid.to_xy(known_floor(costmap))
    places_xy = grid.to_xy(np.argwhere(grid.occupancy == 1.0))
    chosen = places_xy[rng.choice(len(places_xy), 40, replace=False)]
    similarities = rng.uniform(-0.2, rng.uniform(0.15, 0.35), len(chosen))
    cameras = [
        stands_xy[np.argmin(np.abs(np.linalg.norm(stands_xy - place, axis=1) - 1.5))]
        for place in chosen
    ]
    elements = [
        element(place, similarity, camera)
        for place, similarity, camera in zip(chosen, similarities, cameras, strict=True)
    ]
    x, y = stands_xy[rng.integers(len(stands_xy))]
    return seen(*elements), costmap, planar(x, y, rng.uniform(-np.pi, np.pi))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("path", recorded_maps(), ids=lambda path: path.stem)
def test_on_recorded_maps_the_decision_is_that_of_algorithm_1(path, seed):
    assert_decided_by_algorithm_1(*on_recorded_map(path, seed))


@pytest.mark.parametrize("name", DECISIONS)
def test_the_decision_is_that_of_algorithm_1(name):
    sightings, is_open, T_map_base = DECISIONS[name]
    costmap = LiveCostmap(NAVIGATOR.costmap).update(two_rooms(is_open))
    assert_decided_by_algorithm_1(sightings, costmap, T_map_base)


def assert_decided_by_algorithm_1(sightings, costmap, T_map_base):
    def navigation(found):
        goals = GoalPoints(sightings.points[found, :2], None, sightings.seen_from[found])
        return navigate(costmap, goals, T_map_base, REACH, NAVIGATOR)

    a_t, chosen, theta = algorithm_1(
        sightings.points,
        sightings.similarities,
        THETA,
        navigation,
        lambda: explore_distant(costmap, T_map_base, NAVIGATOR),
    )
    action = decide(sightings, THETA, costmap, T_map_base, NAVIGATOR)
    assert same(None if action is None else action.navigation, a_t)
    if action is not None:
        assert action.element == chosen
        assert action.theta == theta


def kind(sightings, costmap, T_map_base):
    action = decide(sightings, THETA, costmap, T_map_base, NAVIGATOR)
    return (
        "none" if action is None
        else "distant" if action.element is None
        else "arrived" if action.navigation.arrived
        else "lowered" if action.theta < THETA
        else f"element {action.element}"
    )  # fmt: skip


def test_the_ten_decisions_are_of_every_kind():
    costmaps = [
        LiveCostmap(NAVIGATOR.costmap).update(two_rooms(is_open)) for is_open in (False, True)
    ]
    kinds = [kind(shown, costmaps[is_open], at) for shown, is_open, at in DECISIONS.values()]
    assert kinds == [
        "distant", "distant", "element 0", "element 1", "distant",
        "lowered", "lowered", "lowered", "none", "arrived",
    ]  # fmt: skip


def test_the_decisions_on_recorded_maps_are_of_more_than_one_kind():
    """What is within reach, and what leaves nothing, is among the ten alone."""
    found = {
        kind(*on_recorded_map(path, seed)).split()[0]
        for path in recorded_maps() for seed in range(5)
    }  # fmt: skip
    assert found == {"element", "lowered", "distant"}


@dataclass
class Closed:
    """A closed space in which only some elements, known by their x, can be reached."""

    reachable: set[int]

    def navigate(self, costmap, goals, *_):
        for i, (x, _) in enumerate(goals.xy):
            if int(x) in self.reachable:
                return Navigation(STOP, np.zeros((1, 2)), i, goals.xy[i], 1.0, False)
        return None


scores = st.floats(-1.0, 1.0, width=32)


@given(st.lists(st.tuples(scores, st.booleans()), max_size=12), st.floats(0.05, 0.9))
def test_theta_found_by_halving_is_theta_lowered_step_by_step(elements, theta):
    sightings = seen(*((i, 0.0, each[0], 0.0, 0.0) for i, each in enumerate(elements)))
    closed = Closed({i for i, (_, reachable) in enumerate(elements) if reachable})

    def navigation(found):
        return closed.navigate(None, SimpleNamespace(xy=sightings.points[found, :2]))

    a_t, chosen, lowered = algorithm_1(
        sightings.points, sightings.similarities, theta, navigation, lambda: None
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paper_search, "navigate", closed.navigate)
        patch.setattr(paper_search, "explore_distant", lambda *_: None)
        action = decide(sightings, theta, None, HERE, NAVIGATOR)
    assert (action is None) == (a_t is None)
    if action is not None:
        assert action.element == chosen
        assert action.theta == lowered


IN_WALL = ((3.92, 2.0), (3.98, 2.0), (3.92, 3.2))
"""Places in the wall between the rooms, which is seen from both."""


@settings(max_examples=40, deadline=None)
@example([(0, 0.25, True), (0, 0.26, False), (2, -0.5, True)])
@given(
    st.lists(
        st.tuples(st.integers(0, 2), st.integers(200, 280).map(lambda i: i / 1000), st.booleans()),
        max_size=5,
    )
)
def test_the_planner_reaches_with_a_lower_theta_what_it_has_reached_with_a_higher(elements):
    cameras = {True: IN_OTHER_ROOM, False: (2.0, 2.0)}
    sightings = seen(*(element(IN_WALL[i], s, cameras[beyond]) for i, s, beyond in elements))
    costmap = LiveCostmap(NAVIGATOR.costmap).update(two_rooms(is_open=False))
    assert explore_distant(costmap, HERE, NAVIGATOR) is None
    assert_decided_by_algorithm_1(sightings, costmap, HERE)


@pytest.fixture
def goal():
    return Goal("sofa", np.ones(1, np.float32), THETA)


def test_one_view_is_driven_to_and_a_stop_within_reach_ends_the_search(goal):
    search, grid = PaperSearch(NAVIGATOR), two_rooms(is_open=True)
    one = seen(element(EAST, 0.1), element(NEAR, 0.28))
    going = search.go(goal, one, grid, HERE)
    assert (going.activity, going.ended, search.answer) == ("going to what was found", None, None)
    assert going.why == "the similarity 0.280 is above theta, 0.270"
    arrived = search.go(goal, one, grid, AT_WALL)
    assert arrived.twist == STOP and arrived.ended[0] is Outcome.ARRIVED
    assert search.answer == 1 and "0.280" in arrived.ended[1]


def test_what_was_lowered_does_not_outlive_the_step(goal):
    search, closed = PaperSearch(NAVIGATOR), two_rooms(is_open=False)
    lowered = search.go(goal, seen(element(NEAR, 0.1)), closed, HERE)
    assert lowered.threshold < 0.1 and lowered.why.endswith(f"; {reasons.NONE_LEFT}")
    opened = search.go(goal, seen(element(NEAR, 0.1)), two_rooms(is_open=True), HERE)
    assert opened.why == "nothing that can be reached is above theta, 0.270"
    assert opened.exploring and opened.threshold == search.threshold(goal) == THETA


def test_with_nothing_to_reach_the_goal_is_not_found(goal):
    search = PaperSearch(NAVIGATOR)
    beyond = seen(element(FAR, 0.4, IN_OTHER_ROOM), element(FAR, 0.1, IN_OTHER_ROOM))
    assert search.threshold(goal) == THETA
    decision = search.go(goal, beyond, two_rooms(is_open=False), HERE)
    assert decision.ended is not None and decision.ended[0] is Outcome.NOT_FOUND
    assert decision.threshold == search.threshold(goal) < 0.1
    assert search.go(goal, seen(), two_rooms(is_open=False), HERE).ended[0] is Outcome.NOT_FOUND


def test_the_setting_chooses_the_method_which_begins_without_a_turn(pipeline_on):
    turning = ticks(pipeline_on(ScriptedBase(), look_around=True), 3)
    assert {step.activity for step in turning} == {"looking around"}
    steps = ticks(pipeline_on(ScriptedBase(), look_around=True, method="paper"), 3)
    assert "looking around" not in {step.activity for step in steps}


def test_by_the_papers_method_a_map_is_ranked_by_the_cosine_alone():
    agreed = [(1.0, 0.0, 0.5, 0.1 * i, 0.0) for i in range(6)]
    sightings = seen(*agreed, (3.0, 0.0, 0.6, 0.0, 0.0))
    assert sightings.answers() == (6, 0)
    assert sightings.answers(first=2) == (2, 6)
