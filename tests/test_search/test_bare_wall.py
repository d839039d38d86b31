"""A wall of which depth shows nothing, and what the robot makes of being blind before it."""

import numpy as np
import pytest

from mapping.occupancy.depth_mapper import DepthMapper
from nav.config import FrontierConfig
from tests.test_search.plan_robot import (
    BARE,
    MATT,
    MOUNT,
    PlanWorld,
    plan_config,
    plan_goal,
    robot_on,
)
from vizbot.behaviours.progress_guard import ProgressGuard
from vizbot.behaviours.recovery import VisionRecovery
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome
from vizbot.core.types import OccupancyGrid, Tracking
from vizbot.perception.depth_loss import unseen_ahead

VIEW = FrontierConfig()


def bare_room():
    """A room of 5 m by 5 m in two halves, with bare walls on two sides."""
    plan = np.zeros((50, 50), np.uint8)
    plan[0] = plan[-1] = plan[:, 0] = plan[:, -1] = MATT
    plan[25, :18] = plan[25, 28:] = MATT
    plan[25:, -1] = plan[0, 10:40] = BARE
    world = PlanWorld(plan)
    world.start_at(1.0, 1.0, 0.3)
    return world


def searched(robot, most=600):
    goal, steps = plan_goal(), []
    while len(steps) < most and not (steps and steps[-1].ended):
        steps.append(robot.tick(goal))
    return steps


@pytest.mark.slow
def test_a_bare_wall_that_the_map_has_a_hole_for_stops_no_search(monkeypatch):
    # Without the guard on progress, which would end it as well.
    monkeypatch.setattr(ProgressGuard, "instead_of", lambda self, decision, *a: decision)
    steps = searched(robot_on(bare_room(), [(2.0, 3.0, 0.4)]))
    assert any("blind" in step.activity for step in steps)
    assert steps[-1].ended is not None and steps[-1].ended[0] is Outcome.ARRIVED


def test_after_a_turn_that_brings_depth_back_the_blind_place_is_known_once():
    vision = VisionRecovery(5.0, 0.5)
    for yaw, lost_for in ((0.0, 0.3), (0.0, 5.1), (0.3, 5.7)):
        vision.decide(lost_for, Tracking.TRACKING, planar(1.0, 0.0, yaw))
    assert vision.turned_away_from() == []
    vision.decide(None, Tracking.TRACKING, planar(1.0, 0.0, 0.6))
    first, *_ = vision.turned_away_from()
    assert np.array_equal(first, planar(1.0, 0.0, 0.0))
    assert vision.turned_away_from() == []


def test_a_robot_that_goes_blind_in_a_turn_turns_on_and_not_back():
    for before, turns in ((0.3, -1), (-0.3, 1), (0.0, 1)):
        vision = VisionRecovery(5.0, 0.5)
        vision.decide(None, Tracking.TRACKING, planar(0.0, 0.0, before))
        vision.decide(0.3, Tracking.TRACKING, planar(0.0, 0.0, 0.0))
        turning = vision.decide(5.1, Tracking.TRACKING, planar(0.0, 0.0, 0.0))
        assert turning.twist.angular == 0.5 * turns


def test_depth_that_comes_back_without_a_turn_or_elsewhere_says_nothing_of_the_place():
    for T_map_after in (planar(0.0, 0.0, 0.05), planar(2.0, 0.0, 1.0)):
        vision = VisionRecovery(5.0, 0.5)
        vision.decide(3.0, Tracking.TRACKING, planar(0.0, 0.0, 0.0))
        vision.decide(None, Tracking.TRACKING, T_map_after)
        assert vision.turned_away_from() == []


def test_what_is_unseen_ahead_is_where_free_floor_ends_and_nothing_known_stands():
    occupancy = np.full((60, 60), 0.5, np.float32)
    occupancy[:, 30:38] = 0.2  # free for 0.8 m ahead
    occupancy[40:, 38] = 0.9  # a wall is known on the left
    grid = OccupancyGrid(occupancy, 0.1, np.array([-3.0, -3.0]))
    points = unseen_ahead(grid, planar(0.0, 0.0, 0.0), VIEW)
    assert len(points) and np.abs(points[:, 0] - 0.85).max() < 0.11
    occupancy[:] = 0.2
    assert len(unseen_ahead(grid, planar(0.0, 0.0, 0.0), VIEW)) == 0


def test_an_inferred_obstacle_is_occupied_until_depth_shows_floor_there():
    world = PlanWorld(np.zeros((60, 60), np.uint8))  # nothing but floor
    world.start_at(3.0, 3.0, 0.0)
    world.read()
    mapper, ahead = DepthMapper(plan_config().perception.depth_mapper), np.array([1.53, 0.04])

    def occupancy():
        grid = mapper.grid()
        return grid.occupancy[tuple(grid.to_cells(ahead))]

    mapper.infer_obstacle(planar(0.0, 0.0, 0.0), ahead[None])
    assert occupancy() > 0.65
    for _ in range(4):
        mapper.add_scan(0, MOUNT, MOUNT, world.scan())
    assert occupancy() < 0.5
