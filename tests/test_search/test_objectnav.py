from dataclasses import dataclass, field

import numpy as np
import pytest

import vizbot.objectnav.approach
from nav.config import NavigatorConfig, Reach
from nav.costmap import LiveCostmap
from nav.navigator import Navigation
from vizbot.config import AgreementConfig, ObjectNavConfig
from vizbot.core.types import STOP, OccupancyGrid
from vizbot.objectnav.algorithm import Theta, objectnav
from vizbot.objectnav.approach import NavigationState
from vizbot.objectnav.candidates import RunningScores
from vizbot.objectnav.tasks import Goal
from vizbot.perception.sightings import Sightings

GRID = OccupancyGrid(np.zeros((2, 2), np.float32), 0.05, np.zeros(2))
COSTMAP = LiveCostmap(NavigatorConfig().costmap).update(GRID)
POINTS = np.array([[1.0, 0.0, 0.5], [2.0, 0.0, 0.5], [3.0, 0.0, 0.5]])
OWN_SIMILARITY = AgreementConfig(views=1, falloff=0.0, range_doubt=0.0, halving_doubt=0.0)
CONFIG = ObjectNavConfig(threshold_step=0.001, agreement=OWN_SIMILARITY)


@dataclass
class Scripted:
    """Reaches only goals whose x is in `reachable`, and the distant point if `open_space`.

    What is in `from_afar` is reached by the farthest reach alone.
    """

    reachable: set[float]
    open_space: bool
    from_afar: set[float] = field(default_factory=set)
    asked: list[list[float]] = field(default_factory=list)
    costs: list[float] = field(default_factory=list)
    reach: Reach | None = None

    def navigate(self, grid, goals, T_map_base, reach, config, previous):
        goals_xy = goals.xy
        if goals.seen_from is not None:
            np.testing.assert_array_equal(goals.seen_from, goals_xy + 10.0)
        self.asked.append(goals_xy[:, 0].tolist())
        self.costs, self.reach = goals.costs.tolist(), reach
        far = reach == CONFIG.reaches[-1]
        for i, goal_xy in enumerate(goals_xy):
            if goal_xy[0] in self.reachable or (far and goal_xy[0] in self.from_afar):
                return Navigation(STOP, np.zeros((1, 2)), i, goal_xy, 1.0, False)
        return None

    def to_suspects_or_unknown(self, sightings, threshold, state):
        distant_xy = np.array([-50.0, -50.0])
        if not self.open_space:
            return None
        return Navigation(STOP, np.zeros((1, 2)), None, distant_xy, 1.0, False)


@pytest.fixture
def decide(monkeypatch):
    def decide_with(similarities, scripted, threshold=0.3, lower_first=False):
        monkeypatch.setattr(vizbot.objectnav.approach, "navigate", scripted.navigate)
        sightings = Sightings(
            POINTS,
            np.array(similarities, np.float32),
            np.zeros(3, np.int32),
            np.zeros(3, np.int32),
            POINTS[:, :2] + 10.0,
            np.zeros(3, np.float32),
        )
        return objectnav(
            Goal("sofa", np.ones(1, np.float32), threshold),
            sightings,
            Theta(threshold, 0.8 * threshold, lower_first),
            NavigationState(GRID, COSTMAP, np.eye(4), None),
            scripted,
            CONFIG,
            NavigatorConfig(),
        )

    return decide_with


def test_what_is_above_the_threshold_is_driven_to(decide):
    action = decide([0.1, 0.35, 0.2], Scripted({1.0, 2.0, 3.0}, open_space=True))
    assert not action.exploring
    assert action.navigation.goal_xy[0] == 2.0
    assert action.threshold == 0.3


def test_all_that_is_above_the_threshold_is_offered_at_once(decide):
    navigator = Scripted({1.0}, open_space=True)
    decide([0.31, 0.35, 0.2], navigator)
    assert navigator.asked == [[1.0, 2.0]]


