"""Closer looks at what may be the goal, on an empty floor."""

import numpy as np
import pytest

from nav.config import NavigatorConfig
from nav.costmap import LiveCostmap
from vizbot.config import InspectionConfig
from vizbot.core.geometry import planar
from vizbot.core.types import OccupancyGrid
from vizbot.objectnav.approach import NavigationState
from vizbot.objectnav.inspection import Inspection
from vizbot.perception.sightings import Sightings

GRID = OccupancyGrid(np.zeros((240, 240), np.float32), 0.05, np.array([-6.0, -6.0]))
COSTMAP = LiveCostmap(NavigatorConfig().costmap).update(GRID)
THETA = 0.5
CONFIG = InspectionConfig()


def sightings(*elements):
    """Of elements (x, similarity, camera's x) ahead, each of a keyframe of its own."""
    x, similarities, cameras = (np.array(column) for column in zip(*elements, strict=True))
    count = np.arange(len(x), dtype=np.int32)
    return Sightings(
        np.column_stack([x, np.zeros(len(x)), np.full(len(x), 0.5)]),
        similarities.astype(np.float32),
        count,
        count,
        np.column_stack([cameras, np.zeros(len(x))]),
        np.zeros(len(x), np.float32),
    )


@pytest.fixture
def closer():
    inspection = Inspection(CONFIG)

    def act(seen, x=0.0, detour=np.inf):
        T_map_base = planar(x, 0.0, 0.0)
        navigator = NavigatorConfig()
        state = NavigationState(GRID, COSTMAP, T_map_base, None)
        return inspection.navigate(seen, THETA, state, navigator, detour)

    return act


def test_what_looked_like_the_goal_from_afar_is_driven_up_to_once(closer):
    seen = sightings((3.5, 0.48, 0.0))
    way = closer(seen)
    assert way is not None and not way.arrived
    np.testing.assert_allclose(way.goal_xy, [3.5, 0.0])
    assert 3.5 - CONFIG.reach.distance <= way.path[-1, 0] <= 3.5
    assert closer(seen, x=2.6) is None
    assert closer(seen) is None


def test_what_is_not_much_like_the_goal_is_left_alone(closer):
    assert closer(sightings((3.5, 0.4, 0.0))) is None


def test_what_was_seen_from_near_by_often_enough_is_left_alone(closer):
    near = [(3.6, 0.1, 2.0), (3.4, 0.1, 2.2), (3.5, 0.1, 2.4)]
    assert closer(sightings((3.5, 0.48, 0.0), *near[:2])) is not None
    assert closer(sightings((3.5, 0.48, 0.0), *near)) is None


def test_what_is_far_off_waits_unless_the_robot_is_on_its_way(closer):
    seen = sightings((5.0, 0.48, 1.0))
    assert closer(seen, x=-1.0, detour=3.0) is None
    assert closer(seen, x=1.5, detour=3.0) is not None
    assert closer(seen, x=-1.0, detour=3.0) is not None


def test_the_next_place_comes_after_the_nearest(closer):
    seen = sightings((3.0, 0.48, 0.0), (-4.0, 0.6, 0.0))
    np.testing.assert_allclose(closer(seen).goal_xy, [3.0, 0.0])
    np.testing.assert_allclose(closer(seen, x=2.0).goal_xy, [-4.0, 0.0])
