from dataclasses import dataclass, field

import numpy as np
import pytest

from nav.navigator import Navigation
from vizbot.config import ObjectNavConfig
from vizbot.core.types import STOP, OccupancyGrid
from vizbot.objectnav import objectnav

GRID = OccupancyGrid(np.zeros((2, 2), np.float32), 0.05, np.zeros(2))
POINTS = np.array([[1.0, 0.0, 0.5], [2.0, 0.0, 0.5], [3.0, 0.0, 0.5]])
CONFIG = ObjectNavConfig(threshold_step=0.001, threshold_floor=0.8)


@dataclass
class ScriptedNavigator:
    """Reaches only goals whose x is in `reachable`, and the distant point if `open_space`."""

    reachable: set[float]
    open_space: bool
    asked: list[list[float]] = field(default_factory=list)

    def navigate(self, grid, goals, T_map_base):
        self.asked.append(goals[:, 0].tolist())
        for i, goal in enumerate(goals):
            if goal[0] in self.reachable:
                return navigation_to(goal, i)
        return None

    def explore(self, grid, T_map_base):
        return navigation_to(np.array([-50.0, -50.0]), 0) if self.open_space else None


def navigation_to(goal, index):
    path = np.array([[0.0, 0.0], goal])
    return Navigation(
        path=path, twist=STOP, goal_index=index, goal=goal, distance=1.0, arrived=False
    )


def decide(similarities, navigator, threshold=0.3):
    scores = np.array(similarities, np.float32)
    return objectnav(POINTS, scores, threshold, GRID, np.eye(4), navigator, CONFIG)


def test_what_is_above_the_threshold_is_driven_to():
    action = decide([0.1, 0.35, 0.2], ScriptedNavigator({1.0, 2.0, 3.0}, open_space=True))
    assert not action.exploring
    assert action.navigation.goal[0] == 2.0
    assert action.threshold == 0.3


def test_all_that_is_above_the_threshold_is_offered_at_once():
    navigator = ScriptedNavigator({1.0}, open_space=True)
    decide([0.31, 0.35, 0.2], navigator)
    assert navigator.asked == [[1.0, 2.0]]


def test_with_nothing_above_the_threshold_the_robot_explores():
    action = decide([0.29, 0.1, 0.2], ScriptedNavigator({1.0}, open_space=True))
    assert action.exploring
    assert action.navigation.goal[0] == -50.0


def test_what_cannot_be_reached_is_explored_for():
    assert decide([0.1, 0.35, 0.2], ScriptedNavigator(set(), open_space=True)).exploring


def test_in_a_closed_space_the_threshold_sinks_to_the_best_that_can_be_reached():
    navigator = ScriptedNavigator({3.0}, open_space=False)
    action = decide([0.29, 0.35, 0.2601], navigator)
    assert action.navigation.goal[0] == 3.0
    assert action.threshold == pytest.approx(0.26)
    # Only a grown set of goals is asked for again.
    assert navigator.asked == [[2.0], [1.0, 2.0], [1.0, 2.0, 3.0]]


def test_below_the_floor_nothing_is_found():
    assert decide([0.1, 0.2, 0.23], ScriptedNavigator({1.0, 2.0, 3.0}, open_space=False)) is None
    assert decide([0.1, 0.2, 0.245], ScriptedNavigator({3.0}, open_space=False)) is not None