def test_with_nothing_above_the_threshold_the_robot_explores(decide):
    action = decide([0.29, 0.1, 0.2], Scripted({1.0}, open_space=True))
    assert action.exploring
    assert action.navigation.goal_xy[0] == -50.0


def test_what_cannot_be_reached_is_explored_for(decide):
    assert decide([0.1, 0.35, 0.2], Scripted(set(), open_space=True)).exploring


def test_in_a_closed_space_the_threshold_sinks_to_the_best_that_can_be_reached(decide):
    navigator = Scripted({3.0}, open_space=False)
    action = decide([0.29, 0.35, 0.2601], navigator)
    assert action.navigation.goal_xy[0] == 3.0
    assert action.threshold == pytest.approx(0.26)


def test_below_the_floor_nothing_is_found(decide):
    assert decide([0.1, 0.2, 0.23], Scripted({1.0, 2.0, 3.0}, open_space=False)) is None
    assert decide([0.1, 0.2, 0.245], Scripted({3.0}, open_space=False)) is not None


def test_what_has_no_place_beside_it_is_reached_from_farther_away(decide):
    action = decide([0.1, 0.35, 0.2], Scripted(set(), open_space=True, from_afar={2.0}))
    assert not action.exploring
    assert action.navigation.goal_xy[0] == 2.0


def test_what_cannot_be_reached_from_where_it_was_seen_is_gone_to_from_anywhere(decide):
    navigator = Scripted({2.0}, open_space=True)
    from_anywhere = navigator.navigate

    def navigate(*arguments):
        return None if arguments[-1] is not None else from_anywhere(*arguments)

    navigator.navigate = navigate
    action = decide([0.1, 0.35, 0.2], navigator)
    assert not action.exploring
    assert action.navigation.goal_xy[0] == 2.0


def test_what_is_less_similar_costs_more_way(decide):
    navigator = Scripted({1.0}, open_space=True)
    decide([0.31, 0.36, 0.2], navigator)
    assert navigator.costs == pytest.approx([0.05 * CONFIG.similarity_worth, 0.0], abs=1e-5)


def test_in_a_hurry_the_threshold_sinks_before_more_is_explored(decide):
    action = decide([0.26, 0.1, 0.2], Scripted({1.0}, open_space=True), lower_first=True)
    assert not action.exploring
    assert action.threshold == pytest.approx(0.259)
    assert decide([0.2, 0.1, 0.2], Scripted({1.0}, open_space=True), lower_first=True).exploring


def test_what_lies_on_the_floor_is_reached_from_where_it_is_in_sight(decide, monkeypatch):
    monkeypatch.setitem(globals(), "POINTS", POINTS * (1.0, 1.0, 0.0))
    navigator = Scripted({2.0}, open_space=True)
    decide([0.1, 0.35, 0.2], navigator)
    assert navigator.asked == [[2.0]]
    assert navigator.reach == CONFIG.reaches[-1]


def test_similarities_are_computed_once_for_a_goal_and_anew_for_another():
    east, north = (
        Goal("sofa", np.eye(2, dtype=np.float32)[0], 0.3),
        Goal("bed", np.eye(2, dtype=np.float32)[1], 0.3),
    )
    embeddings = np.array([[1.0, 0.0], [0.6, 0.8], [0.0, 1.0]], np.float32)
    scores = RunningScores()
    assert scores.similarities_to(None, embeddings[:0]).tolist() == []
    assert scores.similarities_to(None, embeddings[:2]).tolist() == [0.0, 0.0]
    assert scores.similarities_to(east, embeddings[:2]) == pytest.approx([1.0, 0.6])
    changed = np.concatenate([np.zeros((2, 2), np.float32), embeddings[2:]])
    assert scores.similarities_to(east, changed) == pytest.approx([1.0, 0.6, 0.0])
    assert scores.similarities_to(north, embeddings) == pytest.approx([0.0, 0.8, 1.0])
    assert scores.similarities_to(None, embeddings).tolist() == [0.0] * 3
